"""The boards with which a camera is calibrated."""
import cv2
import numpy as np
import pytest
from aruco_ar import InputError, draw_tag
from aruco_ar.calibration.sheets import CharucoBoard, TagSheet
from aruco_ar.tags.tag import get_dictionary


@pytest.mark.parametrize('squares', [(5, 7), (6, 8), (8, 6)])
@pytest.mark.parametrize('is_legacy, first, is_negated', [
    (False, 0, False), (True, 0, False), (False, 18, False), (False, 7, True), (True, 48, True)])
def test_a_board_is_found_as_every_program_draws_it(squares, is_legacy, first, is_negated):
    ids = np.arange(first, first + squares[0] * squares[1] // 2, dtype=np.int32)
    drawn = cv2.aruco.CharucoBoard(squares, 1.0, 0.7,
                                   cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100), ids)
    drawn.setLegacyPattern(is_legacy)
    image = cv2.copyMakeBorder(drawn.generateImage((squares[0] * 60, squares[1] * 60)), 40, 40, 40, 40,
                               cv2.BORDER_CONSTANT, value=255)
    board = CharucoBoard('DICT_5X5_100', *squares, 0.7)
    assert board.view(np.full((480, 640, 3), 90, np.uint8)).points == {}
    image = 255 - image if is_negated else image
    found = board.view(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)).points
    assert len(found) == (squares[0] - 1) * (squares[1] - 1)
    for number, pixels in found.items():
        np.testing.assert_allclose(pixels, board.points[number] * 60 + 39.5, atol=1)


@pytest.mark.parametrize('table', [
    cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11), get_dictionary('DICT_APRILTAG_36h11')],
    ids=['as OpenCV draws them', 'official'])
@pytest.mark.parametrize('is_legacy', [False, True])
@pytest.mark.parametrize('turns', [0, 2])
def test_a_board_of_apriltags_is_found_with_official_tags_and_with_turned_ones(table, is_legacy, turns):
    drawn = cv2.aruco.CharucoBoard((5, 8), 1.0, 0.7, table)
    drawn.setLegacyPattern(is_legacy)
    image = cv2.copyMakeBorder(drawn.generateImage((300, 480)), 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    both = [image, np.ascontiguousarray(np.rot90(image, turns))]
    board = CharucoBoard('DICT_APRILTAG_36h11', 5, 8, 0.7)
    for shown, turned in zip(both, (False, turns == 2)):
        found = board.view(cv2.cvtColor(shown, cv2.COLOR_GRAY2BGR)).points
        assert sorted(found) == list(range(28))
        for number, pixels in found.items():
            place = board.points[number] * 60 + 39.5
            place = np.array(image.shape[::-1]) - 1 - place if turned else place
            np.testing.assert_allclose(pixels, place, atol=1)


def test_a_part_of_a_board_has_the_corners_that_it_has_in_a_view_of_all_of_it():
    squares, ids = (5, 8), np.arange(18, 38, dtype=np.int32)
    drawn = cv2.aruco.CharucoBoard(squares, 1.0, 0.7,
                                   cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100), ids)
    image = cv2.copyMakeBorder(drawn.generateImage((300, 480)), 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    board = CharucoBoard('DICT_5X5_100', *squares, 0.7)
    assert len(board.view(image).points) == 28
    image[:300] = 90  # the first rows are hidden
    found = board.view(image).points
    assert len(found) >= 8
    for number, pixels in found.items():
        np.testing.assert_allclose(pixels, board.points[number] * 60 + 39.5, atol=1)


def test_a_sheet_may_be_white_on_black():
    image = np.full((240, 480), 255, np.uint8)
    for number in range(3):
        image[60:160, 40 + 150 * number:140 + 150 * number] = draw_tag('DICT_6X6_250', number, 100)
    sheet = TagSheet('DICT_6X6_250')
    for shown in image, 255 - image, 255 - image, image:
        found = sheet.view(cv2.cvtColor(shown, cv2.COLOR_GRAY2BGR)).points
        for number in range(3):
            x = 40 + 150 * number
            corners = np.array([[x, 60], [x + 100, 60], [x + 100, 160], [x, 160]]) - 0.5
            np.testing.assert_allclose(found[number], corners, atol=0.3)
    assert sheet.view(np.full((240, 480, 3), 90, np.uint8)).points == {}


def test_a_board_with_more_tags_than_the_dictionary_has_is_refused():
    CharucoBoard('DICT_4X4_50', 10, 10, 0.7)
    with pytest.raises(InputError, match='10 x 11 squares has 55 tags, but DICT_4X4_50 only has 50'):
        CharucoBoard('DICT_4X4_50', 10, 11, 0.7)
