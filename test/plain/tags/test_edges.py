"""Fitting tags to their edges: to a fraction of a pixel, and only to the right tag."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector, draw_tag
from aruco_ar.tags.edges import fit_tags, room_of
from aruco_ar.tags.tag import tag_cells
from benchmark.real_clips.covered import Cover

CORNERS = np.float32([[101.3, 80.7], [222.9, 90.2], [215.4, 205.8], [96.1, 199.5]])
CELLS = tag_cells('DICT_6X6_250', 7)[None]
FINE = 8  # samples per pixel, in each direction


def paint(corners, shade=0.0, size=(320, 280)):
    """A frame with tag 7 and its margin. Each pixel is the mean over its square.

    ``shade``: how much darker the frame's right end is than its left.
    """
    tag = draw_tag('DICT_6X6_250', 7, 1600, quiet=1)
    margin = (len(tag) - 1600) / 2 - 0.5  # a texel covers half a texel on each side of its middle
    side = margin + 1600
    to_fine = cv2.getPerspectiveTransform(
        np.float32([[margin, margin], [side, margin], [side, side], [margin, side]]),
        np.float32((corners + 0.5) * FINE - 0.5))
    fine = cv2.warpPerspective(tag, to_fine, (size[0] * FINE, size[1] * FINE), borderValue=200)
    light = 1 - shade * np.arange(size[0]) / size[0]
    return np.uint8(np.round(cv2.resize(fine, size, interpolation=cv2.INTER_AREA) * light))


@pytest.mark.parametrize('shade', [0.0, 0.6])
@pytest.mark.parametrize('off', [(0, 0), (1.5, -2), (-6, 5)])
def test_a_tag_is_fitted_to_a_fraction_of_a_pixel(shade, off):
    quads, found, likeness = fit_tags(paint(CORNERS, shade), [CORNERS + np.float32(off)], CELLS)
    assert found[0] and likeness[0] > 0.95
    np.testing.assert_allclose(quads[0], CORNERS, atol=0.1 if shade else 0.05)


@pytest.mark.parametrize('quad', [CORNERS, 0.25 * CORNERS + 30], ids=['near', 'far'])
@pytest.mark.parametrize('cells', [(2, 0), (-1.9, 1.3), (0.3, -2), (1.8, 1.8)])
def test_a_tag_that_is_off_by_up_to_two_cells_is_fitted_where_it_looks_like_itself(quad, cells):
    detector, frame = Detector(), paint(quad)
    off = quad + np.linalg.norm(quad[1] - quad[0]) / 8 * np.float32(cells)
    assert not detector.find_at(frame, [7], off[None])
    tag, = detector.find_shifted(frame, [7], off[None])
    np.testing.assert_allclose(tag.corners, quad, atol=0.1)
    assert not Detector(confidence=1).find_shifted(frame, [7], off[None])
    assert not detector.find_shifted(frame, [8], off[None])


def test_a_tag_seen_from_the_side_is_as_accurate():
    # It is three times as high as wide, and so are its cells and the margin.
    narrow = np.float32([[101.3, 70.7], [141.9, 83.2], [139.4, 190.8], [98.1, 207.5]])
    quads, found, _ = fit_tags(paint(narrow), [narrow + np.float32((1, -1.5))], CELLS)
    assert found[0]
    np.testing.assert_allclose(quads[0], narrow, atol=0.08)


def test_a_detected_tag_is_as_accurate():
    tag, = Detector().detect(paint(CORNERS))
    np.testing.assert_allclose(tag.corners, CORNERS, atol=0.05)


@pytest.mark.parametrize('blur, most', [(0.8, 0.1), (3.0, 0.3)])
def test_a_tag_without_a_margin_on_a_dark_wall_is_fitted_by_its_cells(blur, most):
    """Nothing shows its outer edges. Its cells are 15 px wide."""
    mask = cv2.fillConvexPoly(np.zeros((280, 320), np.uint8), np.int32(np.round(CORNERS)), 255)
    frame = cv2.GaussianBlur(np.where(mask > 0, paint(CORNERS), 35).astype(np.uint8), (0, 0), blur)
    quads, found, likeness = fit_tags(frame, [CORNERS + np.float32((2, -1.5))], CELLS)
    assert found[0] and likeness[0] > 0.9
    np.testing.assert_allclose(quads[0], CORNERS, atol=most)


def test_corners_that_are_not_finite_are_not_fitted():
    quads, found, _ = fit_tags(paint(CORNERS), [CORNERS * np.nan, CORNERS * 1e30], CELLS[[0, 0]])
    assert not found.any() and np.isnan(quads[0]).all()


def test_blur_does_not_shift_the_edges():
    frame = cv2.GaussianBlur(paint(CORNERS), (0, 0), 2.0)
    quads, found, _ = fit_tags(frame, [CORNERS], CELLS)
    assert found[0]
    np.testing.assert_allclose(quads[0], CORNERS, atol=0.15)


def test_another_tag_is_not_mistaken_for_it():
    _, _, likeness = fit_tags(paint(CORNERS), [CORNERS], tag_cells('DICT_6X6_250', 8)[None])
    assert likeness[0] < 0.5
    _, _, turned = fit_tags(paint(CORNERS), [np.roll(CORNERS, 1, axis=0)], CELLS)
    assert turned[0] < 0.5


def test_a_half_covered_tag_is_not_found():
    frame = paint(CORNERS)
    cv2.rectangle(frame, (90, 60), (230, 140), 128, -1)
    quads, found, _ = fit_tags(frame, [CORNERS], CELLS)
    assert not found[0]
    np.testing.assert_array_equal(quads[0], CORNERS)


def test_nothing_is_found_without_a_tag(random):
    for frame in (np.full((280, 320), 127, np.uint8), random.randint(0, 256, (280, 320)).astype(np.uint8)):
        assert not fit_tags(frame, [CORNERS, CORNERS - 300], CELLS[[0, 0]])[1].any()


def test_room_is_how_far_all_corners_are_within_the_frame():
    frame = np.zeros((100, 200), np.uint8)
    quad = np.array([[20.0, 30], [60, 30], [60, 70], [20, 70]])
    moved = [quad, quad - [25, 0], quad + [0, 29], quad + [145, 0], quad * np.nan]
    assert room_of(np.array(moved), frame).tolist() == [20, -5, 0, -6, -np.inf]


@pytest.mark.parametrize('color', ['dark', 'skin', 'white'])
@pytest.mark.parametrize('turns', range(4))
def test_where_something_covers_an_edge_the_others_and_the_cells_say_where_it_is(color, turns):
    corners = np.roll(CORNERS, turns, axis=0)
    frame = cv2.cvtColor(cv2.GaussianBlur(paint(corners), (0, 0), 0.7), cv2.COLOR_GRAY2BGR)
    Cover(color, 'below').put(frame, corners, 0.11)
    quads, found, likeness = fit_tags(frame, corners[None] + np.float32([0.8, -0.6]), CELLS)
    assert found[0] and np.abs(quads[0] - corners).max() < 0.15
    assert likeness[0] < (0.995 if color == 'dark' else 0.9)  # so it counts less than one that is whole
