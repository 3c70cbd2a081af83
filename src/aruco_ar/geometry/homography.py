"""Homographies: mappings between planes that keep straight lines straight."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Floats, Numbers

UNIT_SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def homography_to(corners: Numbers) -> Floats:
    """(3, 3) float64: the homography from the unit square to the quadrilateral with those corners, (4, 2).

    This is the closed form in P. Heckbert, Fundamentals of Texture Mapping and
    Image Warping, 1989, section 2.2.3.
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = np.asarray(corners, np.float64).tolist()
    one_x, one_y, other_x, other_y = x1 - x2, y1 - y2, x3 - x2, y3 - y2
    rest_x, rest_y = x0 - x1 + x2 - x3, y0 - y1 + y2 - y3
    area = one_x * other_y - one_y * other_x or 1e-9
    g = (rest_x * other_y - rest_y * other_x) / area
    h = (one_x * rest_y - one_y * rest_x) / area
    return np.array([[x1 - x0 + g * x1, x3 - x0 + h * x3, x0],
                     [y1 - y0 + g * y1, y3 - y0 + h * y3, y0], [g, h, 1]])


def homography_from(corners: Numbers) -> Floats:
    """(3, 3) float64: the homography from the quadrilateral with those corners, (4, 2), to the unit square."""
    return np.linalg.inv(homography_to(corners))


def transform(homography: Floats, points: Floats) -> Floats:
    """(..., 2): where a homography, (3, 3), maps points, (..., 2)."""
    mapped = points @ homography[:, :2].T + homography[:, 2]
    return mapped[..., :2] / mapped[..., 2:]
