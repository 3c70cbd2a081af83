"""The order of four centers, and the choice of four centers among many."""
from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Integers, Numbers
from aruco_ar.base.errors import InputError
from aruco_ar.compiled import binding

from .lines import cross

# A corner must be farther than this from the line through its two neighbors.
# Otherwise three centers are on one line, apart from noise.
MIN_HEIGHT_PX = 2.0

# If the convex hull has no proper quadrilateral, all groups of four are tried, of at most this many points.
MAX_TRIED = 12

# The directions from the middle to the corners: top left, top right, bottom right, bottom left.
DIRECTIONS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def order_coordinates(points: Numbers) -> Floats:
    """The four points as top left, top right, bottom right, bottom left.

    ``points``: (4, 2) in any order, x to the right and y down. The result has
    their dtype, and does not depend on their order.

    The course's rule is tried first. x + y is least at the top left and
    greatest at the bottom right. y - x is least at the top right and greatest
    at the bottom left. If a square is turned by about 45 degrees, that rule
    can choose one point twice. Then the points are taken clockwise around
    their middle, starting with the one that fits the four directions best.

    Raises InputError if the points are not four finite pairs of numbers.
    """
    points = np.asarray(points)
    if points.shape != (4, 2) or not np.all(np.isfinite(points)):
        raise InputError('order_coordinates takes four points, an array of shape (4, 2) of '
                         'finite numbers, not %s.' % np.array2string(points, threshold=8))
    points = points[np.lexsort(points.T)]  # so the result does not depend on the given order
    x, y = points.astype(np.float64).T  # float64, since small integer types would overflow
    total, difference = x + y, y - x
    order = [np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]
    if len(set(order)) < 4:
        order = _clockwise(points)
    return points[order]


def _clockwise(points: Floats) -> Integers:
    """Indices of (4, 2) points, clockwise in the frame, the top left one first."""
    arms = points - points.mean(axis=0)
    circle = np.argsort(np.arctan2(arms[:, 1], arms[:, 0]), kind='stable')
    orders = [np.roll(circle, -first) for first in range(4)]
    scores = [np.sum(arms[order] * DIRECTIONS) for order in orders]
    best = max(scores)
    tied = [order for order, score in zip(orders, scores) if np.isclose(score, best)]
    return min(tied, key=lambda order: tuple(points[order[0]][::-1]))


def is_quadrilateral(corners: Numbers) -> Booleans:
    """(...) bool: whether corners, (..., 4, 2) in order, make a proper convex quadrilateral.

    Every corner must be at least MIN_HEIGHT_PX away from the line through its
    two neighbors, all of them on the same side.
    """
    return binding.find_convex(corners, MIN_HEIGHT_PX)


def largest_quadrilateral(points: Numbers) -> Floats | None:
    """The four of n points that enclose the largest area, or None.

    ``points``: (n, 2). The result is (4, 2) float32, in order along the rim.
    It is None if no four of the points make a proper quadrilateral: if there
    are fewer than four, or if they are on one line or make a triangle.
    """
    points = np.asarray(points, np.float32).reshape(-1, 2)
    if len(points) < 4:
        return None
    best = _largest_on_hull(np.array(cv2.convexHull(points), np.float32).reshape(-1, 2))
    if best is None and len(points) <= MAX_TRIED:
        best = _largest_of_all(points)
    return best


def _largest_on_hull(hull: Floats) -> Floats | None:
    """The largest quadrilateral with corners on the convex hull, (n, 2), or None if it is not a proper one."""
    best, best_area = None, 0.0
    for first, third in combinations(range(len(hull)), 2):
        height = cross(hull[third] - hull[first], hull - hull[first])
        second, fourth = np.argmax(height), np.argmin(height)
        area = height[second] - height[fourth]
        if height[second] > 0 > height[fourth] and area > best_area:
            best, best_area = hull[sorted((first, second, third, fourth))], area
    return best if best is not None and is_quadrilateral(best) else None


def _largest_of_all(points: Floats) -> Floats | None:
    """The largest of all proper quadrilaterals, whose corners may lie within the hull, or None."""
    fours = points[list(combinations(range(len(points)), 4))]
    figures = fours[:, [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 1, 3]]].reshape(-1, 4, 2)
    figures = figures[is_quadrilateral(figures)]
    if len(figures) == 0:
        return None
    areas = np.abs(cross(figures[:, 2] - figures[:, 0], figures[:, 3] - figures[:, 1]))
    return figures[np.argmax(areas)]
