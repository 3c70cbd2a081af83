"""The ring: what a frame shows right around a tag or its paper."""
from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_to
from aruco_ar.geometry.lens import Lens

COUNT = binding.RING_PLACES  # number of colors of a ring along each side
MAX_REACH = 0.4       # the frame is looked at so far out from a side, at most, in lengths of a side
INSIDE = 0.05         # where the color inside of a side is taken, in lengths of a side
DARK = binding.DARK   # gray levels to add to colors before their ratios are taken, so that noise is no pattern

OUTWARD = np.array([[0.0, -1], [1, 0], [0, 1], [-1, 0]])  # of the sides of that square
AFTER, BEFORE = [1, 2, 3, 0], [3, 0, 1, 2]                # the numbers of their neighbors


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


# The two ends of the way out from each place of a side, (8 * COUNT, 2). Neither a lens nor a slant bends it.
WAYS = (points_of_sides(COUNT)[:, :, None]
        + np.array([[-INSIDE], [MAX_REACH]]) * OUTWARD[:, None, None]).reshape(-1, 2)


def rings_around(frame: Image, lens: Lens | None, quads: Floats) -> Rings:
    """The Rings around quadrilaterals, (n, 4, 2) undistorted pixels, that differ from what is around them.

    ``frame``: (h, w, 3) BGR uint8. ``lens``: that of the frame, or None.
    """
    lengths = np.linalg.norm(quads[:, AFTER] - quads, axis=2)
    across = np.maximum((lengths[:, AFTER] + lengths[:, BEFORE]) / 2, 1)[..., None]  # px, to the opposite side
    offsets = np.minimum(binding.RING_OFFSETS_PX / across, MAX_REACH)
    homographies = np.stack([homography_to(quad) for quad in quads])
    ends = _transformed(homographies, WAYS)
    if lens is not None:
        ends = lens.distort(ends)
    parts = np.concatenate([np.zeros((len(quads), 4, 1)), (offsets + INSIDE) / (MAX_REACH + INSIDE)], axis=2)
    colors, shown, depths = binding.read_rings(frame, ends.reshape(-1, 4, COUNT, 2, 2), parts,
                                               np.maximum((offsets < MAX_REACH).sum(axis=2), 1))
    # One offset farther than the blur: on the very rim of a cover, a little of it would be seen as a thin line.
    number, side = np.arange(len(quads))[:, None], np.arange(4)
    reach = offsets[number, side, np.minimum(depths[..., 0] + 1, depths[..., 1])][..., None]
    corners = UNIT_SQUARE + reach * OUTWARD + reach[:, BEFORE] * OUTWARD[BEFORE]
    far = np.sort(offsets[number[..., None], side[:, None], depths] * across, axis=1)
    return Rings(colors.reshape(len(quads), -1, 3), shown.reshape(len(quads), -1),
                 _transformed(homographies, corners), far[:, 2, 0], far[:, 1, 1])


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


def _transformed(homographies: Floats, points: Floats) -> Floats:
    """(n, m, 2): where n homographies, (n, 3, 3), map points, (n, m, 2) or (m, 2)."""
    mapped = points @ homographies[:, :, :2].transpose(0, 2, 1) + homographies[:, None, :, 2]
    return np.asarray(mapped[..., :2] / mapped[..., 2:])
