"""How sure it is that a tag is one."""
import numpy as np
import pytest
from aruco_ar import Detector
from aruco_ar.tags.confidence import Confidence, count_changes
from aruco_ar.tags.tag import draw_tag, tag_cells


def test_changes_are_counted_along_rows_and_columns():
    cells = np.uint8([[0, 0, 0], [0, 255, 0], [0, 0, 0]])
    assert count_changes(cells) == count_changes(255 - cells) == 4
    assert count_changes(np.zeros((6, 6), np.uint8)) == 0


@pytest.mark.parametrize('dictionary', ['DICT_4X4_50', 'DICT_6X6_250', 'DICT_ARUCO_ORIGINAL'])
def test_a_perfect_tag_is_sure_and_one_that_is_hardly_like_itself_is_not(dictionary):
    confidence, changes = Confidence(dictionary), count_changes(tag_cells(dictionary, 7))
    assert confidence.of(1.0, changes) > 0.99
    assert confidence.of(0.3, changes) < 0.2
    assert 0 <= confidence.of(-1.0, 0) < 1e-6


def test_a_plain_pattern_needs_more_to_be_believed():
    confidence = Confidence('DICT_ARUCO_ORIGINAL')
    assert confidence.of(0.95, 30) > 0.9 > 0.2 > confidence.of(0.95, 10)


def test_a_tag_is_surer_the_fewer_others_it_might_be():
    changes = count_changes(tag_cells('DICT_4X4_50', 7))
    any_tag, of_four = (Confidence('DICT_4X4_50', ids).of(0.85, changes) for ids in (0, 4))
    expected = Confidence('DICT_4X4_50').of(0.85, changes, is_expected=True)
    assert any_tag < of_four < expected < 1


def test_a_tag_where_one_is_expected_is_believed_more():
    frame = np.full((200, 200), 220, np.uint8)
    frame[50:130, 50:130] = np.where(draw_tag('DICT_4X4_50', 3, 80) > 0, 200, 40)
    frame[85:105, 85:105] = 120  # something gray before two cells and parts of others
    place = np.float32([[[49.5, 49.5], [129.5, 49.5], [129.5, 129.5], [49.5, 129.5]]])
    detector = Detector('DICT_4X4_50', confidence=0)
    (found,), (expected,) = detector.detect(frame), detector.find_at(frame, [3], place)
    assert found.likeness == pytest.approx(expected.likeness, abs=0.02)
    assert found.confidence < expected.confidence < 1
