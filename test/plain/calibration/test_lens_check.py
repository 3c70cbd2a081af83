"""A calibration that does not fit the camera is told from views of tags in one plane."""
import numpy as np
import pytest
from aruco_ar import Lens, Tag
from aruco_ar.calibration.lens_check import LensCheck
from rig.accuracy.views import LENSES, MATRIX, SIZE, sheet, views_of

pytestmark = pytest.mark.long


def tags_of(view):
    return [Tag(tag_id, np.float32(corners)) for tag_id, corners in view.points.items()]


def show(check, views, lens):
    """Show views to a LensCheck, through a lens that is taken for theirs."""
    for number, view in enumerate(views):
        for part in 0.0, 0.03:  # the camera is still
            work = check.update(number + part, tags_of(view), lens)
            if work is not None:
                work()


def checked(lens, truth, noise=0.15, tilt=0.5):
    """The hint after many views of four tags through a lens that is taken for another."""
    check = LensCheck()
    show(check, views_of(truth, sheet(2, 2, gap=3.0), count=50, noise=noise, tilt=tilt), lens)
    return check.hint


@pytest.mark.parametrize('name', ['no distortion', 'barrel', 'webcam'])
def test_the_right_calibration_fits(name):
    assert checked(LENSES[name], LENSES[name]) is None
    assert checked(LENSES[name], LENSES[name], noise=1.0) is None


@pytest.mark.parametrize('factor', [0.6, 0.8, 1.2, 2.0])
def test_another_focal_length_does_not_fit(factor):
    wrong = Lens(*SIZE, MATRIX * [[factor, 1, 1], [1, factor, 1], [1, 1, 1]], np.zeros(5))
    hint = checked(wrong, LENSES['no distortion'])
    assert hint.startswith('The calibration does not fit this camera, so poses are wrong. The tags are off by ')
    assert hint.endswith('Calibrate it with calibrate_live.launch.')


def test_nothing_is_said_of_tags_that_all_face_the_camera():
    wrong = Lens(*SIZE, MATRIX * [[1.2, 1, 1], [1, 1.2, 1], [1, 1, 1]], np.zeros(5))
    assert checked(wrong, LENSES['no distortion'], tilt=0.05) is None


def test_another_calibration_is_checked_anew():
    truth = LENSES['no distortion']
    check, views = LensCheck(), views_of(truth, sheet(2, 2, gap=3.0), count=50)
    wrong = Lens(*SIZE, MATRIX * [[1.5, 1, 1], [1, 1.5, 1], [1, 1, 1]], np.zeros(5))
    for lens in wrong, truth:
        show(check, views, lens)
        assert (check.hint is None) == (lens is truth)


def test_a_late_result_says_nothing_of_another_calibration():
    truth = LENSES['no distortion']
    wrong = Lens(*SIZE, MATRIX * [[1.5, 1, 1], [1, 1.5, 1], [1, 1, 1]], np.zeros(5))
    check, work = LensCheck(), None
    for number, view in enumerate(views_of(truth, sheet(2, 2, gap=3.0), count=30)):
        for part in 0.0, 0.03:
            work = work or check.update(number + part, tags_of(view), wrong)
    check.update(100.0, [], truth)
    work()
    assert check.hint is None


def test_nothing_is_said_of_a_rolling_shutter_while_the_robot_turns():
    truth, check = LENSES['no distortion'], LensCheck()
    turn = 560 / 30  # pixels from frame to frame, at 1 rad/s
    for number, view in enumerate(views_of(truth, sheet(2, 2, gap=3.0), count=60)):
        way = turn * (-1) ** number
        for part in 0, 1:
            # The last row is read 25 ms after the first one.
            tags = [Tag(tag_id, np.float32(corners + np.stack([
                way * (part + 0.75 * corners[:, 1] / SIZE[1]), np.zeros(4)], axis=1)))
                for tag_id, corners in view.points.items()]
            work = check.update(number + part / 30, tags, truth)
            if work is not None:
                work()
            assert check.hint is None


def test_a_later_check_withdraws_a_hint():
    truth, check = LENSES['no distortion'], LensCheck()
    wrong = Lens(*SIZE, MATRIX * [[1.5, 1, 1], [1, 1.5, 1], [1, 1, 1]], np.zeros(5))
    layout = sheet(2, 2, gap=3.0)
    show(check, views_of(wrong, layout, count=50), truth)
    assert check.hint
    show(check, views_of(truth, layout, count=60, seed=1), truth)
    assert check.hint is None


@pytest.mark.parametrize('bend', [-0.6, -0.9, -3.0])
def test_a_lens_that_cannot_see_the_tags_where_they_are_does_not_fit(bend):
    wrong = Lens(*SIZE, MATRIX, np.array([bend, 0, 0, 0, 0]))
    hint = checked(wrong, LENSES['no distortion'])
    assert hint is None or ('nan' not in hint and 'inf' not in hint)
    if bend == -3.0:
        assert 'could not be seen where they are' in hint
