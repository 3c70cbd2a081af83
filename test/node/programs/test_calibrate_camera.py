"""calibrate_camera.py on simulated videos and photos, and what it says about bad ones."""
import os
import struct
import subprocess
import sys

import cv2
import numpy as np
import PIL.Image
import pytest
import yaml
from aruco_ar.calibration.calibrate import corners_apart
from aruco_ar.calibration.sheets import CharucoBoard
from aruco_ar.calibration.views import is_spread
from aruco_ar.painting.picture_file import ORIENTATION
from aruco_ar.painting.sources import open_source
from aruco_ar.simulation.robot import Camera
from aruco_program.calibrate_command import MAX_FRAMES, FrameFile, main
from rig.accuracy.sheets import BARREL, frames_of, lens_of_file


def test_a_video_of_a_sheet_makes_a_file_that_tells_the_lens(tmp_path, capsys):
    path, out = str(tmp_path / 'sheet.avi'), str(tmp_path / 'camera.yaml')
    video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), 10, (640, 480))
    for frame in frames_of(BARREL, tmp_path / 'wall.yaml'):
        video.write(frame)
    video.release()
    main([path, '--out', out, '--name', 'web: cam #1 \U0001f600'])
    said = capsys.readouterr().out
    assert '36 frames of 640 x 480 pixels' in said and 'coverage' in said and 'held out' in said
    assert 'Wrote %s' % out in said
    lens = lens_of_file(out)
    assert lens.matrix[0, 0] == pytest.approx(BARREL.matrix[0, 0], rel=0.01)
    assert corners_apart(lens, BARREL.lens).max() < 0.5
    with open(out) as file:
        assert yaml.safe_load(file)['camera_name'] == 'web: cam #1 \U0001f600'


@pytest.mark.parametrize('count', [400, 401, 799, 801])
def test_of_a_long_video_frames_are_chosen_evenly(tmp_path, count):
    path = str(tmp_path / 'numbers.avi')
    video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), 10, (32, 32))
    for number in range(count):
        video.write(np.full((32, 32, 3), 250 * number // count, np.uint8))
    video.release()
    frames = FrameFile(path)
    levels = [frame.mean() for frame in frames]
    assert len(levels) == frames.__length_hint__() and MAX_FRAMES / 2 < len(levels) <= MAX_FRAMES
    assert np.ptp(levels) > 240


def test_photos_of_a_charuco_board_tell_the_lens_of_a_fisheye(tmp_path):
    camera = Camera(fov=1.6, distortion=[0.02, -0.01, 0.0, 0.0], fisheye=True)
    board = cv2.aruco.CharucoBoard((6, 5), 1.0, 0.7, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100))
    cv2.imwrite(str(tmp_path / 'board.png'), board.generateImage((1200, 1000)))
    content = 'dictionary: DICT_4X4_50\ntags: [{id: 0, x: 0.5, y: 0.1, side: 0.01}]\n' \
              'posters: [{image: board.png, x: 0, y: 1, width: 1.08, height: 0.9}]'
    paths = []
    for number, frame in enumerate(frames_of(camera, tmp_path / 'wall.yaml', content)):
        paths.append(str(tmp_path / ('%02d.png' % number)))
        cv2.imwrite(paths[-1], frame)
    out = str(tmp_path / 'fisheye.yaml')
    main([*paths, '--fisheye', '--charuco', '6x5:0.7', '--dictionary', 'DICT_5X5_100', '--out', out])
    lens = lens_of_file(out)
    assert lens.fisheye and lens.matrix[0, 0] == pytest.approx(camera.matrix[0, 0], rel=0.01)
    assert corners_apart(lens, camera.lens).max() < 0.5


def test_photos_of_which_some_are_turned_are_used_as_the_camera_stored_them(tmp_path, capsys):
    paths = []
    for number, frame in enumerate(frames_of(BARREL, tmp_path / 'wall.yaml')):
        paths.append(str(tmp_path / ('%02d.jpg' % number)))
        exif = PIL.Image.Exif()
        exif[ORIENTATION] = 6 if number % 3 == 0 else 1
        PIL.Image.fromarray(frame[:, :, ::-1]).save(paths[-1], quality=95, exif=exif)
    out = str(tmp_path / 'camera.yaml')
    main([*paths, '--out', out])
    said = capsys.readouterr().out
    assert '36 frames of 640 x 480 pixels' in said
    assert '12 of the files' in said and '00.jpg", ask to be turned' in said
    lens = lens_of_file(out)
    assert lens.matrix[0, 0] == pytest.approx(BARREL.matrix[0, 0], rel=0.01)
    assert corners_apart(lens, BARREL.lens).max() < 0.6


def test_a_video_that_asks_to_be_turned_is_read_in_one_known_way(tmp_path):
    path, frame = str(tmp_path / 'portrait.mp4'), np.zeros((96, 160, 3), np.uint8)
    frame[:, :80] = 255  # its left half
    video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'mp4v'), 10, (160, 96))
    for _ in range(3):
        video.write(frame)
    video.release()
    with open(path, 'r+b') as file:
        data = file.read()
        file.seek(data.index(b'tkhd') + 44)  # the matrix, for a turn by 90 degrees clockwise
        file.write(struct.pack('>9i', 0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30))
    file = FrameFile(path)
    assert file.is_turned
    for stored in file:
        assert stored.shape == (96, 160, 3) and stored[:, :70].min() > 200 > 50 > stored[:, 90:].max()
    painted = open_source(path).at(0.0)
    assert painted.shape == (160, 96, 3) and painted[:70].min() > 200 > 50 > painted[90:].max()


@pytest.mark.clips
@pytest.mark.parametrize('negated', [False, True])
def test_a_real_board_is_found_white_on_black_too(package, negated):
    path = package + '/../shared/videos/turned.avi'
    if not os.path.isfile(path):
        pytest.skip('the clip %s is missing' % os.path.normpath(path))
    board = CharucoBoard('DICT_4X4_50', 4, 5, 0.75)
    views = [board.view(255 - frame if negated else frame) for frame in FrameFile(path)]
    assert sum(len(view.points) == 12 for view in views) >= 35
    assert sum(is_spread(view, board.points) for view in views) >= 46


@pytest.mark.parametrize('arguments, words', [
    (['none.mp4'], ['There is no file "none.mp4"']),
    (['sheet'], ['"sheet" is a folder. Give the video or the photos in it: sheet/*.']),
    (['/dev/null'], ['"/dev/null" is not a file but a folder, pipe or device']),
    (['{text}'], ['text.mp4" is neither a video nor a photo']),
    (['{gray}'], ['None of 1 frames shows two tags of DICT_6X6_250', '--dictionary NAME']),
    (['{gray}', '--charuco', '6x8'], ['None of 1 frames shows 8 corners of a board of 6 x 8 squares',
                                      '--dictionary NAME', '--charuco 6x8 is another board than 8x6']),
    (['{gray}', '{small}'], ['frames of 64 x 48 pixels, and those before it have 640 x 480']),
    (['{gray}', '--dictionary', 'DICT_7'], ['DICT_7']),
    (['{gray}', '--charuco', '1x1'], ['"1x1" is no board', '5x7:0.75'])])
def test_what_cannot_be_used_is_refused_by_name(package, tmp_path, arguments, words):
    (tmp_path / 'text.mp4').write_text('no video')
    (tmp_path / 'sheet').mkdir()
    cv2.imwrite(str(tmp_path / 'gray.png'), np.full((480, 640, 3), 90, np.uint8))
    cv2.imwrite(str(tmp_path / 'small.png'), np.full((48, 64, 3), 90, np.uint8))
    names = {'text': tmp_path / 'text.mp4', 'gray': tmp_path / 'gray.png', 'small': tmp_path / 'small.png'}
    done = subprocess.run([sys.executable, package + '/nodes/calibrate_camera.py',
                           *(argument.format(**names) for argument in arguments)],
                          cwd=str(tmp_path), capture_output=True, text=True)
    assert done.returncode != 0 and not (tmp_path / 'camera.yaml').exists()
    for word in words:
        assert word in done.stderr
    assert 'Traceback' not in done.stderr


def photos(folder, dictionary, count=6, ids=range(6), side=80, border=1, mirrored=False, board=None, others=()):
    """The paths of photos of a sheet of tags, or of a ``board`` of (columns, rows), which moves a little.

    ``others``: ids of tags of DICT_4X4_50 on the same sheet.
    """
    table = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    paths = []
    for number in range(count):
        photo = np.full((480, 640, 3), 170, np.uint8)
        if board:
            drawn = cv2.aruco.CharucoBoard(board, 1.0, 0.75, table).generateImage((400, 440), marginSize=10)
            photo[20:460, 100 + 10 * number:500 + 10 * number] = drawn[..., None]
        else:
            photo[30:450, 40:600] = 240
            small = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
            for place, (each, tag_id) in enumerate([(table, tag_id) for tag_id in ids]
                                                   + [(small, tag_id) for tag_id in others]):
                tag = cv2.aruco.generateImageMarker(each, tag_id, side, borderBits=border)
                y, x = 70 + 4 * number + 160 * (place // 3), 70 + 8 * number + 160 * (place % 3)
                photo[y:y + side, x:x + side] = tag[..., None]
        noise = np.random.RandomState(number).normal(0, 3, photo.shape)
        photo = np.clip(np.round(photo + noise), 0, 255).astype(np.uint8)
        paths.append(str(folder / ('photo%d.png' % number)))
        cv2.imwrite(paths[-1], photo[:, ::-1] if mirrored else photo)
    return paths


MIRRORING = ('are mirrored in the image, so they cannot be read. If the camera or its driver mirrors or flips '
             'the image, turn off this mirroring.')
LOOKS_FOR = 'are in sight, but calibrate_camera looks for tags of DICT_6X6_250. Give --dictionary '
ONE_CELL = ('but calibrate_camera looks for one 1 cell wide. Print other tags: rosrun unit5 '
            'artag_generator.py.')
ASKED = 'Is it the right dictionary (--dictionary NAME)?'
OF_BOARD = ['--charuco', '5x6']


@pytest.mark.parametrize('shown, options, words', [
    ({'dictionary': 'DICT_6X6_250', 'mirrored': True}, [],
     'px wide. 6 tags of DICT_6X6_250 (0, 1, 2, 3, 4, 5) ' + MIRRORING),
    ({'dictionary': 'DICT_4X4_50'}, [],
     '6 tags of DICT_4X4_50 (0, 1, 2, 3, 4, 5) ' + LOOKS_FOR + 'DICT_4X4_50.'),
    ({'dictionary': 'DICT_6X6_250', 'border': 2}, [], 'have a black border 2 cells wide, ' + ONE_CELL),
    ({'dictionary': 'DICT_5X5_100', 'board': (5, 6)}, OF_BOARD, LOOKS_FOR + 'DICT_5X5_'),
    ({'dictionary': 'DICT_6X6_250', 'board': (5, 6), 'mirrored': True}, OF_BOARD, MIRRORING),
    # The right tags, but too few or too small, or a board of other squares.
    ({'dictionary': 'DICT_6X6_250', 'ids': [3]}, [], 'px wide. ' + ASKED),
    ({'dictionary': 'DICT_6X6_250', 'ids': [3], 'others': [1, 2, 4]}, [], 'px wide. ' + ASKED),
    ({'dictionary': 'DICT_6X6_250', 'side': 18}, [], 'px wide. ' + ASKED),
    ({'dictionary': 'DICT_6X6_250', 'ids': []}, [], 'px wide. ' + ASKED),
    # One photo may show anything.
    ({'dictionary': 'DICT_4X4_50', 'count': 1}, [], 'px wide. ' + ASKED)])
def test_tags_that_are_not_those_of_the_sheet_are_named_with_the_remedy(tmp_path, shown, options, words):
    with pytest.raises(SystemExit, match='None of . frames shows ') as ended:
        main([*photos(tmp_path, **shown), *options, '--out', str(tmp_path / 'camera.yaml')])
    assert words in str(ended.value) and ':=' not in str(ended.value)
