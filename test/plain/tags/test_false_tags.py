"""The benchmark of false tags counts them right, and its frames are what they claim to be."""
import numpy as np
import pytest
from aruco_ar import draw_tag
from benchmark.false_tags import findings, frames
from benchmark.false_tags.false_tags import Tagless
from benchmark.real_clips.clips import Clip

NAME = 'DICT_5X5_100'
PLACE = np.float32([[49.5, 39.5], [149.5, 39.5], [149.5, 139.5], [49.5, 139.5]])


def frame_with_a_tag(_number=0):
    frame = np.full((200, 200, 3), 230, np.uint8)
    frame[40:140, 50:150] = draw_tag(NAME, 42, 100)[:, :, None]
    return frame


@pytest.fixture
def finder(monkeypatch):
    monkeypatch.setattr(findings.detector, 'find_quads', findings.detector.find_quads)  # a Finder replaces it
    findings.finder_of.cache_clear()
    yield findings.finder_of(0.2)
    findings.finder_of.cache_clear()


def test_a_tag_is_true_where_the_truth_has_it_and_nowhere_else(finder):
    frame = frame_with_a_tag()
    for truth, expected in ({42: PLACE}, True), ({42: PLACE + 20}, False), ({41: PLACE}, False), ({}, False):
        found, = finder.ours('kind', frame.copy(), NAME, truth)
        assert (found.kind, found.dictionary, found.id, found.is_true) == ('kind', NAME, 42, expected)
        assert found.confidence > 0.9


def test_a_tag_in_a_frame_without_tags_is_counted_of_each_detector(finder):
    ours, theirs = Tagless('walls', frame_with_a_tag)(0)
    mine = [found for found in ours if found.dictionary.startswith('DICT_5X5')]
    assert all(found.id == 42 and not found.is_true for found in mine)
    assert [found.dictionary for found in mine] == ['DICT_5X5_%d' % count for count in (100, 1000, 250, 50)]
    assert [name for name in theirs if name.startswith('DICT_5X5') and theirs[name]] == [
        found.dictionary for found in mine]
    assert Tagless('walls', frame_with_a_tag)(1)[1] == {}  # OpenCV's looks at every fifth only


def test_the_rest_of_a_tag_that_was_painted_over_is_not_a_false_one(finder):
    clip = Clip('', 'DICT_5X5_250', (), None, (42,))
    ours, theirs = Tagless('clip', frame_with_a_tag, clip)(0)
    assert not any(found.dictionary.startswith('DICT_5X5') for found in ours)
    assert not any(theirs[name] for name in theirs if name.startswith('DICT_5X5'))


def test_frames_are_made_from_their_numbers_alone():
    for frame_of in frames.wall_frame, frames.thing_frame:
        frame = frame_of(3)
        assert frame.shape == (480, 640, 3) and frame.dtype == np.uint8
        np.testing.assert_array_equal(frame, frame_of(3))
        assert (frame != frame_of(4)).any()


def test_the_tags_of_a_frame_are_where_its_truth_says(finder):
    found = [each for number in range(6) for each in findings.tagged(finder, NAME, number)]
    true = [each for each in found if each.is_true]
    assert len(true) >= 8 and len(true) > 0.8 * len(found)
