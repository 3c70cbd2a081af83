"""The boards with which a camera is calibrated."""
import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_ar.calibration.sheets import CharucoBoard


@pytest.mark.parametrize('squares', [(5, 7), (6, 8), (8, 6)])
@pytest.mark.parametrize('is_legacy', [False, True])
def test_a_board_is_found_as_every_version_of_opencv_draws_it(squares, is_legacy):
    drawn = cv2.aruco.CharucoBoard(squares, 1.0, 0.7, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100))
    drawn.setLegacyPattern(is_legacy)
    image = cv2.copyMakeBorder(drawn.generateImage((squares[0] * 60, squares[1] * 60)), 40, 40, 40, 40,
                               cv2.BORDER_CONSTANT, value=255)
    board = CharucoBoard('DICT_5X5_100', *squares, 0.7)
    assert board.view(np.full((480, 640, 3), 90, np.uint8)).points == {}
    found = board.view(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)).points
    assert len(found) == (squares[0] - 1) * (squares[1] - 1)
    for number, pixels in found.items():
        np.testing.assert_allclose(pixels, board.points[number] * 60 + 39.5, atol=1)


def test_a_board_with_more_tags_than_the_dictionary_has_is_refused():
    CharucoBoard('DICT_4X4_50', 10, 10, 0.7)
    with pytest.raises(InputError, match='10 x 11 squares has 55 tags, but DICT_4X4_50 only has 50'):
        CharucoBoard('DICT_4X4_50', 10, 11, 0.7)
