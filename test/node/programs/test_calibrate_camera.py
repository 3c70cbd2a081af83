"""calibrate_camera.py on simulated videos and photos, and what it says about bad ones."""
import subprocess
import sys

import cv2
import numpy as np
import pytest
import yaml
from aruco_ar.calibration.calibrate import corners_apart
from aruco_ar.simulation.robot import Camera
from calibrate_camera import MAX_FRAMES, FrameFile, main
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


@pytest.mark.parametrize('arguments, words', [
    (['none.mp4'], ['There is no file "none.mp4"']),
    (['{text}'], ['text.mp4" is neither a video nor a photo']),
    (['{gray}'], ['None of 1 frames shows two tags of DICT_6X6_250', '--dictionary NAME']),
    (['{gray}', '--charuco', '6x8'], ['None of 1 frames shows 8 corners of a board of 6 x 8 squares',
                                      '--dictionary NAME', '--charuco 6x8 is another board than 8x6']),
    (['{gray}', '{small}'], ['frames of 64 x 48 pixels, and those before it have 640 x 480']),
    (['{gray}', '--dictionary', 'DICT_7'], ['DICT_7']),
    (['{gray}', '--charuco', '1x1'], ['"1x1" is no board', '5x7:0.75'])])
def test_what_cannot_be_used_is_refused_by_name(package, tmp_path, arguments, words):
    (tmp_path / 'text.mp4').write_text('no video')
    cv2.imwrite(str(tmp_path / 'gray.png'), np.full((480, 640, 3), 90, np.uint8))
    cv2.imwrite(str(tmp_path / 'small.png'), np.full((48, 64, 3), 90, np.uint8))
    names = {'text': tmp_path / 'text.mp4', 'gray': tmp_path / 'gray.png', 'small': tmp_path / 'small.png'}
    done = subprocess.run([sys.executable, package + '/src/calibrate_camera.py',
                           *(argument.format(**names) for argument in arguments)],
                          cwd=str(tmp_path), capture_output=True, text=True)
    assert done.returncode != 0 and not (tmp_path / 'camera.yaml').exists()
    for word in words:
        assert word in done.stderr
    assert 'Traceback' not in done.stderr
