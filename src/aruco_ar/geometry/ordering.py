"""Putting centers in order, and choosing four of many."""
from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Integers, Numbers
from aruco_ar.base.errors import InputError

# A corner this close to the line through its two neighbors makes no corner
# that a picture could hang from: centers on one line, give or take noise.
MIN_HEIGHT_PX = 2.0

# Of so many points every four are tried, where those on the hull alone do not do.
MAX_TRIED = 12

# Which way the corners lie: top left, top right, bottom right, bottom left.
DIRECTIONS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])

ZIGZAG = [0, 1, 3, 2]


def order_coordinates(points: Numbers, zigzag: bool = False) -> Floats:
    """The four points as top left, top right, bottom right, bottom left.

    With ``zigzag``: top left, top right, bottom left, bottom right.
    ``points``: (4, 2) in any order, x to the right and y down; the result has
    their dtype and is the same whatever order they come in.

    The course's rule comes first: x + y is least at the top left and greatest
    at the bottom right, y - x is least at the top right and greatest at the
    bottom left. Where a square is turned by about 45 degrees that rule takes
    one point twice; then the points go clockwise around their middle,
    beginning so that they lie as far as possible in their four directions.

    Raises InputError if the points are not four finite pairs of numbers.
    """
    points = np.asarray(points)
    if points.shape != (4, 2) or not np.all(np.isfinite(points)):
        raise InputError('order_coordinates takes four points, an array of shape (4, 2) of '
                         'finite numbers, not %s.' % np.array2string(points, threshold=8))
    points = points[np.lexsort(points.T)]  # whatever order they came in
    x, y = points.astype(np.float64).T  # small integers would overflow
    total, difference = x + y, y - x
    order = [np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]
    if len(set(order)) < 4:
        order = _clockwise(points)
    return points[order][ZIGZAG] if zigzag else points[order]


def _clockwise(points: Floats) -> Integers:
    """Indices of (4, 2) points, clockwise as seen, the top left one first."""
    arms = points - points.mean(axis=0)
    around = np.argsort(np.arctan2(arms[:, 1], arms[:, 0]), kind='stable')
    turns = [np.roll(around, -first) for first in range(4)]
    fits = [np.sum(arms[turn] * DIRECTIONS) for turn in turns]
    best = max(fits)
    tied = [turn for turn, fit in zip(turns, fits) if np.isclose(fit, best)]
    return min(tied, key=lambda turn: tuple(points[turn[0]][::-1]))


def is_quadrilateral(corners: Numbers) -> Booleans:
    """Whether corners, (..., 4, 2) and in order, make a convex figure that is not flat.

    Every corner must stand out of the line through its two neighbors by
    MIN_HEIGHT_PX, all to the same side. The result is (...) bool.
    """
    corners = np.asarray(corners, np.float64)
    before = corners[..., [3, 0, 1, 2], :]
    base = corners[..., [1, 2, 3, 0], :] - before
    height = _cross(base, corners - before) / np.maximum(np.sqrt((base * base).sum(axis=-1)), 1e-9)
    return np.asarray((height.min(axis=-1) > MIN_HEIGHT_PX) | (height.max(axis=-1) < -MIN_HEIGHT_PX))


def _cross(one: Floats, other: Floats) -> Floats:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def largest_quadrilateral(points: Numbers) -> Floats | None:
    """The four of n points that enclose the largest area, or None.

    ``points``: (n, 2). The result is (4, 2) float32, going around. None if no
    four of them make a proper quadrilateral: fewer than four points, points
    on one line, a triangle.
    """
    points = np.asarray(points, np.float32).reshape(-1, 2)
    if len(points) < 4:
        return None
    best = _largest_on_hull(np.array(cv2.convexHull(points), np.float32).reshape(-1, 2))
    if best is None and len(points) <= MAX_TRIED:
        best = _largest_of_all(points)
    return best


def _largest_on_hull(hull: Floats) -> Floats | None:
    """The largest quadrilateral lies on the convex hull, if that has four proper corners."""
    best, best_area = None, 0.0
    for first, third in combinations(range(len(hull)), 2):
        height = _cross(hull[third] - hull[first], hull - hull[first])
        second, fourth = np.argmax(height), np.argmin(height)
        area = height[second] - height[fourth]
        if height[second] > 0 > height[fourth] and area > best_area:
            best, best_area = hull[sorted((first, second, third, fourth))], area
    return best if best is not None and is_quadrilateral(best) else None


def _largest_of_all(points: Floats) -> Floats | None:
    """The largest of all proper quadrilaterals, which may have corners within the hull."""
    fours = points[list(combinations(range(len(points)), 4))]
    figures = fours[:, [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 1, 3]]].reshape(-1, 4, 2)
    figures = figures[is_quadrilateral(figures)]
    if len(figures) == 0:
        return None
    areas = np.abs(_cross(figures[:, 2] - figures[:, 0], figures[:, 3] - figures[:, 1]))
    return figures[np.argmax(areas)]
