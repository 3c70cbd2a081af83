"""Painting on frames.

Every function takes a frame, (h, w, 3) BGR uint8, leaves it as it is, and
returns a new one of the same shape. Positions are in pixels and stay
fractions of a pixel until they are drawn; the middle of the top left pixel
is (0, 0). Colors are (blue, green, red).
"""
from __future__ import annotations

import ctypes
from typing import Iterable, Sequence

import cv2
import numpy as np

from .area import Area
from .arrays import Color, Floats, Image, Integers, Numbers
from .compiled import library
from .fitting import fit_picture
from .lens import Lens
from .motion import transform
from .poses import TagPose
from .tags import Tag

_C = library('painting')
_C.draw_mask.restype = _C.warp.restype = None
_C.draw_mask.argtypes = [ctypes.c_void_p, *[ctypes.c_int] * 2, ctypes.c_void_p]
_C.warp.argtypes = [*[ctypes.c_void_p] * 2, *[ctypes.c_int] * 2, ctypes.c_void_p, ctypes.c_int64,
                    *[ctypes.c_int] * 3, ctypes.c_void_p]

GREEN = (0, 255, 0)
RED = (0, 0, 255)
BLUE = (255, 0, 0)
YELLOW = (0, 255, 255)
BLACK = (0, 0, 0)
WHITE = (255, 255, 255)
PURPLE = (255, 0, 150)  # the course's

# OpenCV draws fractions of a pixel as whole numbers of 1 / 2**SHIFT px.
SHIFT = 4

AXIS, ABOVE_PX = 0.75, 22  # how long axes are, in sides of a tag; and how far above it its id is
MAX_DRAWN_PX = 1e5


def fixed_point(points: Numbers) -> Integers:
    """Points, (..., 2) pixels, as OpenCV wants them between pixels: whole numbers of 1 / 2**SHIFT px, int32."""
    return np.round(np.asarray(points, np.float64) * (1 << SHIFT)).astype(np.int32)


def mark_tags(frame: Image, tags: Iterable[Tag]) -> Image:
    """Outline every tag, mark its first corner (its own top left), and write its id."""
    image = _outlined(frame, tags)
    for tag in tags:  # after all outlines, so that no line crosses a number
        write_text(image, str(tag.id), tag.center)
    return image


def mark_poses(frame: Image, tags: Sequence[Tag], poses: Iterable[TagPose], lens: Lens | None,
               area: Area | None = None) -> Image:
    """Outline every tag, and draw the axes of every TagPose, x red, y green, z blue; the id stands above.

    ``lens``: the Lens of the frame, which may be None if there are no poses.
    ``area``: the Area, if there is one, is outlined too.
    """
    image = _outlined(frame, tags)
    if area is not None:
        cv2.polylines(image, [fixed_point(area.corners)], True, PURPLE, 2, cv2.LINE_AA, SHIFT)
    for pose in poses:
        if lens is not None:
            _draw_axes(image, pose, lens)
    for tag in tags:
        write_text(image, str(tag.id), (tag.center[0], tag.corners[:, 1].min() - ABOVE_PX))
    return image


def _draw_axes(image: Image, pose: TagPose, lens: Lens) -> None:
    ends = np.vstack([np.zeros(3), np.eye(3) * pose.size * AXIS]) @ pose.rotation.T + pose.translation
    pixels = lens.project(ends)
    if np.all(np.abs(pixels) < MAX_DRAWN_PX):  # not NaN either: what is behind the camera
        origin, *tips = (tuple(map(int, point)) for point in fixed_point(pixels))
        for tip, color in zip(tips, (RED, GREEN, BLUE)):
            cv2.line(image, origin, tip, color, 2, cv2.LINE_AA, SHIFT)


def _outlined(frame: Image, tags: Iterable[Tag]) -> Image:
    image = frame.copy()
    for tag in tags:
        cv2.polylines(image, [fixed_point(tag.corners)], True, GREEN, 2, cv2.LINE_AA, SHIFT)
        cv2.circle(image, tuple(map(int, fixed_point(tag.corners[0]))), 4 << SHIFT, RED, -1,
                   cv2.LINE_AA, SHIFT)
    return image


def write_text(image: Image, text: str, center: Sequence[float] | Floats) -> None:
    """Write text around a center, dark-rimmed to be readable on black and on white."""
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, 0.7
    (width, height), _ = cv2.getTextSize(text, font, scale, 2)
    left = int(np.clip(center[0] - width / 2, 2, max(2, image.shape[1] - width - 2)))
    foot = int(np.clip(center[1] + height / 2, height + 2, max(height + 2, image.shape[0] - 3)))
    cv2.putText(image, text, (left, foot), font, scale, BLACK, 5, cv2.LINE_AA)
    cv2.putText(image, text, (left, foot), font, scale, YELLOW, 2, cv2.LINE_AA)


def mark_centers(frame: Image, centers: Iterable[Floats]) -> Image:
    """Put a dot on every center, (n, 2)."""
    image = frame.copy()
    for center in centers:
        point = tuple(map(int, fixed_point(center)))
        cv2.circle(image, point, 5 << SHIFT, BLACK, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(image, point, 4 << SHIFT, YELLOW, -1, cv2.LINE_AA, SHIFT)
    return image


def fill_polygon(frame: Image, points: Sequence[Floats] | Floats, color: Color = PURPLE) -> Image:
    """Fill the polygon through points, (n, 2), in the order in which they are given.

    Fewer than three points make no polygon and change nothing.
    """
    image = frame.copy()
    if len(points) >= 3:
        cv2.fillPoly(image, [fixed_point(points)], color, cv2.LINE_AA, SHIFT)
    return image


def area_mask(frame: Image, area: Area | None) -> Image:
    """White where the area is, black elsewhere; all black if ``area`` is None.

    On the area's rim it is as gray as the part of the pixel that the area covers.
    """
    mask = np.zeros_like(frame, order='C')
    if area is not None:
        corners = np.array(area.corners, np.float64)
        _C.draw_mask(mask.ctypes.data, mask.shape[1], mask.shape[0], corners.ctypes.data)
    return mask


def subtract(frame: Image, mask: Image) -> Image:
    """The frame without what is white in the mask: black there, untouched where the mask is black."""
    return cv2.subtract(frame, mask)


def overlay(frame: Image, picture: Image | None, area: Area | None, out: Image | None = None,
            fit: str = 'stretch', opacity: float = 1.0) -> Image:
    """The frame with a picture painted into the area; the frame itself if one of the two is None.

    ``picture``: (h, w, 3) BGR, or (h, w, 4) BGRA, whose alpha lets the frame
    shine through. The rim is smooth: its pixels are part frame, part picture.
    ``out``: where the result goes, in place of a new array; give the frame
    itself to paint right into it, which saves copying it. ``fit``: stretch,
    contain or cover (see fit_picture). ``opacity``: how much of the picture is
    in the mixture with the frame, 0 to 1.
    """
    if out is None:
        out = frame.copy()
    elif out is not frame:
        np.copyto(out, frame)
    if area is None or picture is None:
        return out
    picture, area = fit_picture(picture, area, fit)
    window, area = area.window(out)
    mask = area_mask(window, area)
    warped = warp(picture, area.homography(picture.shape[1], picture.shape[0]), mask)
    put_in(window, warped, mask, opacity)
    return out


def warp(picture: Image, homography: Numbers, mask: Image) -> Image:
    """A picture seen through a homography where a mask is not black; black, and transparent, elsewhere.

    This is cv2.warpPerspective with two differences. It skips the pixels that nobody will see. And a picture
    that is too large is halved first. Otherwise pixels would be left out, and fine lines would flicker.

    ``picture``: (h, w, 3) BGR or (h, w, 4) BGRA, uint8. ``homography``: (3, 3), from pixels of the picture to
    pixels of the mask. ``mask``: (h, w, 3) uint8. The result has the mask's size and the picture's channels.
    """
    homography = np.asarray(homography, np.float64)
    _, to_picture = cv2.invert(homography)  # all 0 where there is none
    for _ in range(_halvings(picture, homography)):
        picture = picture[:picture.shape[0] // 2 * 2, :picture.shape[1] // 2 * 2]
        picture = cv2.resize(picture, None, None, 0.5, 0.5, cv2.INTER_AREA)
        # The middle of a pixel, which was two wide, is between them.
        to_picture = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25], [0, 0, 1]]) @ to_picture
    picture, mask = np.ascontiguousarray(picture), np.ascontiguousarray(mask)
    height, width, channels = picture.shape
    warped = np.zeros((*mask.shape[:2], channels), np.uint8)
    _C.warp(warped.ctypes.data, mask.ctypes.data, mask.shape[1], mask.shape[0], picture.ctypes.data,
            picture.strides[0], width, height, channels, to_picture.ctypes.data)
    return warped


def _halvings(picture: Image, homography: Floats) -> int:
    """How often a picture without alpha can be halved and is still as large as it is seen."""
    if picture.shape[2] == 4:
        return 0  # the mean of colors is wrong where some of them are not to be seen
    height, width = picture.shape[:2]
    seen = transform(homography, np.array([[0.0, 0], [width, 0], [width, height], [0, height]]))
    top, right, foot, left = np.linalg.norm(seen - seen[[1, 2, 3, 0]], axis=1)
    return int(np.log2(max(1, min(width / max(top, foot, 1), height / max(left, right, 1)))))


def put_in(frame: Image, picture: Image, mask: Image, opacity: float = 1.0) -> None:
    """Paint a picture, (h, w, 3), or (h, w, 4) with alpha, into a frame of its size, where the mask is white.

    ``opacity``: see overlay.
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


def blend(frame: Image, picture: Image, cover: Image) -> Image:
    """The picture where ``cover`` is white, the frame where it is black, their mixture between.

    All three are (h, w, 3) uint8, and so is the result.
    """
    return cv2.add(cv2.multiply(frame, cv2.bitwise_not(cover), scale=1 / 255),
                   cv2.multiply(picture, cover, scale=1 / 255))
