"""Fitting a picture of one shape into an area of another."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.tracking.area import Area

FITS = 'stretch', 'contain', 'cover'


def fit_picture(picture: Image, area: Area, fit: str) -> tuple[Image, Area]:
    """The part of a picture, (h, w, 3 or 4), to be painted, and the part of the Area to paint it into.

    ``fit``: with ``stretch``, the whole picture fills the whole area. With
    ``contain``, the whole picture is in the middle of the area and keeps its
    proportions. With ``cover``, the picture keeps its proportions and fills
    the area, and what does not fit is cut off. Raises InputError for any other.
    """
    if fit not in FITS:
        raise InputError('There is no fit "%s" for a picture; choose one of %s.' % (fit, ', '.join(FITS)))
    if fit == 'stretch':
        return picture, area
    height, width = picture.shape[:2]
    wider = width / height / (area.ratio or _ratio_in_frame(area))  # how many times as wide as the area
    if fit == 'cover':
        kept_width = max(1, round(width / max(wider, 1)))
        kept_height = max(1, round(height * min(wider, 1)))
        left, top = (width - kept_width) // 2, (height - kept_height) // 2
        return picture[top:top + kept_height, left:left + kept_width], area
    across, down = min(wider, 1) / 2, min(1 / wider, 1) / 2
    inner = np.array([[-across, -down], [across, -down], [across, down], [-across, down]]) + 0.5
    return picture, area.part(inner)


def _ratio_in_frame(area: Area) -> float:
    """An Area's width to height in the frame: an estimate, for when its proportions on the wall are unknown."""
    top, right, bottom, left = np.hypot(*(area.undistorted - np.roll(area.undistorted, -1, axis=0)).T)
    return (top + bottom) / max(left + right, 1e-9)
