"""Painting a picture into the area of a frame.

Frames are (h, w, 3) BGR uint8. The functions return new images and leave the
frame unchanged, except put_in, and overlay with ``out``. Positions are in
pixels and need not be whole numbers. The middle of the top left pixel is (0, 0).
"""
from __future__ import annotations

import ctypes

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image, Numbers
from aruco_ar.compiled import library
from aruco_ar.geometry.homography import transform
from aruco_ar.tracking.area import Area

from .fit import fit_picture
from .levels import levels_of
from .pixels import blend

_C = library('painting')
_C.draw_mask.restype = _C.warp.restype = None
_C.draw_mask.argtypes = [ctypes.c_void_p, *[ctypes.c_int] * 2, *[ctypes.c_void_p] * 2, ctypes.c_int64]
_C.warp.argtypes = [*[ctypes.c_void_p] * 2, *[ctypes.c_int] * 2, ctypes.c_void_p, ctypes.c_int,
                    *[ctypes.c_void_p] * 2, ctypes.c_int64]
MAX_LEVELS = 12  # a picture is halved at most this many times


class _Level(ctypes.Structure):
    """The C structure Frame of frame.h."""

    _fields_ = [('pixels', ctypes.c_void_p), ('row', ctypes.c_int64), ('width', ctypes.c_int),
                ('height', ctypes.c_int), ('channels', ctypes.c_int)]


def area_mask(frame: Image, area: Area | None) -> Image:
    """The mask of an area, of the frame's shape: white in the area, black elsewhere, all black without an area.

    A pixel on the area's rim is gray, according to the part of it that the area covers.
    """
    mask = np.zeros_like(frame, order='C')
    if area is not None:
        corners = np.array(area.undistorted, np.float64)
        _C.draw_mask(mask.ctypes.data, mask.shape[1], mask.shape[0], corners.ctypes.data,
                     *_address_and_row(area.positions))
    return mask


def subtract(frame: Image, mask: Image) -> Image:
    """The frame with the area cut out: black where the mask is white, unchanged where the mask is black."""
    return cv2.subtract(frame, mask)


def overlay(frame: Image, picture: Image | None, area: Area | None, out: Image | None = None,
            fit: str = 'stretch', opacity: float = 1.0) -> Image:
    """The frame with a picture painted into the area; the frame alone if picture or area is None.

    ``picture``: (h, w, 3) BGR, or (h, w, 4) BGRA, whose alpha lets the frame
    shine through. The rim is smooth: its pixels are part frame, part picture.
    ``out``: an array for the result, instead of a new one. Give the frame
    itself to paint right into it, which saves a copy. ``fit``: stretch,
    contain or cover (see fit_picture). ``opacity``: the picture's share in the
    mixture with the frame, 0 to 1.
    """
    if out is None:
        out = frame.copy()
    elif out is not frame:
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
    undistorted pixels. ``mask``: (h, w, 3) uint8. ``positions``: (h, w, 2) float32, the undistorted position
    of each pixel of the mask, or None without a lens. The result has the mask's size and the channels of the
    picture.
    """
    homography = np.asarray(homography, np.float64)
    _, to_picture = cv2.invert(homography)  # all 0 if there is no inverse
    mask = np.ascontiguousarray(mask)
    levels = [np.ascontiguousarray(level) for level in levels_of(picture, _levels_needed(picture, homography))]
    warped = np.zeros((*mask.shape[:2], picture.shape[2]), np.uint8)
    pyramid = (_Level * len(levels))(*[
        _Level(level.ctypes.data, level.strides[0], level.shape[1], level.shape[0], level.shape[2])
        for level in levels])
    _C.warp(warped.ctypes.data, mask.ctypes.data, mask.shape[1], mask.shape[0], pyramid, len(levels),
            to_picture.ctypes.data, *_address_and_row(positions))
    return warped


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


def _address_and_row(positions: Image | None) -> tuple[int | None, int]:
    """The address of positions, (h, w, 2) float32, and their bytes from one row to the next."""
    return (None, 0) if positions is None else (positions.ctypes.data, positions.strides[0])


def put_in(frame: Image, picture: Image, mask: Image, opacity: float = 1.0) -> None:
    """Paint a picture into a frame of the same size, where the mask is white. This changes the frame.

    ``picture``: (h, w, 3), or (h, w, 4) with alpha. ``mask``: (h, w, 3). ``opacity``: see overlay. The picture
    may be overwritten.
    """
    if not frame.size:
        return
    if picture.shape[2] == 3 and opacity == 1:
        cv2.subtract(frame, mask, frame)
        cv2.add(frame, cv2.min(picture, mask, picture), frame)
        return
    if picture.shape[2] == 4:
        mask = cv2.multiply(mask, cv2.cvtColor(picture[:, :, 3], cv2.COLOR_GRAY2BGR), scale=1 / 255)
    frame[:] = blend(frame, picture[:, :, :3], cv2.convertScaleAbs(mask, alpha=opacity))
