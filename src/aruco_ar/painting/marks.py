"""Marks on frames: outlines, axes, dots, texts and polygons.

Positions are in pixels and need not be whole numbers. The middle of the top left pixel is (0, 0). Colors are
(blue, green, red).
"""
from __future__ import annotations

from typing import Iterable, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Color, Floats, Image, Integers, Numbers
from aruco_ar.geometry.lens import Lens
from aruco_ar.poses.estimator import TagPose
from aruco_ar.tags.tag import Tag
from aruco_ar.tracking.area import Area

GREEN = (0, 255, 0)
RED = (0, 0, 255)
BLUE = (255, 0, 0)
YELLOW = (0, 255, 255)
BLACK = (0, 0, 0)
PURPLE = (255, 0, 150)  # the color that the course uses

# OpenCV's drawing functions take positions as integers, in units of 1 / 2**SHIFT px.
SHIFT = 4

AXIS_SIDES = 0.75    # the length of a drawn axis, in sides of the tag
ID_AWAY_PX = 22      # the middle of an id is this far from its tag
MAX_DRAWN_PX = 1e5   # OpenCV is not given positions beyond this


def fixed_point(points: Numbers) -> Integers:
    """Points, (..., 2) pixels, as fixed-point numbers for OpenCV: int32, in units of 1 / 2**SHIFT px."""
    return np.round(np.asarray(points, np.float64) * (1 << SHIFT)).astype(np.int32)


def mark_tags(frame: Image, tags: Iterable[Tag]) -> Image:
    """Outline every tag, mark its first corner (its own top left), and write its id."""
    image = _outlined(frame, tags)
    for tag in tags:  # after all outlines, so that no line crosses a number
        write_text(image, str(tag.id), tag.center)
    return image


def mark_poses(frame: Image, tags: Sequence[Tag], poses: Iterable[TagPose], lens: Lens | None,
               area: Area | None = None) -> Image:
    """Outline every tag, draw the axes of every TagPose, and write every id above its tag.

    The x axis is red, y green, z blue. The id of a tag at the top of the frame
    is below it, where it hides no axis. ``lens``: the Lens of the frame, which
    may be None if there are no poses. ``area``: an Area to outline too, or None.
    """
    image = _outlined(frame, tags)
    if area is not None:
        cv2.polylines(image, [fixed_point(area.outline())], True, PURPLE, 2, cv2.LINE_AA, SHIFT)
    for pose in poses:
        if lens is not None:
            _draw_axes(image, pose, lens)
    for tag in tags:
        _write_id(image, tag)
    return image


def _write_id(image: Image, tag: Tag) -> None:
    top, bottom = tag.corners[:, 1].min(), tag.corners[:, 1].max()
    has_room = top > 1.5 * ID_AWAY_PX
    write_text(image, str(tag.id), (tag.center[0], top - ID_AWAY_PX if has_room else bottom + ID_AWAY_PX))


def _draw_axes(image: Image, pose: TagPose, lens: Lens) -> None:
    ends = np.vstack([np.zeros(3), np.eye(3) * pose.size * AXIS_SIDES]) @ pose.rotation.T + pose.translation
    pixels = lens.project(ends)
    if np.all(np.abs(pixels) < MAX_DRAWN_PX):  # False also for NaN, which means behind the camera
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
    """Write text around a center, (2,) pixels; a dark rim makes it readable on black and on white."""
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, 0.7
    (width, height), _ = cv2.getTextSize(text, font, scale, 2)
    left = int(np.clip(center[0] - width / 2, 2, max(2, image.shape[1] - width - 2)))
    foot = int(np.clip(center[1] + height / 2, height + 2, max(height + 2, image.shape[0] - 3)))
    cv2.putText(image, text, (left, foot), font, scale, BLACK, 5, cv2.LINE_AA)
    cv2.putText(image, text, (left, foot), font, scale, YELLOW, 2, cv2.LINE_AA)


def mark_centers(frame: Image, centers: Iterable[Floats]) -> Image:
    """A copy of the frame with a dot on every center, (n, 2) pixels."""
    image = frame.copy()
    for center in centers:
        point = tuple(map(int, fixed_point(center)))
        cv2.circle(image, point, 5 << SHIFT, BLACK, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(image, point, 4 << SHIFT, YELLOW, -1, cv2.LINE_AA, SHIFT)
    return image


def fill_polygon(frame: Image, points: Sequence[Floats] | Floats, color: Color = PURPLE,
                 lens: Lens | None = None) -> Image:
    """A copy of the frame with the polygon through points, (n, 2) pixels, filled; their order matters.

    Nothing is filled if there are fewer than three points. ``lens``: the Lens of the frame, or None. It bends
    the polygon's sides as it bends straight lines of the wall.
    """
    image = frame.copy()
    if len(points) >= 3:
        outline = points if lens is None else Area(np.array(points), lens=lens).outline()
        cv2.fillPoly(image, [fixed_point(outline)], color, cv2.LINE_AA, SHIFT)
    return image
