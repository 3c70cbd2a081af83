"""What a user is told about tags that only the most thorough search finds."""
import cv2
import numpy as np
import pytest
from aruco_ar import draw_tag
from aruco_ar.hints.missed_tags import MissedTags

SIDE = 12  # pixels of a small tag: what a search with less effort finds depends on OpenCV's version


def frame_with(small, large=()):
    """A frame with small and large tags."""
    frame = np.full((480, 640, 3), 200, np.uint8)
    for number, (tag_id, side) in enumerate([(each, SIDE) for each in small] + [(each, 60) for each in large]):
        tag = draw_tag('DICT_4X4_50', tag_id, side)
        x, y = 60 + 130 * (number % 4), 80 + 160 * (number // 4)
        frame[y - 12:y + side + 12, x - 12:x + side + 12] = 240
        frame[y:y + side, x:x + side] = tag[..., None]
    return frame


def detection(search='normal', **others):
    return {'dictionary': 'DICT_4X4_50', 'ids': (), 'search': search, **others}


def hint(frame, seconds, seen, search='normal', has_area=False, **others):
    missed = MissedTags(detection(search, **others))
    for number in range(2 * seconds):
        work = missed.update(frame, number / 2, set(seen), has_area)
        if work is not None:
            work()
    return missed.hint


@pytest.mark.parametrize('large', [(), (8, 9)])
def test_tags_that_are_hard_to_see_come_with_the_remedy(large):
    frame = frame_with([1, 2, 3, 4], large)
    sentence = '4 tags are hard to see: 1, 2, 3, 4. Look harder for them: search:=thorough.'
    assert hint(frame, 40, large) == sentence
    assert hint(frame, 4, large) is None  # not yet
    assert hint(frame, 40, large, has_area=True) is None
    assert hint(frame, 40, large, search='thorough') is None


def test_a_single_tag_is_spoken_of_as_one():
    assert hint(frame_with([4]), 40, []) == '1 tag is hard to see: 4. Look harder for it: search:=thorough.'


def test_nothing_is_said_of_tags_that_are_ignored_since_they_are_small():
    assert hint(frame_with([1, 2, 3, 4]), 25, [], min_side=SIDE - 3) is not None
    assert hint(frame_with([1, 2, 3, 4]), 25, [], min_side=SIDE + 3) is None
    large = cv2.resize(frame_with([1, 2, 3, 4]), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    assert hint(large, 25, [], min_side=2 * SIDE + 6) is None


def test_nothing_is_said_of_an_empty_wall_or_of_four_tags():
    assert hint(frame_with([]), 40, []) is None
    assert hint(frame_with([1], [5, 6, 8, 9]), 40, [5, 6, 8, 9]) is None


def searched(missed, frame, stamps, seconds=0.0):
    """The stamps at which a search begins. ``seconds``: until a frame later the search has ended."""
    began, work = [], None
    for stamp in stamps:
        new = missed.update(frame, stamp, set(), False)
        if new is not None:
            began.append(stamp)
            work, due = new, stamp + seconds
        if work is not None and stamp >= due:
            work()
            work = None
    return began


def test_no_search_begins_before_the_last_one_has_ended():
    began = searched(MissedTags(detection()), frame_with([]), np.arange(0, 30, 0.1), seconds=6.0)
    assert 2 <= len(began) <= 5 and min(np.diff(began)) >= 6


def test_searches_take_a_small_share_of_the_time_and_are_rare_when_they_are_in_vain(monkeypatch):
    missed, seconds = MissedTags(detection()), iter(np.arange(0, 1e4, 0.5))
    monkeypatch.setattr('time.thread_time', lambda: next(seconds))  # each search takes 0.5 s
    began = searched(missed, np.full((48, 64, 3), 90, np.uint8), np.arange(0, 800, 0.25))
    np.testing.assert_allclose(np.diff(began)[:9], 10)
    np.testing.assert_allclose(np.diff(began)[9:], 100)


def test_a_late_result_says_nothing_after_four_tags_have_been_in_sight():
    missed, frame = MissedTags(detection()), frame_with([1, 2, 3, 4])
    for number in range(200):
        work = missed.update(frame, number / 2, set(), False)
        missed.update(frame, number / 2, {5, 6, 7, 8}, False)
        if work is not None:
            work()
    assert missed.hint is None


@pytest.mark.parametrize('shape', [(1, 2000, 3), (2000, 1, 3), (2000, 3, 3), (1, 1, 3)])
def test_thin_frames_can_be_searched(shape):
    assert hint(np.full(shape, 90, np.uint8), 10, []) is None
