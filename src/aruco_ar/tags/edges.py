"""Fitting tags to their edges in the frame, and checking that they are these tags; see tag_edges.c."""
from __future__ import annotations

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.compiled import binding

SAMPLES = 3  # of each cell in both directions, if all of a tag is compared
WHITE, UNEVEN, MARGIN = 1, 2, 3  # what guess_tags may say of a quadrilateral


def fit_tags(frame: Image, quads: Floats, cells: Image) -> tuple[Floats, Booleans, Floats]:
    """Move quadrilaterals exactly onto the edges of tags.

    ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``quads``: (n, 4, 2)
    pixels, off by less than about a cell. ``cells``: (n, m, m) uint8, the
    cells of the tags (see tag_cells).

    Returns the quadrilaterals, (n, 4, 2) float32; whether all four edges were
    found, (n,) bool; and the likeness, (n,) float32: the correlation of what is
    seen with the tag's cells, 1 if they are the same. If something covers one
    of its edges, the others and the edges between its cells may say where that
    is. Then its likeness is lower, since its border is compared, too. If that
    fails, edges are not found, and the quadrilateral is returned unchanged.
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


def check_tags(frame: Image, quads: Floats, cells: Image) -> tuple[Floats, Booleans, Floats, Floats, Image]:
    """As fit_tags, but each tag may also be white on black, and all of it is compared.

    Also returns what compare_tags says of the fitted tags, and the cells as they are seen, (n, m, m) uint8,
    negated if they are white on black.
    """
    return binding.check_tags(frame, quads, cells, SAMPLES)


def guess_tags(frame: Image, quads: Floats, count: int, known: Floats, contrast: float) -> Image:
    """(n,) uint8: what quadrilaterals, (n, 4, 2), may be that OpenCV finds, but does not read.

    WHITE: a tag that is white on black. UNEVEN: one that is in the light on one side and in a shadow on the
    other. MARGIN: the black margin, about a cell wide, of a white tag. 0: none of these, or at the place of one
    of the tags that are ``known``, (k, 4, 2). ``count``: the width of a tag, cells. ``contrast``: the least one
    of a tag's border with what is around it, gray levels.
    """
    return binding.guess_tags(frame, quads, count, known, contrast)


def side_of(quads: Floats) -> Floats:
    """(n,) float64, pixels: the mean side of quadrilaterals, (n, 4, 2)."""
    return binding.find_sides(quads)


def room_of(quads: Floats, frame: Image) -> Floats:
    """(n,) float64, pixels: how far quadrilaterals, (n, 4, 2), are within a frame; negative outside of it."""
    return binding.find_room(quads, *frame.shape[1::-1])


def sample_cells(frame: Image, quads: Floats, count: int, margin: int = 0) -> Floats:
    """The gray in the middle of each cell of quadrilaterals: (n, k) float32, row by row.

    ``frame``: see fit_tags. ``quads``: (n, 4, 2) float32, each ``count`` cells
    wide and a square in perspective. ``margin``: cells at the rim that are left out, so
    k = (count - 2 * margin)**2; if negative, cells around are included.
    """
    return binding.sample_cells(frame, quads, count, margin)
