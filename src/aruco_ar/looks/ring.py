"""The ring: what a frame shows right around a tag or its paper."""
from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import UNIT_SQUARE
from aruco_ar.geometry.lens import Lens

COUNT = binding.RING_PLACES  # number of colors of a ring along each side
DARK = binding.DARK   # gray levels to add to colors before their ratios are taken, so that noise is no pattern

OUTWARD = np.array([[0.0, -1], [1, 0], [0, 1], [-1, 0]])  # of the sides of that square
AFTER = [1, 2, 3, 0]  # the numbers of the next ones


class Rings(NamedTuple):
    """What is right around n quadrilaterals, where their blur has ended.

    ``colors``: (n, 4 * COUNT, 3) float64, BGR, clockwise from the first corner. ``shown``: (n, 4 * COUNT),
    whether the frame shows that place. ``corners``: (n, 4, 2) float64, undistorted pixels: the quadrilaterals,
    grown by their blur. ``blurs``, ``depths``: (n,) float64, pixels, how far out the blur reaches, and the
    ground, on all sides but the worst one.
    """

    colors: Floats
    shown: Booleans
    corners: Floats
    blurs: Floats
    depths: Floats


def points_of_sides(count: int) -> Floats:
    """(4, count, 2) float64: points in even distances along the sides of the unit square, clockwise."""
    along = (np.arange(count) + 0.5)[:, None] / count
    return UNIT_SQUARE[:, None] + along * (UNIT_SQUARE[AFTER] - UNIT_SQUARE)[:, None]


def rings_around(frame: Image, lens: Lens | None, quads: Floats) -> Rings:
    """The Rings around quadrilaterals, (n, 4, 2) undistorted pixels, that differ from what is around them.

    ``frame``: (h, w, 3) BGR uint8. ``lens``: that of the frame, or None.
    """
    ways = binding.find_ways(quads)
    colors, shown, corners, reaches = binding.read_rings(
        frame, quads, ways if lens is None else lens.distort(ways))
    return Rings(colors, shown, corners, *reaches.T)


def colors_at(frame: Image, lens: Lens | None, points: Floats) -> tuple[Floats, Booleans]:
    """(..., 3) float32: the colors of a frame at points, or nearest to them, and (...) whether it shows them.

    ``frame``, ``lens``: see rings_around. ``points``: (..., 2), undistorted pixels.
    """
    return _colors_of(frame, points if lens is None else lens.distort(points))


def _colors_of(frame: Image, pixels: Floats) -> tuple[Floats, Booleans]:
    """The same for pixels of the frame, (..., 2)."""
    nearest = np.clip(pixels, 0, np.array(frame.shape[1::-1]) - 1)
    # In a map of this shape, OpenCV's limit of 32767 rows is far away.
    places = np.asarray(nearest, np.float32).reshape(-1, pixels.shape[-2], 2)
    colors = cv2.remap(frame, places, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    shown = np.all(pixels == nearest, axis=-1)
    return np.asarray(colors, np.float32).reshape(*shown.shape, 3), shown
