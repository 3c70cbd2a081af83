"""Fitting a picture of one shape into an area of another."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.settings.settings import FITS
from aruco_ar.tracking.area import Area

from .picture import Picture


def fit_picture(picture: Image | Picture, area: Area, fit: str) -> tuple[Floats, Area]:
    """The part of a picture, (h, w, 3 or 4), to be painted, and the part of the Area to paint it into.

    The first is (4, 2) float32: the corners of a rectangle in the picture, clockwise from its top left, in
    pixels. The corners of the whole picture are (0, 0) and (w, h), as in the course.

    ``fit``: with ``stretch``, the whole picture fills the whole area. With
    ``contain``, the whole picture is in the middle of the area and keeps its
    proportions. With ``cover``, the picture keeps its proportions and fills
    the area, and what does not fit is cut off. Raises InputError for any other.
    """
    if fit not in FITS:
        raise InputError('There is no fit "%s" for a picture; choose one of %s.' % (fit, ', '.join(FITS)))
    height, width = picture.shape[:2]
    if fit == 'stretch':
        return _middle(width, height), area
    wider = width / height / (area.ratio or _ratio_in_frame(area))  # how many times as wide as the area
    if fit == 'cover':
        return _middle(width, height, 1 / max(wider, 1), min(wider, 1)), area
    return _middle(width, height), area.part(_middle(1, 1, min(wider, 1), min(1 / wider, 1)))


def _middle(width: int, height: int, across: float = 1, down: float = 1) -> Floats:
    """(4, 2) float32: the corners of the middle of a rectangle, ``across`` and ``down`` of its sides large."""
    left, top = (0.5 - 0.5 * across) * width, (0.5 - 0.5 * down) * height
    right, bottom = width - left, height - top
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]], np.float32)


def _ratio_in_frame(area: Area) -> float:
    """An Area's width to height in the frame: an estimate, for when its proportions on the wall are unknown."""
    top, right, bottom, left = np.hypot(*(area.undistorted - np.roll(area.undistorted, -1, axis=0)).T)
    return (top + bottom) / max(left + right, 1e-9)
