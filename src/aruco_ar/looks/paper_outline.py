"""What is not the wall around a tag: the tag itself, and its paper, if that ends near it on a plain wall."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_to, transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.lines import crossing

from .ring import AFTER, DARK, OUTWARD, colors_at

# Lengths are in sides of the tag.
STEP, STEPS = 0.015, 48      # the frame is looked at farther and farther out
ALONG = (np.arange(40) + 0.5) / 16 - 0.75  # places along a side, and beyond its ends
BESIDE = slice(12, 28)       # those of them that are beside the tag
ALIKE = 0.13                 # what is plain varies by less than this share of its color
PLAIN = 0.95                 # share of the places around the tag that must be alike
EQUAL = 0.3                  # colors on its four sides differ by less than this share
LAG, STEADY = 2, 0.04        # it changes by less than this share within so many steps in and out
NARROW = 0.06                # what is plain for less than this is the blur of an edge
NEAR, GOES_ON = 0.16, 0.4    # what begins so near the tag is its paper; if it goes on so far, it is the wall
STRAIGHT, OFF_LINE = 0.75, 0.04  # so much of the paper's edge must be so near to a straight line

BEGIN = UNIT_SQUARE[:, None] + ALONG[:, None] * (UNIT_SQUARE[AFTER] - UNIT_SQUARE)[:, None]
OUT = STEP * (np.arange(STEPS) + 1)
POINTS = BEGIN[:, :, None] + OUT[:, None] * OUTWARD[:, None, None]   # (4, len(ALONG), STEPS, 2)
AROUND = np.abs(ALONG[:, None] - 0.5) <= 0.5 + OUT  # (len(ALONG), STEPS): a square around the tag for each step


def paper_of(frame: Image, quad: Floats, lens: Lens | None) -> Floats | None:
    """(4, 2) float64: the outline of a tag or of its paper, where the tag is the unit square, or None.

    ``frame``: (h, w, 3) BGR uint8. ``quad``: (4, 2) undistorted pixels, the tag's corners. ``lens``: that of
    the frame, or None. The result is the tag's own outline if its paper has no end in sight. It is None if
    nothing tells what is behind the paper, since the wall around it is not plain.
    """
    colors, shown = colors_at(frame, lens, transform(homography_to(quad), POINTS))
    colors += DARK
    usual = np.median(colors[:, BESIDE], axis=1)                     # (4, STEPS, 3)
    alike = shown & _alike(colors, usual[:, None])
    plain = np.sum(alike & AROUND, axis=(0, 1)) >= PLAIN * 4 * AROUND.sum(axis=0)
    plain &= np.abs(usual / usual.mean(axis=0) - 1).max(axis=(0, 2)) < EQUAL
    change = np.abs(usual[:, 2 * LAG:] / usual[:, :-2 * LAG] - 1).max(axis=(0, 2))
    plain[LAG:-LAG] &= change < STEADY
    runs = _runs(plain)
    if runs and OUT[runs[0][0]] <= NEAR:
        paper = runs.pop(0)
        if OUT[paper[1] - 1] >= GOES_ON:
            return UNIT_SQUARE
    if not runs:
        return None
    begin, end = runs[0]
    # Somewhere farther in than this, on each side, the wall's color ends.
    wall = np.median(usual[:, begin:end], axis=1)
    others = ~_alike(colors[:, BESIDE, :begin], wall[:, None, None])  # (4, 16, begin)
    margin = np.where(others.any(axis=2), OUT[begin - 1 - others[:, :, ::-1].argmax(axis=2)], 0.0)
    return _straight(margin)


def _alike(colors: Floats, usual: Floats) -> Booleans:
    """(...): whether colors, (..., 3), are like the usual ones, (..., 3)."""
    near = np.abs(colors / usual - 1) < ALIKE
    return np.asarray(near[..., 0] & near[..., 1] & near[..., 2])  # by NumPy's all, it takes many times as long


def _runs(plain: Booleans) -> list[tuple[int, int]]:
    """The first steps, and those after the last ones, of what is plain for long enough."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], plain, [False]]).astype(np.int8)))
    return [(begin, end) for begin, end in edges.reshape(-1, 2).tolist() if (end - begin) * STEP >= NARROW]


def _straight(margin: Floats) -> Floats | None:
    """(4, 2): the corners of paper that ends so far from the tag's sides, (4, n); None if it is bent."""
    half = margin.shape[1] // 2
    left, right = np.median(margin[:, :half], axis=1), np.median(margin[:, half:], axis=1)
    lines = left[:, None] + (right - left)[:, None] * (ALONG[BESIDE] - 0.25) / 0.5
    if (np.abs(margin - lines) < OFF_LINE).mean(axis=1).min() < STRAIGHT:
        return None
    ends = np.maximum(lines[:, [0, -1]], 0) + STEP
    begin, end = (BEGIN[:, BESIDE][:, at] + ends[:, at, None] * OUTWARD for at in (0, -1))
    return crossing(np.roll(begin, 1, axis=0), np.roll(end - begin, 1, axis=0), begin, end - begin)
