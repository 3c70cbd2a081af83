"""Tags: drawing them, detecting them, and their centers."""
import cv2
import numpy as np
import pytest
from aruco_ar import DICTIONARIES, Detector, InputError, Tag, draw_tag, get_dictionary


@pytest.mark.parametrize('dictionary', ['DICT_4X4_50', 'DICT_5X5_1000', 'DICT_6X6_250', 'DICT_7X7_100',
                                        'DICT_ARUCO_ORIGINAL', 'DICT_APRILTAG_36h11'])
@pytest.mark.parametrize('size', [60, 100, 333, 700])
def test_a_drawn_tag_is_detected(dictionary, size):
    last = len(get_dictionary(dictionary).bytesList) - 1
    for tag_id in (0, 1, last // 2, last):
        image = draw_tag(dictionary, tag_id, size, quiet=2)
        margin = (len(image) - size) // 2
        assert len(image) > size
        tags = Detector(dictionary).detect(image)
        assert [tag.id for tag in tags] == [tag_id]
        square = margin - 0.5 + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        np.testing.assert_allclose(tags[0].corners, square, atol=1.5)


def test_every_dictionary_of_opencv_has_a_name():
    assert len(DICTIONARIES) >= 21
    for name in DICTIONARIES:
        assert len(get_dictionary(name).bytesList) > 0


@pytest.mark.parametrize('arguments, sentence', [
    (('DICT_6X6_260', 1), 'no tag dictionary "DICT_6X6_260".*DICT_6X6_250'),
    (('DICT_6X6_250', 250), 'Tag id 250 is not in DICT_6X6_250, which has the ids 0 to 249'),
    (('DICT_6X6_250', -1), 'Tag id -1'),
    (('DICT_6X6_250', 1, 7), '8 cells wide cannot be drawn with a size of 7 px'),
    (('DICT_6X6_250', 1, 100, 0), 'border of 0 cells'),
    (('DICT_6X6_250', 1, 100, 1, -1), 'white margin of -1'),
])
def test_an_impossible_tag_is_refused(arguments, sentence):
    with pytest.raises(InputError, match=sentence):
        draw_tag(*arguments)


def test_the_center_is_that_of_the_real_tag_not_the_mean_of_its_corners():
    square = np.float32([[-1, -1], [1, -1], [1, 1], [-1, 1]]).reshape(-1, 1, 2)
    view = np.array([[50, 5, 320], [3, 60, 240], [0.25, 0.05, 1.0]])
    seen = Tag(1, cv2.perspectiveTransform(square, view).reshape(4, 2))
    np.testing.assert_allclose(seen.center, [320, 240], atol=1e-3)
    assert np.linalg.norm(seen.corners.mean(axis=0) - [320, 240]) > 2


def test_the_center_of_a_degenerate_tag_is_finite():
    assert np.all(np.isfinite(Tag(1, np.float32([[0, 0], [1, 0], [2, 0], [3, 0]])).center))


def test_only_the_requested_ids_are_found(frame):
    assert {tag.id for tag in Detector().detect(frame)} == {1, 2, 3, 4}
    assert {tag.id for tag in Detector(ids=[2, 4, 9]).detect(frame)} == {2, 4}
    gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    assert {tag.id for tag in Detector().detect(gray)} == {1, 2, 3, 4}


def test_nothing_is_found_in_an_empty_frame():
    assert Detector().detect(np.zeros((480, 640, 3), np.uint8)) == []
    assert Detector().detect(np.zeros((1, 1, 3), np.uint8)) == []
