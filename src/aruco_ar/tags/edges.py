"""Fitting tags to their edges in the frame, and checking that they are these tags; the method is in edges.c."""
from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.geometry.lines import cross

SAMPLES = 3  # of each cell in both directions, if all of a tag is compared
MIN_CROSS, MIN_DEPTH = 1e-6, 0.05  # limits for quadrilaterals that are no view of a square


def fit_tags(frame: Image, quads: Floats, cells: Image) -> tuple[Floats, Booleans, Floats]:
    """Move quadrilaterals exactly onto the edges of tags.

    ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``quads``: (n, 4, 2)
    pixels, off by less than about a cell. ``cells``: (n, m, m) uint8, the
    cells of the tags (see tag_cells).

    Returns the quadrilaterals, (n, 4, 2) float32; whether all four edges were
    found, (n,) bool; and the likeness, (n,) float32: the correlation of what is
    seen with the tag's cells, 1 if they are the same. Edges are not found if
    the tag is partly covered. Then the quadrilateral is returned unchanged.
    Raises InputError for arrays of other types and shapes.
    """
    return binding.fit_tags(frame, quads, cells)


def compare_tags(frame: Image, quads: Floats, cells: Image, samples: int = SAMPLES) -> Floats:
    """(n,) float32: the correlation of all that is seen in quadrilaterals with tags, black border included.

    Unlike the likeness (see fit_tags), this does not look at the middles of cells alone. So it is low for
    anything else in which these happen to be dark and light as in the tag. It is negative if what is seen is
    white on black. ``samples``: of each cell, in both directions. The others are those of fit_tags.
    """
    return binding.compare_tags(frame, quads, cells, samples)


def side_of(quads: Floats) -> Floats:
    """(n,) pixels: the mean side of quadrilaterals, (n, 4, 2)."""
    along = quads - quads[:, [1, 2, 3, 0]]
    return np.sqrt((along * along).sum(axis=2)).sum(axis=1) / 4


def sample_cells(frame: Image, quads: Floats, count: int, margin: int = 0) -> Floats:
    """The gray in the middle of each cell of quadrilaterals: (n, k) float32, row by row.

    ``frame``: see fit_tags. ``quads``: (n, 4, 2) float32, each ``count`` cells
    wide and a square in perspective. ``margin``: cells at the rim that are left out, so
    k = (count - 2 * margin)**2; if negative, cells around are included.
    """
    quads, (x, y) = np.asarray(quads, np.float32), _middles(count, margin)
    first, second, third, fourth = (quads[:, None, corner] for corner in range(4))
    # The homography from the unit square, as in homography_to, but for all quadrilaterals at once.
    one, other, rest = second - third, fourth - third, first - second + third - fourth
    area = cross(one, other)
    area = np.where(np.abs(area) < MIN_CROSS, MIN_CROSS, area)
    g, h = (cross(*pair) / area for pair in ((rest, other), (one, rest)))
    depth = np.maximum(g * x + h * y + 1, MIN_DEPTH)[..., None]
    g, h, x, y = g[..., None], h[..., None], x[:, None], y[:, None]
    points = ((second - first + g * second) * x + (fourth - first + h * fourth) * y + first) / depth
    seen = cv2.remap(frame, np.asarray(points, np.float32), NO_ARRAY, cv2.INTER_LINEAR,
                     borderMode=cv2.BORDER_REPLICATE)
    return np.array(seen if seen.ndim == 2 else cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), np.float32)


def across_sides(frame: Image, quads: Floats, count: int,
                 depths: tuple[float, float] = (0.5, -0.5)) -> tuple[Floats, Floats]:
    """(n, 4) and (n, 4): the gray at two depths in quadrilaterals, from the middle of each side.

    ``frame``: (h, w) uint8. ``depths``: cells; negative outside. The others are as in sample_cells.
    """
    seen = cv2.remap(frame, _across_sides(count, depths) @ quads, NO_ARRAY, cv2.INTER_LINEAR,
                     borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
    return seen[:, :4], seen[:, 4:]


@lru_cache
def _across_sides(count: int, depths: tuple[float, float]) -> Floats:
    """(8, 4): points at both depths from the middle of each side, in cells, as weights of the corners."""
    near = np.array([[0.5 * (corner in (side, (side + 1) % 4)) for corner in range(4)] for side in range(4)])
    return np.array([near + (near[[2, 3, 0, 1]] - near) * depth / count for depth in depths],
                    np.float32).reshape(8, 4)


@lru_cache
def _middles(count: int, margin: int) -> tuple[Floats, Floats]:
    """(k,) and (k,) float32: x and y of the middle of each cell in the unit square, without a margin."""
    middle = (np.arange(margin, count - margin, dtype=np.float32) + np.float32(0.5)) / np.float32(count)
    y, x = (part.ravel() for part in np.meshgrid(middle, middle, indexing='ij'))
    return x, y
