"""Fitting tags to the frame: where exactly their edges lie, and whether it is they. How is in edges.c."""
from __future__ import annotations

import ctypes
from functools import lru_cache

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.compiled import library

_C = library('edges')
_C.fit_tags.restype = None
_C.fit_tags.argtypes = [ctypes.c_void_p, ctypes.c_int64, *[ctypes.c_int] * 4, ctypes.c_void_p, ctypes.c_int,
                        *[ctypes.c_void_p] * 4]

# Where along an edge it is looked at, 0 being its beginning and 1 its end.
PART = np.ctypeslib.as_array((ctypes.c_float * ctypes.c_int.in_dll(_C, 'samples').value).in_dll(_C, 'parts'))


def fit_tags(frame: Image, quads: Floats, cells: Image) -> tuple[Floats, Booleans, Floats]:
    """Put quadrilaterals onto the edges of the tags that they nearly lie on.

    ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``quads``: (n, 4, 2)
    pixels, off by less than about a cell. ``cells``: (n, m, m) uint8, what the
    tags look like (see tag_cells). Returns the quadrilaterals, (n, 4, 2) float32;
    (n,) bool, whether all four edges were found, as they are not on a tag in
    part covered (such a quadrilateral is left as it was); and (n,) float32, the
    likeness of what is between them to that very tag, 1 if it is the same.
    """
    quads, cells = np.ascontiguousarray(quads, np.float32), np.ascontiguousarray(cells, np.uint8)
    count, channels = len(quads), frame.shape[2] if frame.ndim == 3 else 1
    if frame.strides[1:] != (channels, 1)[:frame.ndim - 1]:
        frame = np.ascontiguousarray(frame)
    fitted, found = np.empty((count, 4, 2), np.float32), np.empty(count, bool)
    likeness = np.empty(count, np.float32)
    _C.fit_tags(frame.ctypes.data, frame.strides[0], frame.shape[1], frame.shape[0], channels, count,
                quads.ctypes.data, cells.shape[1], cells.ctypes.data, fitted.ctypes.data, found.ctypes.data,
                likeness.ctypes.data)
    return fitted, found, likeness


def side_of(quads: Floats) -> Floats:
    """(n,) pixels: the mean side of quadrilaterals, (n, 4, 2)."""
    along = quads - quads[:, [1, 2, 3, 0]]
    return np.sqrt((along * along).sum(axis=2)).sum(axis=1) / 4


def look_at_cells(frame: Image, quads: Floats, count: int, margin: int = 0) -> Floats:
    """The gray in the middles of cells, (n, k) float32, row by row, of quadrilaterals, (n, 4, 2) float32.

    ``frame``: see fit_tags. The quadrilaterals are ``count`` cells wide;
    ``margin`` cells around are left out, so k = (count - 2 * margin)**2.
    """
    points = _cell_weights(count, margin) @ quads
    seen = cv2.remap(frame, points, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.array(seen if seen.ndim == 2 else cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), np.float32)


@lru_cache
def _cell_weights(count: int, margin: int) -> Floats:
    """(k, 4): the middles of a tag's cells, without so many around, as weighted means of its corners."""
    middle = (np.arange(margin, count - margin) + 0.5) / count
    y, x = (part.ravel() for part in np.meshgrid(middle, middle, indexing='ij'))
    return np.array([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], np.float32).T
