"""Where a picture goes in an image."""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.tracking.area import Area

from .fit import fit_picture
from .picture import Picture


@dataclass(frozen=True, eq=False)
class Place:
    """Where a picture goes in an image.

    ``window``: (h, w, 3), the part of the image that the area touches. It is a
    view: what is painted into it is in the image. ``area``: the whole Area, in
    pixels of the window. ``picture_corners``: (4, 2) float32, the corners of
    the part of the picture that is painted, in its pixels. ``corners``: (4, 2)
    float32, where they go, in undistorted pixels (see Area.window).
    """

    window: Image
    area: Area
    picture_corners: Floats
    corners: Floats

    @property
    def positions(self) -> Image | None:
        """(h, w, 2) float32: the undistorted position of each pixel of the window, or None without a lens."""
        return self.area.positions if self.window.size else None

    @cached_property
    def mask(self) -> Image:
        """(h, w, 3) uint8: white where the picture goes, black elsewhere, gray on the rim."""
        return binding.draw_mask(self.window, self.corners, self.positions)

    @property
    def homography(self) -> Floats:
        """(3, 3) float64: from pixels of the picture to undistorted pixels."""
        return np.asarray(cv2.getPerspectiveTransform(self.picture_corners, self.corners), np.float64)


def find_place(image: Image, area: Area, picture: Image | Picture, fit: str = 'stretch') -> Place:
    """The Place of a picture, (h, w, 3 or 4), in the area of an image, (h, w, 3). ``fit``: see fit_picture.

    Raises InputError for any other fit, and if the image is not of the size of the area's lens.
    """
    window, whole = area.window(image)
    picture_corners, part = fit_picture(picture, whole, fit)
    return Place(window, whole, picture_corners, np.asarray(part.undistorted, np.float32))
