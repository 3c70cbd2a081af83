"""Painting a picture into the area of a frame.

Frames are (h, w, 3) BGR uint8. The functions return new images and leave the
frame unchanged, except put_in, and overlay with ``out``. Positions are in
pixels and need not be whole numbers. The middle of the top left pixel is (0, 0).
"""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image, Numbers
from aruco_ar.base.checks import COLOR, PICTURE, check_array
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import transform
from aruco_ar.tracking.area import Area

from .fit import fit_picture
from .levels import levels_of
from .pixels import blend

MAX_LEVELS = 12  # a picture is halved at most this many times


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
    if area is None or picture is None:
        return out
    window, part = area.window(out)
    corners, area = fit_picture(picture, part, fit)
    homography = cv2.getPerspectiveTransform(corners, np.asarray(area.undistorted, np.float32))
    mask = area_mask(window, area)
    warped = warp(picture, np.asarray(homography, np.float64), mask, area.positions)
    put_in(window, warped, mask, opacity)
    return out


def warp(picture: Image, homography: Numbers, mask: Image, positions: Image | None = None) -> Image:
    """A picture, warped by a homography where the mask is not black; elsewhere black and transparent.

    This is cv2.warpPerspective with three differences. It skips the pixels where the mask is black. A picture
    that is larger than its place is filtered: each pixel is a mean of all that it covers. Otherwise fine lines
    would break and flicker. A lens distorts the picture as it distorts the frame.

    ``picture``: (h, w, 3) BGR or (h, w, 4) BGRA, uint8. ``homography``: (3, 3), from pixels of the picture to
    undistorted pixels. ``mask``: (h, w, 3) or (h, w) uint8. ``positions``: (h, w, 2) float32, the undistorted
    position of each pixel of the mask, or None without a lens. The result has the mask's size and the channels
    of the picture. Raises InputError for arrays of other types and shapes.
    """
    check_array('picture', picture, np.uint8, *PICTURE)
    homography = np.asarray(homography, np.float64)
    check_array('homography', homography, np.float64, (3, 3))
    _, to_picture = cv2.invert(homography)  # all 0 if there is no inverse
    levels = levels_of(picture, _levels_needed(picture, homography))
    return binding.warp_picture(levels, np.asarray(to_picture, np.float64), mask, positions)


def _levels_needed(picture: Image, homography: Floats) -> int:
    """How many times a picture has to be halved until it is nowhere larger than in the frame."""
    height, width = picture.shape[:2]
    corners = np.array([[0.0, 0], [width, 0], [width, height], [0, height]])
    behind = corners @ homography[2, :2] + homography[2, 2] <= 0
    if behind.any() and not behind.all():
        return MAX_LEVELS  # some of what is cut off would be behind the camera
    seen = transform(homography, corners)
    top, right, foot, left = np.linalg.norm(seen - seen[[1, 2, 3, 0]], axis=1)
    shrinks = max(width / max(min(top, foot), 1), height / max(min(left, right), 1))
    return int(np.ceil(np.log2(min(max(1, shrinks), 2**MAX_LEVELS))))  # also if it is not a number


def put_in(frame: Image, picture: Image, mask: Image, opacity: float = 1.0) -> None:
    """Paint a picture into a frame of the same size, where the mask is white. This changes the frame.

    ``picture``: (h, w, 3), or (h, w, 4) with alpha. ``mask``: (h, w, 3). ``opacity``: see overlay. The picture
    may be overwritten. Raises InputError for images of other types and shapes, or a frame that is read-only.
    """
    size = frame.shape[:2]
    check_array('frame', frame, np.uint8, (*size, 3), writes=True)
    check_array('picture', picture, np.uint8, (*size, 3), (*size, 4))
    check_array('mask', mask, np.uint8, (*size, 3))
    if not frame.size:
        return
    if picture.shape[2] == 3 and opacity == 1:
        cv2.subtract(frame, mask, frame)
        cv2.add(frame, cv2.min(picture, mask, picture), frame)
        return
    if picture.shape[2] == 4:
        mask = cv2.multiply(mask, cv2.cvtColor(picture[:, :, 3], cv2.COLOR_GRAY2BGR), scale=1 / 255)
    frame[:] = blend(frame, picture[:, :, :3], cv2.convertScaleAbs(mask, alpha=opacity))
