"""Tags of which something covers a side: the edge of what covers it is taken for the tag's own.

Such a tag is found too short, but its cells are where they were. So, if that side is moved outward to where it
was, what is seen within the border is more like the tag. On a sheet that is bent this is not so.
"""
from __future__ import annotations

from typing import Mapping, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_to, transform

from .edges import sample_cells

SAMPLES = 4           # of each cell in both directions
BLURS = 0, 0.15, 0.25, 0.35, 0.5, 0.7  # the standard deviations that the frame's blur may have, cells
# How far a side is moved, in sides of the tag: coarsely, and then, if that may help, finely.
COARSE, FINE = np.array([0, 0.03, 0.06, 0.09, 0.13, 0.18]), np.arange(0, 0.231, 0.01)
# What is seen must become less unlike the tag by the first factor, so that moving a side may help. It helps if
# it does so by the second one, and a corner moves farther than LEAST_PX. If it is known how far a side must be
# moved, the third factor is enough.
MAY_HELP, HELPS, HELPS_AS_EXPECTED = 1.3, 3.0, 1.5
LEAST_PX = 1.0
# So many edges between dark and light cells must be in the half of the tag next to a side. Otherwise what is
# seen does not say where that side is.
LEAST_EDGES = 2
OUTWARD = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]])  # of the sides of the unit square, from the top on


class Completion:
    """Completes one tag.

    ``cells``: (m, m) uint8, its cells (see tag_cells). ``border``: the width of its border, cells.
    """

    def __init__(self, cells: Image, border: int) -> None:
        self._count, self._border = len(cells), border
        self._sides = [side for side in range(4) if _edges_near(cells, side) >= LEAST_EDGES]
        self._looks = _looks(cells, border)

    def complete(self, frame: Image, quad: Floats) -> Floats | None:
        """(4, 2) float32 pixels: the tag without what covers a side of it; None if nothing seems to.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``quad``: (4, 2) pixels, its corners as they were found.
        """
        if not self._sides:
            return None
        unlike = self._unlike(frame, _moved(quad, self._sides, COARSE))
        if unlike[0, 0] < MAY_HELP * unlike.min():
            return None
        moved = _moved(quad, self._sides, FINE)
        unlike = self._unlike(frame, moved)
        side, step = np.unravel_index(unlike.argmin(), unlike.shape)
        completed = moved[side, step]
        if 0 < step < len(FINE) - 1:  # the least of the parabola through three values
            before, least, after = unlike[side, step - 1:step + 2]
            finer = (before - after) / max(2 * (before - 2 * least + after), 1e-9)
            completed += finer * (moved[side, step + 1] - completed)
        far = np.linalg.norm(completed - quad, axis=1).max()
        is_covered = unlike[0, 0] > HELPS * unlike.min() and far > LEAST_PX
        return np.asarray(completed, np.float32) if is_covered else None

    def covered_side(self, frame: Image, quad: Floats, completed: Mapping[int, Floats]) -> int | None:
        """Which side of a tag is covered: 0, 1, 2, 3 from the top on, clockwise; None if it seems that none is.

        ``completed``: {side: (4, 2) pixels}, its corners if that side is covered. For the others see complete.
        """
        sides = [side for side in completed if side in self._sides]
        if not sides:
            return None
        quads = np.array([quad, *(completed[side] for side in sides)], np.float64)
        found, *others = self._unlike(frame, quads[None])[0].tolist()
        return sides[int(np.argmin(others))] if found > HELPS_AS_EXPECTED * min(others) else None

    def _unlike(self, frame: Image, quads: Floats) -> Floats:
        """(n, k): how unlike the tag is what is seen in quadrilaterals, (n, k, 4, 2); 0 if they are the same.

        All are compared as blurred as the one that is most like it.
        """
        seen = sample_cells(frame, np.asarray(quads.reshape(-1, 4, 2), np.float32), SAMPLES * self._count,
                            SAMPLES * self._border)
        seen -= seen.mean(axis=1, keepdims=True)
        like = seen @ self._looks.T / np.maximum(np.linalg.norm(seen, axis=1, keepdims=True), 1e-6)
        return np.maximum(1 - like[:, like.max(axis=0).argmax()], 1e-6).reshape(quads.shape[:2])


def _edges_near(cells: Image, side: int) -> int:
    """How many edges between dark and light cells run along a side, in the half of the tag next to it."""
    return int(np.count_nonzero(np.diff(np.rot90(cells, side) > 127, axis=0)[:len(cells) // 2]))


def _looks(cells: Image, border: int) -> Floats:
    """(n, k) float32: what the samples within the border are for each of n blurs; of mean 0 and length 1."""
    tag = np.kron(np.pad(cells, 1, constant_values=255 - cells[0, 0]), np.ones((SAMPLES, SAMPLES)))
    rim = SAMPLES * (border + 1)
    seen = [cv2.GaussianBlur(tag, (0, 0), blur * SAMPLES) if blur else tag for blur in BLURS]
    looks = np.array([look[rim:-rim, rim:-rim].ravel() for look in seen])
    looks -= looks.mean(axis=1, keepdims=True)
    return np.asarray(looks / np.maximum(np.linalg.norm(looks, axis=1, keepdims=True), 1e-6), np.float32)


def _moved(quad: Floats, sides: Sequence[int], ways: Floats) -> Floats:
    """(n, k, 4, 2) pixels: a quadrilateral, (4, 2), with one of n sides moved outward by one of k ways.

    ``ways``: (k,), in lengths of the sides that are then longer.
    """
    corners = np.tile(UNIT_SQUARE, (len(sides), len(ways), 1, 1))
    for number, side in enumerate(sides):
        corners[number][:, [side, (side + 1) % 4]] += np.multiply.outer(ways, OUTWARD[side])[:, None]
    return transform(homography_to(quad), corners)
