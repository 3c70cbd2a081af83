"""Fitting tags to the frame: where exactly their edges lie, and whether it is they.

Each edge of a tag, black inside and white outside, is looked at along short
lines across it, its profiles. How much of a profile is light says where the
edge crosses it, to some hundredths of a pixel and however blurred it is. Here
a point of the frame is one complex number, x + y j: turning by a right angle
is then a multiplication by 1j.
"""
from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from .arrays import NO_ARRAY, Booleans, Complexes, Floats, Image

SAMPLES = 12             # profiles along each edge
BEGIN, END = 0.08, 0.92  # of the edge, between which they lie: a corner's rounding stays out
PROFILE_POINTS = 15      # places at which each profile is looked at
# How far to both sides of an edge a profile reaches, in cells: to find the edge
# and to place it. The latter not too far, or shading would bend what is
# straight; and where an edge is off by more than NEAR of that, it is found first.
FIND, PLACE, NEAR = 0.95, 0.6, 0.4
MIN_FIND_PX, MIN_PLACE_PX, MAX_PLACE_PX = 1.8, 1.2, 5.0
MIN_CONTRAST = 12        # gray levels between the black border and the white around it
MAX_BEYOND = 0.25        # of the contrast, by which a profile may be darker or lighter than its ends
MAX_BENT = 0.35          # of the reach, by which half of an edge's profiles may be off its line

PART = np.linspace(BEGIN, END, SAMPLES, dtype=np.float32)
MIDDLE = np.float32((BEGIN + END) / 2)
ARM = PART - MIDDLE
POWERS = np.stack([np.ones_like(ARM), ARM, ARM * ARM], axis=1)
ACROSS = np.linspace(-1, 1, PROFILE_POINTS, dtype=np.float32)
PLACES = np.arange(PROFILE_POINTS)
END_POINTS = PROFILE_POINTS // 5
# Means over a profile's inner end and its outer end.
INNER, OUTER = np.zeros((2, PROFILE_POINTS), np.float32)
INNER[:END_POINTS] = OUTER[-END_POINTS:] = 1 / END_POINTS
TYPICAL = np.full(SAMPLES, 1 / SAMPLES, np.float32)  # the mean of an edge's profiles
STEADY = 0.5             # of an edge's contrast, which most of its profiles have where the rim is narrow
RIM = 0.9                # of the contrast: as light as this is the rim, which may end within a profile
ALL = np.ones(PROFILE_POINTS, np.float32)


def fit_tags(frame: Image, quads: Floats, cells: Image) -> tuple[Floats, Booleans, Floats]:
    """Put quadrilaterals onto the edges of the tags that they nearly lie on.

    ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``quads``: (n, 4, 2)
    pixels, off by less than about a cell. ``cells``: (n, m, m), what the tags
    look like (see tag_cells). Returns the quadrilaterals, (n, 4, 2) float32;
    (n,) bool, whether all four edges were found, as they are not on a tag in
    part covered (such a quadrilateral is left as it was); and (n,) the
    likeness of what is between them to that very tag, 1 if it is the same.
    """
    quads = np.ascontiguousarray(quads, np.float32)
    start = quads.view(np.complex64)[..., 0]  # (n, 4)
    cell = _depth_of(start) / cells.shape[1]
    find = np.maximum(FIND * cell, MIN_FIND_PX)
    place = np.clip(PLACE * cell, MIN_PLACE_PX, MAX_PLACE_PX)
    fitted, good = _fit_edges(frame, start, place)
    rest = ~(good & (np.abs(fitted - start) < NEAR * place).all(axis=1))
    if rest.any():
        found, good[rest] = _fit_edges(frame, start[rest], find[rest])
        for _ in range(2):
            found, placed = _fit_edges(frame, found, place[rest])
            good[rest] &= placed
        fitted[rest] = found
    quads = np.where(good[:, None, None], fitted[..., None].view(np.float32), quads)
    return quads, good, _likeness(frame, quads, cells)


def side_of(quads: Floats) -> Floats:
    """(n,) pixels: the mean side of quadrilaterals, (n, 4, 2)."""
    along = quads - quads[:, [1, 2, 3, 0]]
    return np.sqrt((along * along).sum(axis=2)).sum(axis=1) / 4


def _depth_of(quads: Complexes) -> Floats:
    """(n, 4) pixels: how far (n, 4) complex quadrilaterals reach across each of their edges.

    Seen from the side, a tag's cells are much narrower across its upright edges
    than along them.
    """
    along = quads[:, [1, 2, 3, 0]] - quads
    across, down = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    area = np.abs((across.conj() * down).imag) / 2
    return area[:, None] / np.maximum(np.abs(along), 1e-6)


def look_at_cells(frame: Image, quads: Floats, count: int, margin: int = 0) -> Floats:
    """The gray in the middles of cells, (n, k) float32, row by row, of quadrilaterals, (n, 4, 2) float32.

    ``frame``: see fit_tags. The quadrilaterals are ``count`` cells wide;
    ``margin`` cells around are left out, so k = (count - 2 * margin)**2.
    """
    return _look(frame, _cell_weights(count, margin) @ quads)


def _look(frame: Image, points: Floats) -> Floats:
    """(n, k) float32: the gray at (n, k, 2) float32 pixels, between pixels by linear interpolation."""
    seen = cv2.remap(frame, points, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.array(seen if seen.ndim == 2 else cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), np.float32)


def _fit_edges(frame: Image, quads: Complexes, reach: Floats) -> tuple[Complexes, Booleans]:
    """Fit (n, 4) complex quadrilaterals, reaching (n, 4) pixels far, where all edges are seen; and where."""
    along = quads[:, [1, 2, 3, 0]] - quads
    length = np.abs(along)
    outward = along * np.complex64(-1j) / np.maximum(length, 1e-6)
    along_edge = quads[..., None] + along[..., None] * PART                   # (n, 4, samples)
    across = (outward * reach)[..., None] * ACROSS                            # (n, 4, places)
    points = along_edge[..., None] + across[:, :, None]
    gray = _look(frame, points.reshape(len(quads) * 4, -1, 1).view(np.float32))
    gray = gray.reshape(-1, SAMPLES, PROFILE_POINTS)                          # (4 n, samples, places)
    # Black is the same along an edge; white has shades.
    dark = _median(gray @ INNER)[:, None, None]
    white, beyond = _rims(gray, dark[:, 0])
    contrast = white - dark                                                   # (4 n, samples, 1)
    share = (gray - dark) / np.maximum(contrast, 1)
    # What is far lighter or darker than both ends belongs to something else.
    np.maximum(share, -MAX_BEYOND, out=share)
    np.minimum(share, 1 + MAX_BEYOND, out=share)
    if beyond is not None:
        share[np.broadcast_to(beyond, share.shape)] = 1
    light = (share @ ALL).reshape(-1, 4, SAMPLES)
    step = reach * (2 / (PROFILE_POINTS - 1))
    offset = (PROFILE_POINTS / 2 - light) * step[..., None]                   # (n, 4, samples) outward
    # A straight line through the offsets, and once more without those unlike the rest.
    middle, slope, left = _fit_lines(offset, np.ones_like(offset))
    typical = _median(left)
    weight = (left <= 3 * typical[..., None] + 0.01 * reach[..., None]).astype(np.float32)
    middle, slope, left = _fit_lines(offset, weight)
    first = quads + (middle - slope * MIDDLE) * outward
    along = along + slope * outward
    # Each corner is where its edge crosses the one before.
    toward, before = along[:, [3, 0, 1, 2]], first[:, [3, 0, 1, 2]]
    crossed = (toward.conj() * along).imag
    far = ((first - before).conj() * along).imag / np.where(np.abs(crossed) < 1e-6, 1e-6, crossed)
    corners = before + far * toward
    typical_contrast = _median(contrast[..., 0])
    rimmed = typical_contrast > MIN_CONTRAST
    if beyond is not None:  # of noise, too, some place is the lightest, but not along all of an edge
        least = np.partition(contrast[..., 0], SAMPLES // 4, axis=1)[:, SAMPLES // 4]
        rimmed &= ~beyond.any(axis=(1, 2)) | (least > STEADY * typical_contrast)
    seen = rimmed.reshape(-1, 4) & (_median(left) < MAX_BENT * reach)
    good = (seen & (np.abs(corners - quads) < 3 * reach)).all(axis=1)
    return np.where(good[:, None], corners, quads).astype(np.complex64), good


def _rims(gray: Floats, dark: Floats) -> tuple[Floats, Booleans | None]:
    """How light the rim is along edges' profiles, (n, samples, places), and which places lie beyond it.

    ``dark``: (n, 1). Paper may be cut close to the tag, and what is beyond be
    of any shade. Returns (n, samples, 1), and (n, 1, places) or None where all
    rims reach to the profiles' ends.
    """
    white = gray @ OUTER[:, None]
    typical = TYPICAL @ gray                                                  # (n, places)
    light = typical >= dark + RIM * (typical.max(axis=1, keepdims=True) - dark)
    narrow = ~light[:, -1]
    if not narrow.any():
        return white, None
    begins = light.argmax(axis=1)[:, None]
    ended = (begins < PLACES) & ~light
    beyond = narrow[:, None] & (ended.argmax(axis=1)[:, None] <= PLACES)
    rim = np.asarray((begins <= PLACES) & ~beyond, np.float32)
    own = gray @ (rim / rim.sum(axis=1, keepdims=True))[..., None]
    return np.where(narrow[:, None, None], own, white), beyond[:, None]


def _fit_lines(offset: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """The lines middle + slope * ARM through offsets, (n, 4), and how far each is off, (n, 4, samples)."""
    powers, sums = weight @ POWERS, (weight * offset) @ POWERS
    count, first, second = powers[..., 0], powers[..., 1], powers[..., 2]
    weighted, leaning = sums[..., 0], sums[..., 1]
    slope = (count * leaning - first * weighted) / (count * second - first * first + 1e-9)
    middle = (weighted - slope * first) / count
    return middle, slope, np.abs(offset - middle[..., None] - slope[..., None] * ARM)


def _median(values: Floats) -> Floats:
    """The upper median over the last axis: numpy's own takes ten times as long on so few."""
    middle = values.shape[-1] // 2
    return np.partition(values, middle, axis=-1)[..., middle]


@lru_cache
def _cell_weights(count: int, margin: int) -> Floats:
    """(k, 4): the middles of a tag's cells, without so many around, as weighted means of its corners."""
    middle = (np.arange(margin, count - margin) + 0.5) / count
    y, x = (part.ravel() for part in np.meshgrid(middle, middle, indexing='ij'))
    return np.array([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], np.float32).T


def _likeness(frame: Image, quads: Floats, cells: Image) -> Floats:
    """(n,): the correlation of the frame with each tag's inner cells, 1 if they are the same."""
    gray = look_at_cells(frame, quads, cells.shape[1], 1)
    wanted = np.array(cells[:, 1:-1, 1:-1], np.float32).reshape(len(quads), -1)
    gray -= gray.sum(axis=1, keepdims=True) / gray.shape[1]
    wanted -= wanted.sum(axis=1, keepdims=True) / gray.shape[1]
    norm = np.einsum('nk,nk->n', gray, gray) * np.einsum('nk,nk->n', wanted, wanted)
    return np.einsum('nk,nk->n', gray, wanted) / np.sqrt(np.maximum(norm, 1e-6))
