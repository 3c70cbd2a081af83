"""Whether a polygon was drawn: as lines of whatever width, or filled.

A polygon is (n, 2), pixels of the output. It may cross itself.
"""
from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Image, Numbers

NEAR_PX = 4.0          # a line or a rim may be that far from where it should be
REACH_PX = 24          # half the width of the widest line
LEAST_DRAWN = 0.85     # share of a line, or of a filled area, that must be drawn
LEAST_CORE = 50        # pixels: a smaller area is none
NARROW_PERCENT = 40    # share of a line's places, the narrowest, that tell where it is
STEP_PX = 2.0          # distance between the places at which a line is looked for


@dataclass(frozen=True)
class Line:
    """What is drawn along a line. ``share``: how much of it; ``offset``: how far off its middle is, pixels."""

    share: float
    offset: float

    @property
    def drawn(self) -> bool:
        """Whether the line is drawn, where it should be."""
        return self.share >= LEAST_DRAWN and abs(self.offset) <= NEAR_PX


def line_at(changed: Booleans, start: Numbers, end: Numbers, near: float = NEAR_PX, trim: float = 0.0) -> Line:
    """What is drawn along a line. ``near``: how far off it may be, ``trim``: what to skip at its ends, pixels.

    The offset is nan if the line is wider than 2 * REACH_PX, or not drawn.
    """
    start, end = np.asarray(start, np.float64), np.asarray(end, np.float64)
    length = float(np.hypot(*(end - start)))
    if length <= 2 * trim + STEP_PX:
        return Line(0.0, np.nan)
    direction = (end - start) / length
    normal = np.array([-direction[1], direction[0]])
    along = np.linspace(trim, length - trim, int((length - 2 * trim) / STEP_PX) + 2)
    across = np.arange(-REACH_PX, REACH_PX + 1)
    points = start + along[:, None, None] * direction + across[:, None] * normal
    # Wider by a pixel, so that no line of one pixel slips through between the places that are looked at.
    drawn = _at(cv2.dilate(changed.view(np.uint8), np.ones((3, 3), np.uint8)) > 0, points)
    # The end of the line may be out of the frame. What cannot be seen is not asked for.
    inside = _inside(changed, points[:, REACH_PX])
    if inside.mean() < 0.3:
        return Line(0.0, np.nan)
    drawn, distance = drawn[inside], np.abs(across)
    nearest = np.where(drawn, distance, REACH_PX + 1).argmin(axis=1)
    hit = np.where(drawn, distance, REACH_PX + 1).min(axis=1) <= near
    # For each place, the run of drawn pixels across the line that is nearest to it.
    index = np.arange(len(across))
    before = np.maximum.accumulate(np.where(drawn, -1, index), axis=1)
    behind = np.minimum.accumulate(np.where(drawn, len(across), index)[:, ::-1], axis=1)[:, ::-1]
    rows = np.arange(len(drawn))
    low, high = before[rows, nearest] + 1, behind[rows, nearest] - 1
    narrow = hit & (low > 0) & (high < len(across) - 1)
    if narrow.any():  # text beside the line makes it wider in places: the narrower ones tell where it is
        narrow &= high - low <= np.percentile((high - low)[narrow], NARROW_PERCENT)
    offset = float(np.median((low + high)[narrow] / 2 - REACH_PX)) if narrow.any() else np.nan
    return Line(float(hit.mean()), offset)


def _at(changed: Booleans, points: Floats) -> Booleans:
    """Whether something is drawn at points, (..., 2); False outside."""
    x, y = np.moveaxis(np.round(points).astype(int), -1, 0)
    height, width = changed.shape
    found = changed[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
    return found & _inside(changed, points)


def _inside(changed: Booleans, points: Floats) -> Booleans:
    x, y = np.moveaxis(np.round(points).astype(int), -1, 0)
    height, width = changed.shape
    return (x >= 0) & (y >= 0) & (x < width) & (y < height)


def outlined(changed: Booleans, polygon: Numbers, closed: bool = True, near: float = NEAR_PX) -> bool:
    """Whether lines are drawn from each corner of a polygon to the next; if ``closed``, also to the first."""
    polygon = np.asarray(polygon, np.float64)
    sides = list(zip(polygon, np.roll(polygon, -1, axis=0)))
    return all(line_at(changed, *side, near).drawn for side in (sides if closed else sides[:-1]))


def filled(changed: Booleans, polygon: Numbers, side: float, convex: bool = False) -> bool:
    """Whether the area of a polygon is drawn, and ends at its sides.

    ``side``: of a tag, pixels. With wide lines around it, the area may end farther outside, by the same at all
    sides, and by up to about a third of that. ``convex``: if the polygon is filled by OpenCV's
    fillConvexPoly, which makes something else of one that crosses itself.
    """
    area = area_mask(changed.shape, polygon, convex)
    # Most polygons are told apart by this already, which is quick.
    size = cv2.countNonZero(area)
    if size < LEAST_CORE or cv2.mean(changed.view(np.uint8), area)[0] < LEAST_DRAWN - 0.15:
        return False
    polygons = [np.asarray(polygon, np.float64)]
    if convex:
        contours, _ = cv2.findContours(area, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        polygons = [np.asarray(cv2.approxPolyDP(contour, 1.5, True)[:, 0], np.float64) for contour in contours]
    rims = np.array([rim for one in polygons for rim in _rims(changed, area, one)])
    if not len(rims) or np.isnan(rims).any():
        return False
    if np.abs(rims).max() > NEAR_PX and not (rims.min() >= 0 and rims.max() <= max(5, 0.35 * side)
                                             and np.ptp(rims) <= NEAR_PX):
        return False
    core = cv2.erode(area, np.ones((2 * int(NEAR_PX) + 1,) * 2, np.uint8)) > 0
    return int(core.sum()) >= LEAST_CORE and bool(changed[core].mean() >= LEAST_DRAWN)


def _rims(changed: Booleans, area: Image, polygon: Floats) -> list[float]:
    """For each side of a polygon, how far outside of it the drawn area ends, pixels; nan if there is none."""
    rims, across = [], np.arange(-REACH_PX, REACH_PX + 1)
    start = REACH_PX - int(NEAR_PX) - 2  # what is drawn begins there or deeper inside
    for begin, end in zip(polygon, np.roll(polygon, -1, axis=0)):
        length = float(np.hypot(*(end - begin)))
        if length < 4 * NEAR_PX:
            continue
        direction = (end - begin) / length
        normal = np.array([-direction[1], direction[0]])
        middle = begin + np.linspace(0.05, 0.95, int(length / 3) + 3)[:, None] * (end - begin)
        one, other = (_at(area > 0, middle + step * normal) for step in (3, -3))
        middle, outward = middle[one != other], np.where(one, -1, 1)[one != other]
        points = middle[:, None] + across[:, None] * (outward[:, None] * normal)[:, None]
        visible = _inside(changed, points[:, REACH_PX]) if len(points) else np.zeros(0, bool)
        if not visible.any():
            continue
        drawn = _at(changed, points[visible])
        ends = np.where(drawn[:, start:], 2 * REACH_PX, np.arange(2 * REACH_PX + 1 - start)).min(axis=1)
        # It is nan where nothing is drawn inside, or where no end is in reach.
        ends = np.where((ends == 0) | (ends == 2 * REACH_PX), np.nan, ends + start - REACH_PX - 0.5)
        rims.append(float(np.nanmedian(ends)) if np.isnan(ends).mean() < 0.5 else np.nan)
    return rims


def area_mask(shape: tuple[int, ...], polygon: Numbers, convex: bool = False) -> Image:
    """(h, w) uint8: a polygon, filled with white on black."""
    mask: Image = np.zeros(shape[:2], np.uint8)
    points = np.round(np.clip(polygon, -1e4, 1e4)).astype(np.int32)
    if convex:
        cv2.fillConvexPoly(mask, points, (255,))
    else:
        cv2.fillPoly(mask, [points], (255,))
    return mask
