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
from .poses import TagPose
from .tags import Tag

_C = library('painting')
_C.paint.restype = None
_C.paint.argtypes = [ctypes.c_void_p, ctypes.c_int64, *[ctypes.c_int] * 2, ctypes.c_void_p, ctypes.c_int64,
                     *[ctypes.c_int] * 3, *[ctypes.c_void_p] * 2, ctypes.c_float]

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

MIN_AREA_PX = 0.1  # of less, nobody sees anything


def _fixed(points: Numbers) -> Integers:
    return np.round(np.asarray(points, np.float64) * (1 << SHIFT)).astype(np.int32)


def mark_tags(frame: Image, tags: Iterable[Tag]) -> Image:
    """Outline every tag, mark its first corner (its own top left), and write its id."""
    image = _outlined(frame, tags)
    for tag in tags:  # after all outlines, so that no line crosses a number
        _write(image, str(tag.id), tag.center)
    return image


def mark_poses(frame: Image, tags: Sequence[Tag], poses: Iterable[TagPose], lens: Lens | None,
               area: Area | None = None) -> Image:
    """Outline every tag, and draw the axes of every TagPose, x red, y green, z blue; the id stands above.

    ``lens``: the Lens of the frame, which may be None if there are no poses.
    ``area``: the Area, if there is one, is outlined too.
    """
    image = _outlined(frame, tags)
    if area is not None:
        cv2.polylines(image, [_fixed(area.corners)], True, PURPLE, 2, cv2.LINE_AA, SHIFT)
    for pose in poses:
        if lens is not None:
            _draw_axes(image, pose, lens)
    for tag in tags:
        _write(image, str(tag.id), (tag.center[0], tag.corners[:, 1].min() - ABOVE_PX))
    return image


def _draw_axes(image: Image, pose: TagPose, lens: Lens) -> None:
    ends = np.vstack([np.zeros(3), np.eye(3) * pose.size * AXIS]) @ pose.rotation.T + pose.translation
    pixels = lens.project(ends)
    if np.all(np.abs(pixels) < MAX_DRAWN_PX):  # not NaN either: what is behind the camera
        origin, *tips = (tuple(map(int, point)) for point in _fixed(pixels))
        for tip, color in zip(tips, (RED, GREEN, BLUE)):
            cv2.line(image, origin, tip, color, 2, cv2.LINE_AA, SHIFT)


def _outlined(frame: Image, tags: Iterable[Tag]) -> Image:
    image = frame.copy()
    for tag in tags:
        cv2.polylines(image, [_fixed(tag.corners)], True, GREEN, 2, cv2.LINE_AA, SHIFT)
        cv2.circle(image, tuple(map(int, _fixed(tag.corners[0]))), 4 << SHIFT, RED, -1,
                   cv2.LINE_AA, SHIFT)
    return image


def _write(image: Image, text: str, center: Sequence[float] | Floats) -> None:
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
        point = tuple(map(int, _fixed(center)))
        cv2.circle(image, point, 5 << SHIFT, BLACK, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(image, point, 4 << SHIFT, YELLOW, -1, cv2.LINE_AA, SHIFT)
    return image


def fill_polygon(frame: Image, points: Sequence[Floats] | Floats, color: Color = PURPLE) -> Image:
    """Fill the polygon through points, (n, 2), in the order in which they are given.

    Fewer than three points make no polygon and change nothing.
    """
    image = frame.copy()
    if len(points) >= 3:
        cv2.fillPoly(image, [_fixed(points)], color, cv2.LINE_AA, SHIFT)
    return image


def area_mask(frame: Image, area: Area | None) -> Image:
    """White where the area is, black elsewhere; all black if ``area`` is None.

    On the area's rim it is as gray as the part of the pixel that the area covers.
    """
    return overlay(np.zeros_like(frame), np.full((1, 1, 3), 255, np.uint8), area)


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
    if cv2.contourArea(np.asarray(area.corners, np.float32)) < MIN_AREA_PX:
        return out
    _paint(out, picture, area, opacity)
    return out


def _paint(frame: Image, picture: Image, area: Area, opacity: float) -> None:
    """Paint a picture right into the area of a frame. How is in painting.c."""
    if not frame.flags.writeable:
        raise ValueError('The frame to paint into is read-only; give a copy of it.')
    whole = frame if frame.strides[1:] == (3, 1) else np.ascontiguousarray(frame)
    _, to_picture = cv2.invert(area.homography(picture.shape[1], picture.shape[0]))  # all 0 where there is none
    halvings = _halvings(picture, area)
    if halvings:  # else pixels would be skipped, which flickers, and to skip in memory is slow
        times = 2**halvings
        picture = picture[:picture.shape[0] // times * times, :picture.shape[1] // times * times]
        for _ in range(halvings):  # for which OpenCV is made best
            picture = cv2.resize(picture, None, None, 0.5, 0.5, cv2.INTER_AREA)
        middle = 0.5 / times - 0.5  # of the first pixel of the larger one
        to_picture = np.array([[1 / times, 0, middle], [0, 1 / times, middle], [0, 0, 1]]) @ to_picture
    picture, corners = np.ascontiguousarray(picture), np.array(area.corners, np.float64)
    height, width, channels = picture.shape
    _C.paint(whole.ctypes.data, whole.strides[0], whole.shape[1], whole.shape[0], picture.ctypes.data,
             picture.strides[0], width, height, channels, to_picture.ctypes.data, corners.ctypes.data, opacity)
    if whole is not frame:
        frame[:] = whole


def _halvings(picture: Image, area: Area) -> int:
    """How often a picture without alpha can be halved and is still as large as the area."""
    if picture.shape[2] == 4:
        return 0  # the mean of colors is wrong where some of them are not to be seen
    top, right, foot, left = np.linalg.norm(area.corners - np.roll(area.corners, -1, axis=0), axis=1)
    height, width = picture.shape[:2]
    return int(np.log2(max(1, min(width / max(top, foot, 1), height / max(left, right, 1)))))


def blend(frame: Image, picture: Image, cover: Image) -> Image:
    """The picture where ``cover`` is white, the frame where it is black, their mixture between.

    All three are (h, w, 3) uint8, and so is the result.
    """
    return cv2.add(cv2.multiply(frame, cv2.bitwise_not(cover), scale=1 / 255),
                   cv2.multiply(picture, cover, scale=1 / 255))
