"""The area of a frame, seen straight from the front."""
import numpy as np
import pytest
from aruco_ar import Area, Lens


@pytest.mark.parametrize('side', [399, 1978, 1982, 1989, 1999])
def test_each_pixel_shows_its_own_place_however_large_the_area_is_in_the_frame(side):
    size = 240, 160
    frame = np.arange(2100, dtype=np.float32)[None, :, None].repeat(1400, axis=0).repeat(3, axis=2)
    left, top, right, foot = 40.3, 30.6, 40.3 + side, 30.6 + side * 2 / 3
    area = Area(np.float32([[left, top], [right, top], [right, foot], [left, foot]]))
    seen = area.rectified(frame, size)[2:-2, 2:-2, 0].mean(axis=0)
    places = left + np.arange(size[0]) / size[0] * side  # as in the course, (0, 0) is at the area's corner
    np.testing.assert_allclose(seen, places[2:-2], atol=0.1 * side / size[0])


@pytest.mark.parametrize('right, down, away', [(0.0, 0.0, 2.0), (0.8, 0.0, 2.0), (-0.3, 1.1, 1.5)])
def test_the_slope_says_from_which_side_a_frame_shows_the_area(right, down, away):
    lens = Lens(640, 480, np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]]), np.zeros(5))
    wall = np.array([[-0.6, -0.4, 0], [0.6, -0.4, 0], [0.6, 0.4, 0], [-0.6, 0.4, 0]])
    forward = np.array([-right, -down, away]) / np.linalg.norm([right, down, away])
    across = np.cross([0, 1, 0], forward) / np.linalg.norm(np.cross([0, 1, 0], forward))
    seen = (wall - (right, down, -away)) @ np.stack([across, np.cross(forward, across), forward]).T
    corners = np.float32((seen @ lens.matrix.T)[:, :2] / seen[:, 2:])
    slope = Area(corners, 1.5, lens).slope(np.zeros((480, 640, 3), np.uint8))
    np.testing.assert_allclose(slope, (right / away, down / away), atol=0.01)


@pytest.mark.parametrize('side', [399, 1900])
def test_half_of_the_pixels_show_the_means_of_two(side):
    y, x = np.mgrid[:1400, :2100].astype(np.float32)
    frame = np.dstack([128 + 100 * np.sin(x / 40), 128 + 100 * np.cos(y / 30), 128 + 60 * np.sin((x + y) / 50)])
    left, top, right, foot = 40.3, 30.6, 40.3 + side, 30.6 + side * 2 / 3
    area = Area(np.float32([[left, top], [right, top + 20], [right - 30, foot], [left, foot]]))
    whole, half = area.rectified(np.uint8(frame), (240, 160)), area.rectified(np.uint8(frame), (120, 80), 0.25)
    means = whole.reshape(80, 2, 120, 2, 3).mean(axis=(1, 3))
    assert np.abs(half - means)[1:-1, 1:-1].max() < 4


def test_the_rim_of_a_large_frame_of_an_odd_size_is_seen():
    frame = np.full((1403, 2101, 3), 200, np.uint8)
    area = Area(np.float32([[30, 30], [2098, 30], [2098, 1400], [30, 1400]]))
    assert np.all(area.rectified(frame, (240, 160)) == 200)
