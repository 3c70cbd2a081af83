"""What a user is told about tags with the same id, and about bad light."""
import numpy as np
import pytest
from aruco_ar import Tag, Tracker, draw_tag
from aruco_ar.hints.light import TOO_BRIGHT, TOO_DARK, Light
from aruco_ar.hints.same_ids import SameIds

SQUARE = np.float32([[-10, -10], [10, -10], [10, 10], [-10, 10]])


def tags_with(*ids):
    return [Tag(tag_id, SQUARE + np.float32([50 + 60 * number, 80])) for number, tag_id in enumerate(ids)]


def hint(tags, seconds=3, has_area=False):
    same = SameIds()
    for number in range(10 * seconds):
        same.update(number / 10, tags, has_area)
    return same.hint


def test_ids_that_are_several_times_in_sight_are_named_with_the_remedy():
    assert hint(tags_with(3, 3, 5, 3)) == (
        'An id is several times in sight: 3. Nothing shows which one is meant, so the area does not use it. '
        'Hang up four tags with different ids, each once.')
    assert hint(tags_with(3, 5, 5, 3)).startswith('2 ids are several times in sight: 3, 5.')
    assert hint(tags_with(3, 3), seconds=1) is None
    assert hint(tags_with(3, 3), has_area=True) is None
    assert hint(tags_with(3, 4, 5, 6)) is None


def test_a_tag_that_is_found_twice_in_one_place_is_one_tag():
    assert hint([Tag(3, SQUARE + 100), Tag(3, SQUARE + 103)]) is None


def test_the_hint_at_ids_ends_when_each_is_there_once_but_not_with_a_frame_that_misses_one():
    same = SameIds()
    for number in range(60):
        same.update(number / 10, tags_with(3, *([3] * (number < 40 and number % 5 > 0))), False)
        if number not in (20, 21, 44, 45):  # these are at the limits
            assert bool(same.hint) == (21 < number < 44), number


def light(levels, seconds=5, found=False):
    watched = Light()
    for number in range(10 * seconds):
        watched.update(levels, number / 10, found)
    return watched.hint


@pytest.mark.parametrize('level, said', [(0, TOO_DARK), (10, TOO_DARK), (30, None), (128, None), (230, None),
                                         (255, TOO_BRIGHT)])
def test_light_in_which_nothing_can_be_read_comes_with_the_remedy(level, said):
    frame = np.full((240, 320, 3), level, np.uint8)
    frame[:20, :20] = 128  # whatever else is in the frame
    assert light(frame) == said
    assert light(frame, seconds=2) is None and light(frame, found=True) is None


def test_the_hint_at_light_ends_when_the_light_is_good():
    watched = Light()
    for number in range(100):
        watched.update(np.full((240, 320, 3), 0 if number < 60 else 100, np.uint8), number / 10, False)
    assert watched.hint is None


def test_tags_of_one_id_are_also_named_where_a_tracker_looks_for_the_area():
    frame = np.full((480, 640, 3), 235, np.uint8)
    for number, tag_id in enumerate([3, 3, 5, 3]):
        x, y = 60 + 300 * (number % 2), 60 + 220 * (number // 2)
        frame[y:y + 90, x:x + 90] = draw_tag('DICT_6X6_250', tag_id, 90)[..., None]
    tracker, same = Tracker(), SameIds()
    for number in range(30):
        area = tracker.update(frame, number / 10)
        same.update(number / 10, tracker.tags + tracker.repeated, area is not None)
    assert same.hint.startswith('An id is several times in sight: 3.')
