"""Fitting tags to their edges in the frame, and checking that they are these tags; the method is in edges.c."""
from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.compiled import binding


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


def side_of(quads: Floats) -> Floats:
    """(n,) pixels: the mean side of quadrilaterals, (n, 4, 2)."""
    along = quads - quads[:, [1, 2, 3, 0]]
    return np.sqrt((along * along).sum(axis=2)).sum(axis=1) / 4


def sample_cells(frame: Image, quads: Floats, count: int, margin: int = 0) -> Floats:
    """The gray in the middle of each cell of quadrilaterals: (n, k) float32, row by row.

    ``frame``: see fit_tags. ``quads``: (n, 4, 2) float32, each ``count`` cells
    wide. ``margin``: cells at the rim that are left out, so
    k = (count - 2 * margin)**2; if negative, cells around are included.
    """
    points = _cell_weights(count, margin) @ quads
    seen = cv2.remap(frame, points, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.array(seen if seen.ndim == 2 else cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), np.float32)


@lru_cache
def _cell_weights(count: int, margin: int) -> Floats:
    """(k, 4): the middle of each cell, without a margin, as the weights of the tag's corners in a mean."""
    middle = (np.arange(margin, count - margin) + 0.5) / count
    y, x = (part.ravel() for part in np.meshgrid(middle, middle, indexing='ij'))
    return np.array([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], np.float32).T
