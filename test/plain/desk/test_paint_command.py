"""aruco-ar paint, on videos and photos of a simulated wall."""
import os
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar.calibration.camera_file import camera_yaml
from aruco_ar.geometry.lens import Lens
from aruco_ar.painting.video_writer import video_writer
from aruco_ar.simulation.robot import Camera, Path, Pose
from aruco_desk.command import RIGHT, USAGE, WRONG, main
from rig.accuracy.drives import LIVELY, WALL, drive

RATE = 25
GREEN = (0, 200, 0)


@pytest.fixture(scope='module')
def frames():
    return list(drive(LIVELY, 12, noise=2.0))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with a green picture."""
    monkeypatch.chdir(tmp_path)
    cv2.imwrite('green.png', np.full((60, 90, 3), GREEN, np.uint8))
    return tmp_path


def film(path, images):
    with video_writer(str(path), RATE, 'a clip') as add:
        for image in images:
            add(image)


def read(path):
    """(all frames of a video, frames per second)."""
    capture, found = cv2.VideoCapture(str(path)), []
    good, frame = capture.read()
    while good:
        found.append(frame)
        good, frame = capture.read()
    return found, capture.get(cv2.CAP_PROP_FPS)


def assert_green_inside(painted, frame):
    """That the area of a drive's Frame is green, and that all around it is nearly as it was."""
    mask = cv2.fillConvexPoly(np.zeros(painted.shape[:2], np.uint8), np.int32(frame.corners.round()), 255)
    inside, outside = cv2.erode(mask, np.ones((9, 9))) > 0, cv2.dilate(mask, np.ones((15, 15))) == 0
    off = np.abs(painted.astype(int) - frame.image).max(axis=2)
    assert np.abs(painted[inside].astype(int) - GREEN).max() < 30
    assert np.median(off[outside]) < 12


def test_a_video_is_painted_frame_by_frame_and_keeps_its_rate(folder, frames, capsys):
    film('clip.mp4', [frame.image for frame in frames])
    assert main(['paint', 'clip.mp4', '--picture', 'green.png']) == RIGHT
    assert capsys.readouterr().out == (
        'Wrote clip-painted.mp4: the picture is in 12 of 12 frames, between tags of DICT_6X6_250.\n')
    painted, rate = read('clip-painted.mp4')
    assert len(painted) == len(frames) and rate == RATE
    for image, frame in zip(painted, frames):
        assert_green_inside(image, frame)
    assert sorted(os.listdir('.')) == ['clip-painted.mp4', 'clip.mp4', 'green.png']  # and no draft


@pytest.mark.skipif(not os.path.isdir('/proc/self/fd'), reason='elsewhere, paths are text')
def test_a_name_that_is_not_utf_8_is_no_problem(folder, frames):
    film('clip.mp4', [frame.image for frame in frames[:3]])
    os.rename('clip.mp4', b'caf\xe9.mp4')
    assert main(['paint', os.fsdecode(b'caf\xe9.mp4')]) == RIGHT
    os.rename(b'caf\xe9-painted.mp4', 'painted.mp4')
    assert len(read('painted.mp4')[0]) == 3


def test_a_photo_is_painted(folder, frames, capsys):
    cv2.imwrite('wall.png', frames[0].image)
    assert main(['paint', 'wall.png', '--picture', 'green.png', '--out', 'deep/painted.png']) == RIGHT
    assert 'Wrote deep/painted.png: the picture is in 1 of 1 frames,' in capsys.readouterr().out
    assert_green_inside(cv2.imread('deep/painted.png'), frames[0])


@pytest.mark.parametrize('dictionary, found', [
    ('DICT_4X4_50', 'DICT_4X4_50'), ('DICT_APRILTAG_36h11', 'DICT_APRILTAG_36h11'),
    ('DICT_6X6_1000', 'DICT_6X6_250'), ('DICT_ARUCO_ORIGINAL', 'DICT_ARUCO_ORIGINAL')])
def test_the_dictionary_need_not_be_named(folder, capsys, dictionary, found):
    frames = list(drive(LIVELY, 3, noise=2.0, wall=replace(WALL, dictionary=dictionary)))
    film('clip.mp4', [frame.image for frame in frames])
    assert main(['paint', 'clip.mp4', '--picture', 'green.png']) == RIGHT
    assert 'in 3 of 3 frames, between tags of %s.' % found in capsys.readouterr().out
    for image, frame in zip(read('clip-painted.mp4')[0], frames):
        assert_green_inside(image, frame)


def test_a_camera_is_filmed_into_a_file(folder, capsys):
    frames = drive(LIVELY, 9, wall=replace(WALL, dictionary='DICT_4X4_50'))
    film('camera.mp4', [frame.image for frame in frames])
    assert main(['paint', '--camera', 'camera.mp4', '--out', 'live.mp4', '--picture', 'green.png']) == RIGHT
    # By the first six, the dictionary was found.
    assert 'in 3 of 3 frames, between tags of DICT_4X4_50.' in capsys.readouterr().out


def test_settings_are_those_of_the_nodes(folder, frames):
    cv2.imwrite('wall.png', frames[0].image)
    assert main(['paint', 'wall.png', '--picture', 'green.png', '--opacity', '.5', '--out', 'half.png']) == 0
    middle = tuple(frames[0].corners.mean(axis=0).round().astype(int)[::-1])
    half = (np.array(GREEN) + frames[0].image[middle]) / 2
    assert np.abs(cv2.imread('half.png')[middle] - half).max() < 5


def test_a_calibration_bends_the_picture_as_the_lens_does(folder):
    """Straight rims would be off by several pixels."""
    camera = Camera(640, 480, distortion=[-0.45, 0.2, 0, 0, 0])
    frame = next(drive(Path(Pose(-1.6, 0.35, -0.2), ((1, 0, 0),)), 1, distortion=camera.distortion))
    cv2.imwrite('wall.png', frame.image)
    (folder / 'camera.yaml').write_text(camera_yaml(
        Lens(1280, 960, np.diag([2, 2, 1]) @ camera.matrix + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]],
             np.array(camera.distortion, float)), 'some'))
    greens = []
    for options in [], ['--calibration', 'camera.yaml']:
        assert main(['paint', 'wall.png', '--picture', 'green.png', '--out', 'out.png', *options]) == RIGHT
        greens.append(np.abs(cv2.imread('out.png').astype(int) - GREEN).max(axis=2) < 40)
    lens = Lens(640, 480, camera.matrix, np.array(camera.distortion, float))
    straight = lens.undistort(frame.corners)
    rim = np.concatenate([np.linspace(a, b, 50) for a, b in zip(straight, np.roll(straight, -1, axis=0))])
    true = cv2.fillPoly(np.zeros((480, 640), np.uint8), [np.int32(lens.distort(rim).round())], 1) > 0
    least, most = (change(true.astype(np.uint8), np.ones((5, 5))) for change in (cv2.erode, cv2.dilate))
    wrong = [(least > green).sum() + (green > most).sum() for green in greens]
    assert wrong[0] > 100 and wrong[1] == 0


@pytest.mark.parametrize('arguments, words', [
    (['nothing.mp4'], 'There is no file "nothing.mp4"'),
    (['green.png', '--light', 'mtch'], 'The parameter --light is "mtch"; it must be one of full, match'),
    (['green.png', '--opacity', 'much'], 'The parameter --opacity is "much"; it must be a number from 0 to 1'),
    (['green.png', '--ids', '1,2,3'], 'The parameter --ids is "1,2,3"'),
    (['green.png', '--picture', 'none.png'], 'The picture ".*/test_what_.*/none.png" is not a file'),
    (['green.png', '--wall', 'none.npz'], '/test_what_.*/none.npz'),
    (['green.png', '--out', 'painted.doc'], 'Name a file such as painted.png'),
    (['green.png', '--out', 'green.png'], '"green.png" would replace what is painted on'),
    (['text.mp4'], '"text.mp4" is neither a video nor a photo'),
    (['clip.mp4', '--out', 'clip.avi'], 'A video is written as MP4'),
    (['clip.mp4', '--out', 'none/clip.mp4'], r'The video "none/clip.mp4" cannot be written \(.*No such file'),
    (['green.png', '--calibration', 'text.mp4'], 'The file "text.mp4"'),
])
def test_what_cannot_be_done_is_said_in_a_sentence_and_nothing_is_written(folder, frames, capsys, arguments,
                                                                         words):
    (folder / 'text.mp4').write_text('this is no video')
    film('clip.mp4', [frames[0].image])
    before = {path: path.read_bytes() for path in folder.iterdir()}
    assert main(['paint', *arguments]) == USAGE
    assert re.search(words, capsys.readouterr().err)
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize('options, words', [
    (['--dictionary', 'DICT_4X4_50'], 'aruco-ar: 4 tags of DICT_6X6_.* Give --dictionary DICT_6X6_'),
    (['--ids', '1,2,3,9'], 'Of the tags 1, 2, 3, 9, only 1, 2, 3 are in sight; other tags in sight are 4')])
def test_a_picture_that_is_in_no_frame_is_explained(folder, frames, capsys, options, words):
    film('clip.mp4', [frame.image for frame in frames])
    assert main(['paint', 'clip.mp4', *options]) == WRONG
    out, err = capsys.readouterr()
    assert 'the picture is in 0 of 12 frames' in out
    assert re.search(words, err)
