"""AprilTags: the official ones, upright, with every OpenCV."""
import os

import cv2
import numpy as np
import pytest
from aruco_ar import Detector, draw_tag
from aruco_ar.tags.tag import _official_bytes, tag_cells
from benchmark.simulated.search import PHOTOS

# The code of the official tag with id 1 in AprilTag 2: its cells row by row from the top, 1 is white.
CODES = {'DICT_APRILTAG_16h5': (4, 0x2ea5), 'DICT_APRILTAG_25h9': (5, 0x1e4d1b6),
         'DICT_APRILTAG_36h11': (6, 0xd97f18b49)}


def official_cells(dictionary):
    """(n, n) uint8: the cells of that tag, without a border."""
    count, code = CODES[dictionary]
    bits = [code >> place & 1 for place in reversed(range(count * count))]
    return 255 * np.uint8(bits).reshape(count, count)


@pytest.fixture(params=['as it is', 'turned by OpenCV'])
def opencv(request, monkeypatch):
    """This OpenCV, and one that has its AprilTags the other way up."""
    if request.param == 'as it is':
        return
    given = cv2.aruco.getPredefinedDictionary

    def turned(number):
        table = given(number)
        upside_down = [cv2.aruco.Dictionary.getByteListFromBits(np.ascontiguousarray(
            cv2.aruco.Dictionary.getBitsFromByteList(row[None], table.markerSize)[::-1, ::-1]))[0]
            for row in table.bytesList]
        return cv2.aruco.Dictionary(np.array(upside_down), table.markerSize, table.maxCorrectionBits)
    monkeypatch.setattr(cv2.aruco, 'getPredefinedDictionary', turned)
    _official_bytes.cache_clear()
    request.addfinalizer(_official_bytes.cache_clear)


@pytest.mark.parametrize('dictionary', sorted(CODES))
@pytest.mark.parametrize('search', ['normal', 'thorough'])
def test_an_official_tag_that_hangs_upright_is_seen_upright(opencv, dictionary, search):
    cells = np.pad(np.pad(official_cells(dictionary), 1), 2, constant_values=255)
    frame = cv2.resize(cells, None, fx=20, fy=20, interpolation=cv2.INTER_NEAREST)
    tag, = Detector(dictionary, search=search).detect(frame)
    assert tag.id == 1
    side = 20 * (CODES[dictionary][0] + 2)
    np.testing.assert_allclose(tag.corners, 39.5 + side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), atol=0.2)


@pytest.mark.parametrize('dictionary', sorted(CODES))
def test_the_tags_that_are_drawn_are_the_official_ones(opencv, dictionary):
    cells = tag_cells(dictionary, 1)
    np.testing.assert_array_equal(cells[1:-1, 1:-1], official_cells(dictionary))
    drawn = draw_tag(dictionary, 1, 10 * len(cells))
    np.testing.assert_array_equal(drawn[5::10, 5::10], cells)


def test_the_signs_of_a_street_are_seen_upright():
    """Their posts are below."""
    if not os.path.isdir(PHOTOS):
        pytest.skip('the folder %s with photos is missing' % os.path.normpath(PHOTOS))
    tags = Detector('DICT_APRILTAG_36h11').detect(cv2.imread(os.path.join(PHOTOS, 'street.png')))
    assert {22, 24, 58, 144} <= {tag.id for tag in tags}
    for tag in tags:
        up, right = tag.corners[0] - tag.corners[3], tag.corners[1] - tag.corners[0]
        assert up[1] < -30 and right[0] > 30
