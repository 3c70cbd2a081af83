"""The area of a frame, seen straight from the front."""
import numpy as np
import pytest
from aruco_ar import Area


@pytest.mark.parametrize('side', [399, 1978, 1982, 1989, 1999])
def test_each_pixel_shows_its_own_place_however_large_the_area_is_in_the_frame(side):
    size = 240, 160
    frame = np.arange(2100, dtype=np.float32)[None, :, None].repeat(1400, axis=0).repeat(3, axis=2)
    left, top, right, foot = 40.3, 30.6, 40.3 + side, 30.6 + side * 2 / 3
    area = Area(np.float32([[left, top], [right, top], [right, foot], [left, foot]]))
    seen = area.rectified(frame, size)[2:-2, 2:-2, 0].mean(axis=0)
    places = left + np.arange(size[0]) / size[0] * side  # as in the course, (0, 0) is at the area's corner
    np.testing.assert_allclose(seen, places[2:-2], atol=0.1 * side / size[0])
