"""Finding quadrilaterals in a frame, and reading the tags that they are; see quads.c and tag_reading.c."""
from __future__ import annotations

from functools import lru_cache

import numpy as np

from aruco_ar.base.arrays import Floats, Image, Integers
from aruco_ar.compiled import binding

from .tag import get_dictionary

WIDEST_WINDOW = binding.WIDEST_WINDOW
UNREAD, UNSURE = -1, -2  # what read_tags says instead of an id


def find_quads(gray: Image, window: int, shortest: float) -> Floats:
    """The quadrilaterals in an image that are darker inside than outside, or lighter: (n, 4, 2) float32 pixels.

    Their corners are in clockwise order and exact to about a quarter of a pixel. A pixel counts as dark if it
    is darker than the mean of the window around it.

    ``gray``: (h, w) uint8. ``window``: its width, pixels, an odd number from 3 to WIDEST_WINDOW. ``shortest``:
    the least sum of the four sides, pixels. Raises InputError for other arguments.
    """
    return binding.find_quads(gray, window, shortest)


def read_tags(frame: Image, quads: Floats, words: Integers, size: int, border: int,
              corrected: int, contrast: float) -> tuple[Integers, Floats]:
    """Read the tags in quadrilaterals, black on white or white on black.

    Returns (n,) int32, the id of each; UNREAD for what is no tag; and UNSURE for what may be either of two
    tags, or is in the same place as a better reading. And the quadrilaterals, (n, 4, 2) float32, those of tags
    from their own top left.

    ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``quads``: (n, 4, 2) pixels. ``words``: see tag_words.
    ``size``: the width of a tag without its border, cells. ``border``: that of the border, cells.
    ``corrected``: how many cells may be wrong. ``contrast``: the least one of the border of a white tag with
    what is around it, gray levels. Raises InputError for other arguments.
    """
    return binding.read_tags(frame, quads, words, size, border, corrected, contrast)


@lru_cache(maxsize=None)  # some nodes make a Detector for each frame
def tag_words(dictionary: str) -> Integers:
    """(n, 4) uint64: the cells of each tag of a dictionary as bits, as they are seen from each of its corners.

    The cells are taken row by row from the top left, the first one as the lowest bit; light ones are 1. Only
    for dictionaries of at most 64 cells a tag, which are all that OpenCV has.
    """
    cells = inner_cells(dictionary)
    turned = np.stack([np.rot90(cells, turns, axes=(1, 2)).reshape(len(cells), -1) for turns in range(4)],
                      axis=1)
    bits = np.arange(turned.shape[2], dtype=np.uint64)
    return (turned.astype(np.uint64) << bits).sum(axis=2, dtype=np.uint64)


def inner_cells(dictionary: str) -> Image:
    """(n, m, m) uint8: the cells of all tags of a dictionary, without their borders, 0 black and 1 white."""
    marker = get_dictionary(dictionary)
    count, size = len(marker.bytesList), marker.markerSize
    # Each tag has its bytes four times, once for each turn. The last one may be filled only in part.
    rows = np.unpackbits(np.asarray(marker.bytesList, np.uint8).reshape(count, 4, -1)[:, 0], axis=1)
    whole, rest = size * size // 8 * 8, size * size % 8
    return np.concatenate([rows[:, :whole], rows[:, rows.shape[1] - rest:]], axis=1).reshape(count, size, size)
