"""What a user is told about tags that only the most thorough search finds."""
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


def hint(frame, seconds, seen, search='normal', has_area=False):
    missed = MissedTags('DICT_4X4_50', (), search)
    for number in range(2 * seconds):
        missed.update(frame, number / 2, set(seen), has_area)
    return missed.hint


@pytest.mark.parametrize('large', [(), (8, 9)])
def test_tags_that_are_hard_to_see_come_with_the_remedy(large):
    frame = frame_with([1, 2, 3, 4], large)
    sentence = '4 tags are hard to see: 1, 2, 3, 4. Look harder for them: search:=thorough.'
    assert hint(frame, 14, large) == sentence
    assert hint(frame, 4, large) is None  # not yet
    assert hint(frame, 14, large, has_area=True) is None
    assert hint(frame, 14, large, search='thorough') is None


def test_nothing_is_said_of_an_empty_wall_or_of_four_tags():
    assert hint(frame_with([]), 14, []) is None
    assert hint(frame_with([1], [5, 6, 8, 9]), 14, [5, 6, 8, 9]) is None
