"""Painting a picture into the area of a frame.

Frames are (h, w, 3) BGR uint8. The functions return new images and leave the
frame unchanged, except put_in, and overlay with ``out``. Positions are in
pixels and need not be whole numbers. The middle of the top left pixel is (0, 0).
"""
from __future__ import annotations

from typing import Callable

import cv2
import numpy as np

from aruco_ar.base.arrays import Image, Numbers
from aruco_ar.base.checks import COLOR, PICTURE, check_array
from aruco_ar.compiled import binding
from aruco_ar.tracking.area import Area

from .picture import Picture
from .place import Place, find_place


def area_mask(frame: Image, area: Area | None) -> Image:
    """The mask of an area, of the frame's shape: white in the area, black elsewhere, all black without an area.

    A pixel on the area's rim is gray, according to the part of it that the area covers. The frame may also be
    gray, (h, w). Raises InputError if it is no uint8 image, or is not of the size of the area's lens.
    """
    if area is None:
        return np.zeros(frame.shape, np.uint8)
    area.check_size(frame)
    return binding.draw_mask(frame, area.undistorted, area.positions)


def subtract(frame: Image, mask: Image) -> Image:
    """The frame with the area cut out: black where the mask is white, unchanged where the mask is black.

    Raises InputError if they are not two images, uint8, of one shape: see area_mask.
    """
    check_array('mask', mask, np.uint8, frame.shape)
    check_array('frame', frame, np.uint8, frame.shape)
    return cv2.subtract(frame, mask)


def overlay(frame: Image, picture: Image | None, area: Area | None, out: Image | None = None,
            fit: str = 'stretch', opacity: float = 1.0) -> Image:
    """The frame with a picture painted into the area; the frame alone if picture or area is None.

    ``picture``: (h, w, 3) BGR, or (h, w, 4) BGRA, whose alpha lets the frame
    shine through. The rim is smooth: its pixels are part frame, part picture.
    ``out``: an array for the result, instead of a new one. Give the frame
    itself to paint right into it, which saves a copy. ``fit``: stretch,
    contain or cover (see fit_picture). ``opacity``: the picture's share in the
    mixture with the frame, 0 to 1. Raises InputError for images of other
    types and shapes, and if the frame is not of the size of the area's lens.
    """
    check_array('frame', frame, np.uint8, *COLOR)
    if picture is not None:
        check_array('picture', picture, np.uint8, *PICTURE)
    if out is None:
        out = frame.copy()
    else:
        check_array('array for the result', out, np.uint8, frame.shape, writes=True)
        if out is not frame:
            np.copyto(out, frame)
    if area is not None and picture is not None:
        paint(find_place(out, area, picture, fit), picture, opacity)
    return out


def paint(place: Place, picture: Image | Picture, opacity: float = 1.0,
          finish: Callable[[Image], Image] = lambda warped: warped) -> None:
    """Paint a picture into its Place. This changes the image. Exercise 5.6 shows the same, step by step.

    ``picture``, ``opacity``: see overlay. ``finish`` gets the warped picture, and returns what is painted.
    """
    warped = finish(warp(picture, place.homography, place.mask, place.positions))
    put_in(place.window, warped, place.mask, opacity)


def warp(picture: Image | Picture, homography: Numbers, mask: Image, positions: Image | None = None) -> Image:
    """A picture, warped by a homography where the mask is not black; elsewhere black and transparent.

    This is cv2.warpPerspective with three differences. It skips the pixels where the mask is black. A picture
    that is larger than its place is filtered: each pixel is a mean of all that it covers. Otherwise fine lines
    would break and flicker. A lens distorts the picture as it distorts the frame.

    ``picture``: (h, w, 3) BGR or (h, w, 4) BGRA, uint8, or a Picture, which keeps what is computed from it.
    ``homography``: (3, 3), from pixels of the picture to undistorted pixels. ``mask``: (h, w, 3) or (h, w)
    uint8. ``positions``: (h, w, 2) float32, the undistorted position of each pixel of the mask, or None
    without a lens. The result has the mask's size and the channels of the picture. Raises InputError for
    arrays of other types and shapes.
    """
    if not isinstance(picture, Picture):
        picture = Picture(picture)
    check_array('picture', picture.pixels, np.uint8, *PICTURE)
    homography = np.asarray(homography, np.float64)
    check_array('homography', homography, np.float64, (3, 3))
    _, to_picture = cv2.invert(homography)  # all 0 if there is no inverse
    to_picture = np.asarray(to_picture, np.float64)
    return binding.warp_picture(picture.pixels, picture.level, to_picture, mask, positions)


def put_in(window: Image, warped: Image, mask: Image, opacity: float = 1.0) -> None:
    """Paint a warped picture into a window, where the mask is white. This changes the window.

    The arguments are those of ``visible``. Raises InputError as it does, and if the window is read-only.
    """
    check_array('frame', window, np.uint8, (*window.shape[:2], 3), writes=True)
    mask, warped = visible(window, warped, mask, opacity)
    cv2.subtract(window, mask, window)
    cv2.add(window, warped, window)


def visible(window: Image, warped: Image, mask: Image, opacity: float = 1.0) -> tuple[Image, Image]:
    """What to subtract from a window to paint a picture into it, and what to add then, (h, w, 3) each.

    ``window``: (h, w, 3) uint8. ``warped``: see warp; it may be overwritten. ``mask``: (h, w, 3) uint8, white
    where to paint. ``opacity``: see overlay.

    For an opaque picture, these are the mask, and the picture where it is at most as light as the mask, as in
    the course. So the rim's pixels are not an exact mixture. For any other picture they are: of the window's
    and of the picture's pixels, the shares that the picture covers. Raises InputError for images of other
    types and shapes.
    """
    size = window.shape[:2]
    check_array('frame', window, np.uint8, (*size, 3))
    check_array('picture', warped, np.uint8, (*size, 3), (*size, 4))
    check_array('mask', mask, np.uint8, (*size, 3))
    if not window.size:
        return mask, mask
    if warped.shape[2] == 3 and opacity == 1:
        return mask, cv2.min(warped, mask, warped)
    return binding.mix_picture(window, warped, mask, opacity)
