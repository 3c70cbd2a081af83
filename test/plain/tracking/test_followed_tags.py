"""All tags of a sequence of frames, followed from frame to frame."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector, draw_tag
from aruco_ar.tracking.followed_tags import FollowedTags

SIDE = 60
FIVE = {1: (40, 40), 2: (240, 40), 3: (440, 40), 4: (40, 300), 5: (200, 300)}


def frame_with(places, blank=()):
    """A frame, (480, 640, 3), with tags, {id: (x, y) of the top left corner}. ``blank``: those half covered."""
    frame = np.full((480, 640), 200, np.uint8)
    for tag_id, (x, y) in places.items():
        frame[y:y + SIDE, x:x + SIDE] = draw_tag('DICT_6X6_250', tag_id, SIDE)
        if tag_id in blank:
            frame[y - 9:y + SIDE + 9, x + SIDE // 2:x + SIDE + 9] = 120
    return cv2.cvtColor(cv2.GaussianBlur(frame, (0, 0), 0.7), cv2.COLOR_GRAY2BGR)


@pytest.fixture
def searches(monkeypatch):
    """The frames that were searched as a whole."""
    searched, detect = [], Detector.detect
    monkeypatch.setattr(Detector, 'detect', lambda self, frame: searched.append(frame) or detect(self, frame))
    return searched


def ids(tags):
    return sorted(tag.id for tag in tags)


def test_tags_that_move_are_where_a_search_finds_them_and_few_frames_are_searched(searches):
    followed, detector = FollowedTags(Detector()), Detector()
    for number in range(60):
        x = round(150 + 100 * np.sin(number / 10))
        frame = frame_with({1: (x, 40), 2: (x + 150, 40), 3: (x, 300), 4: (x + 150, 300)})
        tags = {tag.id: tag.corners for tag in followed.find(frame, number / 30)}
        count = len(searches)
        for tag in detector.detect(frame):
            np.testing.assert_allclose(tags[tag.id], tag.corners, atol=0.03)
        del searches[count:]
    assert 60 / 7 <= len(searches) <= 60 / 4


def test_a_tag_that_goes_is_gone_at_once_and_one_that_comes_is_found_soon():
    followed = FollowedTags(Detector())
    for number in range(10):
        assert ids(followed.find(frame_with(FIVE), number / 30)) == [1, 2, 3, 4, 5]
    four = {tag_id: place for tag_id, place in FIVE.items() if tag_id != 5}
    for number in range(10, 50):  # until it is not expected to return
        assert ids(followed.find(frame_with(four), number / 30)) == [1, 2, 3, 4]
    found = [ids(followed.find(frame_with({**four, 7: FIVE[5]}), number / 30)) for number in range(50, 60)]
    assert found[-1] == [1, 2, 3, 4, 7] and found.index(found[-1]) <= 6


def test_while_fewer_than_four_tags_are_in_sight_others_are_found_at_once():
    followed = FollowedTags(Detector())
    for number in range(20):
        some = dict(list(FIVE.items())[:number % 4 + 1])
        assert ids(followed.find(frame_with(some), number / 30)) == sorted(some)


def test_another_tag_in_the_same_place_is_not_taken_for_the_one_before():
    followed = FollowedTags(Detector())
    for number in range(20):
        tag_id = number % 4 + 10
        frame = frame_with({**FIVE, tag_id: (540, 300)})
        assert ids(followed.find(frame, number / 30)) == [1, 2, 3, 4, 5, tag_id]


def test_a_tag_that_is_half_covered_does_not_drift():
    followed, detector = FollowedTags(Detector()), Detector()
    for number in range(30):
        frame = frame_with({**FIVE, 9: (300 + 3 * number, 300)}, blank=[9] if number > 9 else [])
        assert ids(followed.find(frame, number / 30)) == ids(detector.detect(frame))


def test_a_pause_a_step_back_in_time_and_another_size_begin_anew(searches):
    followed, frame = FollowedTags(Detector()), frame_with(FIVE)
    for number, stamp in enumerate((0.0, 10.0, 5.0), 1):
        assert ids(followed.find(frame, stamp)) == [1, 2, 3, 4, 5] and len(searches) == number
    assert ids(followed.find(frame[:470], 5.03)) == [1, 2, 3, 4, 5] and len(searches) == 4
    assert ids(followed.find(frame[:470], 5.06)) == [1, 2, 3, 4, 5] and len(searches) == 4
