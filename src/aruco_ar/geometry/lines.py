"""Straight lines in the plane."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Floats


def cross(one: Floats, other: Floats) -> Floats:
    """(...): the cross products of vectors, (..., 2), which are 0 where the two are parallel."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def crossing(point: Floats, direction: Floats, other_point: Floats, other_direction: Floats) -> Floats:
    """(..., 2): where a line crosses another one, each given by a point and a direction, (..., 2).

    The crossing of two parallel lines is far away; it is meaningless, but finite.
    """
    divisor = cross(direction, other_direction)
    distance = cross(other_point - point, other_direction) / np.where(divisor == 0, 1e-9, divisor)
    return point + distance[..., None] * direction
