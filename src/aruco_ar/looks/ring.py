"""The ring: what a frame shows right around a tag or its paper."""
from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image, Integers
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_to
from aruco_ar.geometry.lens import Lens

COUNT = 16            # number of colors of a ring along each side
# How far out from a side the frame is looked at, in pixels of the frame, and at most in lengths of a side.
OFFSETS_PX = np.array([0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 7, 9, 12, 16, 20, 26])
MAX_REACH = 0.4
INSIDE = 0.05         # where the color inside of a side is taken, in lengths of a side
# While the contrast to the inside rises by this share of it and by so many gray levels, the blur has not ended.
RISE, RISE_LEVELS = 0.03, 1.0
# Another thing begins where the contrast changes by more than this share and so many gray levels.
OTHER, OTHER_LEVELS = 0.15, 8.0
SETTLED, SETTLED_LEVELS = 0.02, 1.0  # the contrast beyond the blur differs from the usual one by less than this
DEPTH_PX = 3.0        # a color of the ring is a mean over this depth
DARK = 12.0           # gray levels to add to colors before their ratios are taken, so that noise is no pattern

OUTWARD = np.array([[0.0, -1], [1, 0], [0, 1], [-1, 0]])  # of the sides of that square
AFTER, BEFORE = [1, 2, 3, 0], [3, 0, 1, 2]                # the numbers of their neighbors
MEAN = np.full((1, 3), 1 / 3, np.float32)                 # of the channels


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


POINTS = points_of_sides(COUNT)


def rings_around(frame: Image, lens: Lens | None, quads: Floats) -> Rings:
    """The Rings around quadrilaterals, (n, 4, 2) undistorted pixels, that differ from what is around them.

    ``frame``: (h, w, 3) BGR uint8. ``lens``: that of the frame, or None.
    """
    count, sides = len(quads), 4 * len(quads)
    lengths = np.linalg.norm(quads[:, AFTER] - quads, axis=2)
    across = np.maximum((lengths[:, AFTER] + lengths[:, BEFORE]) / 2, 1)  # px, to the opposite side
    offsets = np.minimum(OFFSETS_PX / across[..., None], MAX_REACH).reshape(sides, -1)
    # The two ends of the way out from each place of a side. Neither a lens nor a slant bends so short a way.
    ways = POINTS[:, :, None] + np.array([[-INSIDE], [MAX_REACH]]) * OUTWARD[:, None, None]
    homographies = np.stack([homography_to(quad) for quad in quads])
    ends = _transformed(homographies, np.broadcast_to(ways.reshape(-1, 2), (count, ways.size // 2, 2)))
    inner, outer = np.moveaxis((ends if lens is None else lens.distort(ends)).reshape(sides, COUNT, 2, 2), 2, 0)
    parts = np.concatenate([np.zeros((sides, 1)), (offsets + INSIDE) / (MAX_REACH + INSIDE)], axis=1)
    colors, shown = _colors_of(frame, inner[:, :, None] + parts[:, None, :, None] * (outer - inner)[:, :, None])
    gray = np.asarray(cv2.transform(colors.reshape(1, -1, 3), MEAN), np.float32).reshape(colors.shape[:3])
    profiles = middle(gray, axis=1)
    inside = middle(profiles[:, 0].reshape(count, 4), axis=1).repeat(4)
    first, last, shares = _depths(np.abs(profiles[:, 1:] - inside[:, None]), offsets < MAX_REACH)
    # One offset farther than the blur: on the very rim of a cover, a little of it would be seen as a thin line.
    reach = offsets[np.arange(sides), np.minimum(first + 1, last)].reshape(count, 4)
    corners = UNIT_SQUARE + reach[..., None] * OUTWARD + reach[:, BEFORE, None] * OUTWARD[BEFORE]
    blurs, depths = ((offsets[np.arange(sides), at] * across.ravel()).reshape(count, 4) for at in (first, last))
    return Rings((shares[:, None, None] @ colors[:, :, 1:]).reshape(count, -1, 3).astype(np.float64),
                 (shown[:, :, 1:] | (shares[:, None] == 0)).all(axis=2).reshape(count, -1),
                 _transformed(homographies, corners), np.sort(blurs, axis=1)[:, 2],
                 np.sort(depths, axis=1)[:, 1])


def colors_at(frame: Image, lens: Lens | None, points: Floats) -> tuple[Floats, Booleans]:
    """(..., 3) float32: the colors of a frame at points, or nearest to them, and (...) whether it shows them.

    ``frame``, ``lens``: see rings_around. ``points``: (..., 2), undistorted pixels.
    """
    return _colors_of(frame, points if lens is None else lens.distort(points))


def middle(values: Floats, axis: int = 0, share: float = 0.5) -> Floats:
    """What this share of values is less than: by default the median, which takes NumPy many times as long.

    Of two numbers in the middle, it is the larger one.
    """
    number = int(values.shape[axis] * share)
    return np.asarray(np.partition(values, number, axis=axis).take(number, axis=axis))


def _colors_of(frame: Image, pixels: Floats) -> tuple[Floats, Booleans]:
    """The same for pixels of the frame, (..., 2)."""
    nearest = np.clip(pixels, 0, np.array(frame.shape[1::-1]) - 1)
    # In a map of this shape, OpenCV's limit of 32767 rows is far away.
    places = np.asarray(nearest, np.float32).reshape(-1, pixels.shape[-2], 2)
    colors = cv2.remap(frame, places, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    shown = np.all(pixels == nearest, axis=-1)
    return np.asarray(colors, np.float32).reshape(*shown.shape, 3), shown


def _transformed(homographies: Floats, points: Floats) -> Floats:
    """(n, m, 2): where n homographies, (n, 3, 3), map points, (n, m, 2)."""
    mapped = points @ homographies[:, :, :2].transpose(0, 2, 1) + homographies[:, None, :, 2]
    return np.asarray(mapped[..., :2] / mapped[..., 2:])


def _depths(contrast: Floats, near: Booleans) -> tuple[Integers, Integers, Floats]:
    """For n sides, the first offset beyond the blur, the last one of the ground, and all shares in the color.

    Each four sides belong together. The offsets are given by their numbers, (n,). The shares are (n, k).

    ``contrast``: (n, k), to what is inside. Close to the side it is less, because of the blur, and then it may
    be too much, since many cameras sharpen. Farther out, another thing may begin. ``near``: (n, k), which
    offsets count.
    """
    rows, columns = np.arange(len(contrast)), np.arange(contrast.shape[1])
    count = np.maximum(near.sum(axis=1), 1)
    rise = contrast[:, 1:] - contrast[:, :-1]
    ended = rise < np.maximum(RISE * contrast[:, :-1], RISE_LEVELS)
    begin = np.minimum(np.where(ended.any(axis=1), ended.argmax(axis=1), len(columns) - 1), count - 1)
    at_begin = contrast[rows, begin][:, None]
    other = np.abs(contrast - at_begin) > np.maximum(OTHER * at_begin, OTHER_LEVELS)
    other &= columns > begin[:, None]
    end = np.minimum(np.where(other.any(axis=1), other.argmax(axis=1), len(columns)), count)
    end -= (end < count) & (end - begin > 1)  # the other thing is blurred, too
    within = (columns >= begin[:, None]) & (columns < end[:, None])
    usual = np.sort(np.where(within, contrast, np.inf), axis=1)[rows, (end - begin - 1) // 2][:, None]
    settled = within & (np.abs(contrast - usual) <= np.maximum(SETTLED * usual, SETTLED_LEVELS))
    first = settled.argmax(axis=1).reshape(-1, 4)
    # On rough ground, the blur may seem to end too early on a side. It hardly does so on two of the four.
    first = np.minimum(np.maximum(first, np.sort(first, axis=1)[:, 1:2]).ravel(), end - 1)
    shares = within & (columns >= first[:, None]) & (OFFSETS_PX - OFFSETS_PX[first][:, None] <= DEPTH_PX)
    return first, end - 1, shares / shares.sum(axis=1, keepdims=True, dtype=np.float32)
