"""The wall's texture locates the area while tags do not, and never in a wrong place."""
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import Tracker
from rig.accuracy.areas import assert_never_wrong, follow, later, rms
from rig.accuracy.drives import FAST, LIVELY, PAINTING, SLOW, STILL, WALL, drive

ALL = WALL.area
BLANK = replace(WALL, plaster=0)
LEARNED = 60  # frames in which all tags are in sight
PHONE = {'noise': 2.0, 'blur': 0.7, 'light': 0.3, 'hand': 1.0, 'quality': 70}


@pytest.fixture
def painting():
    return PAINTING


def hidden(number, ids=ALL):
    return ids if number >= LEARNED else ()


@pytest.mark.long
def test_the_area_stays_within_a_pixel_while_all_tags_are_hidden_for_ten_seconds(painting):
    frames = list(drive(SLOW, LEARNED + 300, hidden, wall=painting, **PHONE))
    errors = follow(Tracker(), frames)
    assert not np.isnan(errors).any()
    assert rms(errors[LEARNED:]) < 1


@pytest.mark.long
@pytest.mark.parametrize('plaster', [True, False], ids=['a painting', 'tags alone'])
def test_the_area_stays_while_blur_hides_all_tags(painting, plaster):
    """Jerks of the camera smear two frames each, in the middle of a drive, so that no tag can be read."""
    wall = painting if plaster else BLANK
    sharp = list(drive(LIVELY, 120, wall=wall, **PHONE))
    smeared = list(drive(LIVELY, 120, wall=wall, smear=15, **PHONE))
    frames = [smeared[number] if number in (80, 81, 100, 101) else frame for number, frame in enumerate(sharp)]
    errors = follow(Tracker(), frames)
    assert rms(errors[[80, 81, 100, 101]]) < 0.5


@pytest.mark.long
@pytest.mark.parametrize('smear, most', [(9, 0.5), (15, 0.5), (25, 1.5)])
def test_the_area_stays_while_the_camera_is_blurred_for_long(smear, most):
    sharp, blurred = (drive(LIVELY, 120, noise=2.0, smear=length) for length in (1, smear))
    frames = [frame if number < 30 else other for number, (frame, other) in enumerate(zip(sharp, blurred))]
    errors = follow(Tracker(), frames)
    assert not np.isnan(errors).any() and rms(errors[30:]) < most


@pytest.mark.long
def test_a_tag_on_a_bent_corner_of_the_sheet_does_not_drag_the_area(painting):
    """For a moment, one tag is seen beside its place. The wall and the other tags stay."""
    frames = list(drive(STILL, 75, wall=painting, noise=1.0))
    (left, top), (right, bottom) = np.int32(frames[0].corners[2]) + [[-60, -60], [60, 60]]
    for frame in frames[60:66]:
        frame.image[top - 10:bottom - 10, left + 10:right + 10] = frame.image[top:bottom, left:right].copy()
    errors = follow(Tracker(), frames)
    assert not np.isnan(errors).any() and errors.max() < 1


@pytest.mark.long
def test_the_wall_is_recognized_after_a_jerk(painting):
    frames, shift = list(drive(STILL, 90, hidden, wall=painting, **PHONE)), np.float32([[1, 0, 14], [0, 1, -9]])
    for number, frame in enumerate(frames[75:], 75):
        jerked = cv2.warpAffine(frame.image, shift, (640, 480), borderMode=cv2.BORDER_REPLICATE)
        frames[number] = frame._replace(image=jerked, corners=frame.corners + shift[:, 2])
    assert rms(follow(Tracker(), frames)[75:]) < 1


@pytest.mark.long
def test_the_area_stays_for_as_long_as_the_wall_is_recognized(painting):
    tracker, frames = Tracker(), list(drive(STILL, LEARNED + 30, hidden, wall=painting, noise=2.0))
    assert not np.isnan(follow(tracker, frames)).any()
    assert tracker.explanation == "The wall's texture shows it."
    again = frames[LEARNED:]
    for round in range(1, 40):
        errors = follow(tracker, later(again, float(round)))
        assert not np.isnan(errors).any() and rms(errors) < 1


@pytest.mark.long
def test_a_blank_wall_does_not_hold_the_area():
    frames = list(drive(STILL, LEARNED + 30, hidden, wall=BLANK, noise=3.0))
    errors = follow(Tracker(), frames)
    assert np.isnan(errors[LEARNED + 12:]).all()


@pytest.mark.long
@pytest.mark.parametrize('left', [(), (2,), (1, 3)])
def test_a_film_between_the_tags_never_drags_the_area(package, left):
    """The whole film pans in the same way. It is seen to move while tags are in sight, so it is not learned."""
    film = cv2.imread(package + '/images/earth.jpg')
    frames = list(drive(SLOW, LEARNED + 40, lambda number: hidden(number, [id for id in ALL if id not in left]),
                        wall=BLANK, **PHONE))
    screen = np.float32([[0.15, 0.15], [0.85, 0.15], [0.85, 0.85], [0.15, 0.85]])
    shown = []
    for number, frame in enumerate(frames):
        scene = np.roll(film, 3 * number, axis=1)[100:500, 100:700]
        to_area = cv2.getPerspectiveTransform(np.float32([[0, 0], [1, 0], [1, 1], [0, 1]]),
                                              np.float32(frame.corners))
        quad = cv2.perspectiveTransform(screen[None], to_area)
        to_frame = cv2.getPerspectiveTransform(np.float32([[0, 0], [600, 0], [600, 400], [0, 400]]), quad)
        cv2.warpPerspective(scene, to_frame, (640, 480), frame.image, borderMode=cv2.BORDER_TRANSPARENT)
        shown.append(frame)
    assert_never_wrong(follow(Tracker(), shown), shown)


@pytest.mark.long
@pytest.mark.parametrize('left', [(), (4,)])
def test_a_passer_by_never_drags_the_area(painting, package, left):
    """Somebody in patterned clothes passes the picture, later also while most or all tags are hidden."""
    coat = cv2.resize(cv2.imread(package + '/images/earth.jpg'), (180, 420))
    frames = list(drive(SLOW, LEARNED + 60, lambda number: hidden(number, [id for id in ALL if id not in left]),
                        wall=painting, **PHONE))
    for number, frame in enumerate(frames):
        x = int(-180 + 7 * number)
        first, last = max(x, 0), min(x + 180, 640)
        if first < last:
            frame.image[40:460, first:last] = coat[:, first - x:last - x]
    assert_never_wrong(follow(Tracker(), frames), frames)


@pytest.mark.long
@pytest.mark.parametrize('left', [(), (1,)])
def test_a_shadow_never_drags_the_area(painting, left):
    frames = list(drive(SLOW, LEARNED + 60, lambda number: hidden(number, [id for id in ALL if id not in left]),
                        wall=painting, **PHONE))
    for number, frame in enumerate(frames):
        edge = 6 * number
        frame.image[:, :edge] //= 2
    errors = follow(Tracker(), frames)
    assert_never_wrong(errors, frames)
    assert not np.isnan(errors).any()


@pytest.mark.long
def test_the_texture_locates_the_area_while_driving_past(painting):
    frames = list(drive(FAST, 120, lambda number: ALL if number % 60 >= 40 else (), wall=painting, **PHONE))
    errors = follow(Tracker(), frames)
    assert not np.isnan(errors[30:]).any() and rms(errors[30:]) < 1
