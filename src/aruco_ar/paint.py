"""Painting on frames.

Every function takes a frame, (h, w, 3) BGR uint8, leaves it as it is, and
returns a new one of the same shape. Positions are in pixels and stay
fractions of a pixel until they are drawn; the middle of the top left pixel
is (0, 0). Colors are (blue, green, red).
"""
from __future__ import annotations

from typing import Iterable, Sequence

import cv2
import numpy as np

from .area import Area
from .arrays import Color, Floats, Image, Integers, Numbers
from .fitting import fit_picture
from .lens import Lens
from .poses import TagPose
from .tags import Tag

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
    mask = np.zeros_like(frame)
    if area is not None:
        cv2.fillConvexPoly(mask, _fixed(area.corners), WHITE, cv2.LINE_8, SHIFT)
        rim, cover = _rim(area.corners, frame.shape)
        mask.reshape(-1, 3)[rim] = (cover * 255 + 0.5).astype(np.uint8)[:, None]
    return mask


def _rim(corners: Floats, shape: Sequence[int]) -> tuple[Integers, Floats]:
    """The pixels that an area's sides cross, and how much of each the area covers.

    (n,) int64 indices into all pixels of a frame of that shape, row by row,
    some of them repeated, and (n,) float32, 0 to 1: half a pixel in, on, or
    half a pixel out of the nearest side is all, half, or nothing.
    """
    height, width = shape[:2]
    x0, y0 = np.asarray(corners, np.float64).T
    x1, y1 = x0[[1, 2, 3, 0]], y0[[1, 2, 3, 0]]
    x, y = [], []
    for side in range(4):
        flat = abs(x1[side] - x0[side]) > abs(y1[side] - y0[side])
        a0, b0, a1, b1, end = (x0[side], y0[side], x1[side], y1[side], width) if flat else \
            (y0[side], x0[side], y1[side], x1[side], height)
        along = np.arange(max(int(min(a0, a1)) - 1, 0), min(int(max(a0, a1)) + 3, end))
        # At 45 degrees at most, only these two are less than half a pixel from the side.
        across = np.floor(b0 + (along - a0) * ((b1 - b0) / (a1 - a0 or 1))).astype(np.int64)
        across = np.concatenate([across, across + 1])
        along = np.concatenate([along, along])
        x.append(along if flat else across)
        y.append(across if flat else along)
    x, y = np.concatenate(x), np.concatenate(y)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    x, y = x[inside], y[inside]
    inward = 1 if (x0 * y1 - x1 * y0).sum() >= 0 else -1
    length = np.maximum(np.hypot(x1 - x0, y1 - y0), 1e-9) * inward
    right, down = (y0 - y1) / length, (x1 - x0) / length
    cover = (np.outer(right, x) + np.outer(down, y) + (0.5 - right * x0 - down * y0)[:, None]).min(axis=0)
    return y * width + x, np.clip(cover, 0, 1).astype(np.float32)


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
    low = np.maximum(np.floor(area.corners.min(axis=0)) - 1, 0).astype(int)
    high = np.minimum(np.ceil(area.corners.max(axis=0)) + 2, frame.shape[1::-1]).astype(int)
    if np.any(low >= high):
        return out
    part = out[low[1]:high[1], low[0]:high[0]]
    shift = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1.0]])
    painted = _warp(part, picture, shift @ area.homography(picture.shape[1], picture.shape[0]))
    if opacity < 1:
        painted = cv2.addWeighted(painted, opacity, part, 1 - opacity, 0)
    rim, cover = _rim(area.corners - low, part.shape)
    inside = np.zeros(part.shape[:2], np.uint8)
    cv2.fillConvexPoly(inside, _fixed(area.corners - low), (255,), cv2.LINE_8, SHIFT)
    rows, columns = np.divmod(rim, part.shape[1])
    around = np.asarray(part[rows, columns], np.float32)
    mixed = around + cover[:, None] * (painted.reshape(-1, 3)[rim] - around)
    cv2.copyTo(painted, inside, part)
    part[rows, columns] = mixed + 0.5
    return out


def _warp(frame: Image, picture: Image, homography: Floats) -> Image:
    """The picture on the frame, everywhere: beyond its own edges as at its edges."""
    def warped(part: Image) -> Image:
        return cv2.warpPerspective(part, homography, frame.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)
    if picture.shape[2] == 3:
        return warped(picture)
    # Colors go weighted with their alpha, or those that nobody sees would bleed in at its rim.
    alpha = cv2.cvtColor(picture[:, :, 3], cv2.COLOR_GRAY2BGR)
    weighted = cv2.multiply(picture[:, :, :3], alpha, scale=1 / 255)
    clear = cv2.bitwise_not(warped(alpha))
    return cv2.add(cv2.multiply(frame, clear, scale=1 / 255), warped(weighted))


def blend(frame: Image, picture: Image, cover: Image) -> Image:
    """The picture where ``cover`` is white, the frame where it is black, their mixture between.

    All three are (h, w, 3) uint8, and so is the result.
    """
    return cv2.add(cv2.multiply(frame, cv2.bitwise_not(cover), scale=1 / 255),
                   cv2.multiply(picture, cover, scale=1 / 255))
