"""The Lens that a CameraInfo describes, and what can be wrong with a CameraInfo."""
import time

import numpy as np
import pytest
import rospy
from aruco_ar import InputError
from aruco_ar.simulation.robot import Camera
from aruco_node.health import faults
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages.camera_info import NO_CALIBRATION, info_of_frames, info_topics, lens_from_info
from aruco_node.messages.wall_messages import camera_info
from aruco_node.nodes import camera_lens
from aruco_node.nodes.camera_lens import CameraLens
from aruco_node.parameters.parameters import read
from aruco_node.parameters.settings import LensSettings, PoseSettings
from sensor_msgs.msg import CameraInfo, RegionOfInterest
from std_msgs.msg import Header

CAMERA = Camera(distortion=[-0.3, 0.1, 0.001, -0.001, 0.0])
SIZE = (640, 480)


def info(**changes):
    message = camera_info(CAMERA, None)
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def test_the_lens_is_that_of_the_camera_info():
    lens = lens_from_info(info(), SIZE)
    assert (lens.width, lens.height, lens.fisheye) == (640, 480, False)
    np.testing.assert_allclose(lens.matrix, CAMERA.matrix)
    np.testing.assert_allclose(lens.distortion, CAMERA.distortion)


def test_a_lens_that_folds_back_within_the_image_is_told():
    folded, notes = [-0.35, 0.15, 0.0, 0.0, -0.03], {}
    message = info(D=folded, K=[300.0, 0, 320, 0, 300, 240, 0, 0, 1])
    lens_from_info(message, SIZE, notes=notes)
    assert 'its distortion folds back, so 2' in notes['blind'] and notes['blind'].endswith('lens:=ignore.')
    for usual in info(), info(D=folded), info(distortion_model='equidistant', D=[0.1, 0.01, 0.0, 0.0]):
        notes = {}
        lens_from_info(usual, SIZE, notes=notes)
        assert not notes


def test_frames_that_one_program_has_turned_are_named():
    for size, scale in ((480, 640), 1.0), ((240, 320), 0.5):
        with pytest.raises(InputError, match='for frames of 640 x 480 pixels, but the frames have '
                                             '480 x 640: one of the two is turned.*calibrate_live.launch'):
            lens_from_info(info(), size, scale=scale)
    with pytest.raises(InputError, match='Calibrate the camera at the size at which it runs'):
        lens_from_info(info(), (480, 320))


def test_a_rectified_image_has_another_matrix_and_no_distortion():
    lens = lens_from_info(info(P=[500.0, 0, 310, 0, 0, 510, 240, 0, 0, 0, 1, 0]), SIZE, rectified=True)
    np.testing.assert_allclose(lens.matrix, [[500, 0, 310], [0, 510, 240], [0, 0, 1]])
    assert not np.any(lens.distortion)


@pytest.mark.parametrize('changes', [{}, {'distortion_model': 'equidistant', 'D': [0.1, 0.01, 0.0, 0.0]},
                                     {'distortion_model': 'rational_polynomial', 'D': [0.1] * 8}, {'D': []},
                                     {'distortion_model': 'equidistant', 'D': []}])
def test_all_distortion_models_are_supported(changes):
    lens = lens_from_info(info(**changes), SIZE)
    assert lens.fisheye == (changes.get('distortion_model') == 'equidistant')
    assert len(lens.distortion) == (4 if lens.fisheye else len(changes.get('D', CAMERA.distortion)))
    assert np.all(np.isfinite(lens.rays(lens.project(np.array([[0.1, 0.2, 1.0]])))))


FOUR, FIVE, EIGHT = [0.1, 0.01, 0.002, 0.001], [-0.3, 0.1, 0.001, -0.001, 0.05], [0.1] * 8


@pytest.mark.parametrize('model, coefficients, used, read_as', [
    ('fisheye', FOUR, FOUR, 'equidistant'), ('kannala_brandt', FOUR, FOUR, 'equidistant'),
    ('Kannala-Brandt', [], [0.0] * 4, 'equidistant'), ('equidistant', [*FOUR, 0.0], FOUR, None),
    ('none', [], [], 'the lens has none'), ('none', [0.0] * 5, [], 'the lens has none'),
    ('none', FIVE, [], 'coefficients are not used'), ('pinhole', [], [], 'no distortion'),
    ('pinhole', FIVE, FIVE, 'plumb_bob'), ('radtan', FOUR, FOUR, 'plumb_bob'),
    ('radtan', FIVE, FIVE, 'plumb_bob'),
    ('Brown Conrady', FIVE, FIVE, 'plumb_bob'), ('plumb_bob', EIGHT, EIGHT, 'rational_polynomial'),
    ('radtan', EIGHT, EIGHT, 'rational_polynomial'), ('rational_polynomial', FIVE, FIVE, 'plumb_bob'),
    ('inverse_brown_conrady', [0.0] * 5, [], 'no distortion'), ('Mirror Ball', [], [], 'no distortion'),
    ('plumb_bob', [0.0] * 7, [0.0] * 5, None), ('', EIGHT, EIGHT, None), ('rational_polynomial', [], [], None)])
def test_other_names_and_numbers_are_read_in_the_one_sensible_way(model, coefficients, used, read_as):
    notes, is_fisheye = {}, read_as == 'equidistant' or model == 'equidistant'
    lens = lens_from_info(info(distortion_model=model, D=coefficients), SIZE, notes=notes)
    assert lens.fisheye == is_fisheye and lens.distortion.tolist() == used
    if read_as is None:
        assert not notes
    else:
        sentence, = notes.values()
        assert '"%s"' % model in sentence and read_as in sentence
    usual = info(distortion_model='equidistant' if is_fisheye else 'plumb_bob' if len(used) < 8 else
                 'rational_polynomial', D=used)
    points, notes = np.array([[0.3, 0.2, 1.0], [-0.2, 0.1, 1.0]]), {}
    np.testing.assert_allclose(lens.project(points), lens_from_info(usual, SIZE, notes=notes).project(points))
    assert not notes


@pytest.mark.parametrize('has_p', [False, True])
def test_a_rectified_image_without_a_p_has_the_k_and_no_distortion(has_p):
    notes, message = {}, info() if has_p else info(P=[0.0] * 12)
    lens = lens_from_info(message, SIZE, rectified=True, notes=notes)
    np.testing.assert_allclose(lens.matrix, CAMERA.matrix)
    assert not lens.bends and ('P' in notes) == (not has_p)


def test_a_camera_info_without_a_size_is_for_frames_whose_middle_is_its_center():
    notes = {}
    np.testing.assert_allclose(lens_from_info(info(width=0, height=0), SIZE, notes=notes).matrix, CAMERA.matrix)
    assert 'what size' in notes['size']
    with pytest.raises(InputError, match='for what size'):
        lens_from_info(info(width=0, height=0), (800, 600))


def test_a_resized_frame_has_the_same_rays():
    points = np.array([[0.1, 0.2, 1.0], [-0.3, 0.1, 2.0]])
    whole, half = lens_from_info(info(), SIZE), lens_from_info(info(), (320, 240), scale=0.5)
    # The middle of the first pixel is (0, 0), and its outer corner is (-0.5, -0.5).
    np.testing.assert_allclose(half.project(points) + 0.5, (whole.project(points) + 0.5) / 2)


@pytest.mark.parametrize('size', [(0, 0), (0, 480), (640, 0)])
def test_the_size_of_a_region_of_interest_is_enough(size):
    message = info(width=size[0], height=size[1])
    message.roi.width, message.roi.height = SIZE
    np.testing.assert_allclose(lens_from_info(message, SIZE).matrix, CAMERA.matrix)


def test_binning_and_a_region_of_interest_are_taken_into_account():
    message = info(binning_x=2, binning_y=2)
    message.roi.x_offset, message.roi.y_offset, message.roi.width, message.roi.height = 100, 80, 400, 320
    lens = lens_from_info(message, (200, 160))
    fx, cx, cy = CAMERA.matrix[0, 0], CAMERA.matrix[0, 2], CAMERA.matrix[1, 2]
    np.testing.assert_allclose(lens.matrix,
                               [[fx / 2, 0, (cx - 100) / 2], [0, fx / 2, (cy - 80) / 2], [0, 0, 1]])


@pytest.mark.parametrize('message, words', [
    (CameraInfo(), 'for what size'), (info(K=[0.0] * 9), 'K is not a camera matrix'),
    (info(K=[float('nan')] * 9), 'K is not a camera matrix'),
    (info(width=1280, height=960), 'for frames of 1280 x 960'),
    (info(K=[500.0, 0, 320, 0, 500, 240, 0, 0, 0]), 'K is not a camera matrix'),
    (info(K=[500.0, 500, 320, 500, 500, 240, 0, 0, 1]), 'K is not a camera matrix'),
    # What image_publisher invents for a webcam.
    (info(K=[1.0, 0, 320, 0, 1, 240, 0, 0, 1]), 'focal length is 1 px, which no lens has'),
    (info(K=[500.0, 0, 320, 0, 1, 240, 0, 0, 1]), 'focal length is 1 px, which no lens has'),
    (info(K=[7e4, 0, 320, 0, 7e4, 240, 0, 0, 1]), 'focal length is 7e.04 px'),
    (info(K=[500.0, 0, 320, 0, 1400, 240, 0, 0, 1]), 'focal lengths 500 and 1400 px'),
    (info(K=[500.0, 0, 700, 0, 500, 240, 0, 0, 1]), r'center at \(700, 240\)'),
    (info(D=[0.1] * 3), '"plumb_bob" with 3 coefficients'),
    (info(D=[float('inf')] * 5), 'not all numbers: inf, '),
    (info(D=[0.1, 0.0, float('nan'), 0.0, 0.0]), 'coefficients .*, D, are not all numbers: 0.1, 0, nan, 0, 0'),
    (info(D=[float('nan')] * 10000), 'not all numbers: nan, '),
    (info(distortion_model='inverse_brown_conrady', D=[0.1, 0, 0, 0, 0]), '"inverse_brown_conrady" with 5'),
    (info(distortion_model='thin_prism_fisheye', D=[0.0] * 8), '"thin_prism_fisheye" with 8 coefficients'),
    (info(distortion_model='mirror ball'), '"mirror ball"')])
def test_a_wrong_camera_info_is_explained(message, words):
    with pytest.raises(InputError, match=words) as error:
        lens_from_info(message, SIZE)
    assert error.value.kind


@pytest.mark.parametrize('topic, setting, rectified', [
    ('/camera/rgb/image_raw', 'auto', False), ('/camera/rgb/image_rect_color', 'auto', True),
    ('/camera/image_rect', 'auto', True), ('/camera/image_rect', False, False), ('/usb/image', True, True)])
def test_a_rectified_topic_is_recognized_by_its_name(topic, setting, rectified):
    settings = read(PoseSettings, {'rectified': setting}.get)
    calibration = CameraLens(settings, topic)
    assert calibration.rectified == rectified
    assert calibration.topic == topic.rpartition('/')[0] + '/camera_info'
    assert info_topics('/sim/front/Scene') == ('/sim/front/camera_info', '/sim/front/Scene/camera_info')


def test_a_camera_info_that_is_not_published_is_explained_once(monkeypatch):
    told, computed = [], []
    monkeypatch.setattr(rospy, 'loginfo', lambda text, *values: told.append(text % values))
    monkeypatch.setattr(camera_lens, 'lens_from_info',
                        lambda *arguments: computed.append(1) or lens_from_info(*arguments))
    monkeypatch.setattr(faults, '_logged_kinds', set())
    calibration = CameraLens(LensSettings(), '/camera/rgb/image_raw')
    header = Header()
    assert calibration.info(SIZE, header, 1.0) is None and not told  # it may still come
    calibration._subscriber.since = time.monotonic() - SILENCE_S
    for _ in range(3):
        assert calibration.info(SIZE, header, 1.0) is None
    calibration._on_info(info(K=[0.0] * 9))
    for _ in range(3):
        assert calibration.info(SIZE, header, 1.0) is None
        with pytest.raises(InputError, match='K is not a camera matrix') as error:
            calibration.lens(SIZE, 1.0)
        assert error.value.kind == NO_CALIBRATION
    assert len(computed) == 1  # not for each frame
    assert told[0] == 'Nothing is published on ~camera_info. /camera/rgb/camera_info: nothing arrives on it. ' \
        'Start the camera with its calibration.'
    assert told[1].startswith('Nothing is published on ~camera_info. /camera/rgb/camera_info: its K is not a')
    assert len(told) == 2
    calibration._on_info(info())
    assert calibration.info(SIZE, header, 1.0).K == info().K


def made(message, size, scale=1.0):
    header = Header(stamp=rospy.Time(7), frame_id='eye')
    found = info_of_frames(message, size, header, scale)
    assert found.header is header
    return found


def test_the_camera_info_of_whole_frames_is_that_of_the_camera():
    for message in info(), info(binning_x=1, binning_y=1), info(roi=RegionOfInterest(width=640, height=480)):
        found = made(message, SIZE)
        message.header = found.header
        assert found == message


def test_the_camera_info_of_resized_and_cut_frames_describes_the_same_lens():
    stereo = info(P=[500.0, 0, 310, -40, 0, 510, 240, 0, 0, 0, 1, 0])
    cut, halved = RegionOfInterest(40, 20, 300, 400, False), {'binning_x': 2, 'binning_y': 2}
    for changes, size, scale in (({}, (320, 240), 0.5), ({'roi': cut}, (400, 300), 1.0),
                                 (halved, (320, 240), 1.0), (halved, (160, 120), 0.5)):
        for is_rectified in True, False:
            message = info(P=stereo.P, **changes)
            found = made(message, size, scale)
            assert ((found.width, found.height), found.D) == (size, message.D)
            whole = lens_from_info(message, size, is_rectified, scale)
            np.testing.assert_allclose(lens_from_info(found, size, is_rectified).matrix, whole.matrix)
        assert found.P[3] / found.P[0] == pytest.approx(-40 / 500)  # the baseline, in meters


def test_a_camera_info_without_a_size_gets_that_of_the_frames():
    found = made(info(width=0, height=0), SIZE)
    assert (found.width, found.height) == SIZE
    np.testing.assert_allclose(found.K, CAMERA.matrix.ravel())
