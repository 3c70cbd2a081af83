"""Drawings of what moves in front of the wall: a person, a hand that writes, a robot. Their rims are exact.

Each figure is a function that draws on a Canvas what is seen at a time,
seconds. Coordinates are shares of the height of a frame, from its top left.
"""
from __future__ import annotations

from typing import Callable, Sequence, Tuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.painting.pixels import blend

FINE = 4  # a canvas has this many pixels for each pixel of its image, across and down
SKIN, SLEEVE, SHIRT, STRIPE = (122, 158, 208), (96, 62, 40), (60, 70, 168), (190, 200, 214)
JEANS, HAIR, SHOE = (118, 78, 44), (34, 42, 58), (40, 40, 44)
STEEL, TIRE, LAMP = (84, 82, 80), (30, 30, 30), (70, 200, 80)

# A visitor of the simulated wall moves in a plane in front of it. These are meters of the wall.
AWAY_M = 0.3                 # distance of that plane from the wall
SHARE_M = 1.05               # length of 1 on a canvas: the size of a small child, whose head the camera sees
LEFT_M, TOP_M = -1.6, 1.155  # top left of the canvas
CANVAS_PX = 1200, 480        # size of the canvas that is seen from the camera
SHARE_PX = 300               # length of 1 on that canvas

Point = Sequence[float]
Color = Tuple[int, int, int]  # (blue, green, red)


class Canvas:
    """Draws polygons, ellipses and thick lines, and how much of each pixel they cover."""

    def __init__(self, width: int, height: int, share_px: float | None = None, left: float = 0.0,
                 fine: int = FINE) -> None:
        """An empty canvas of that size in pixels. ``share_px``: the length of 1, by default the height.

        ``left``: the coordinate of its left rim. ``fine``: see FINE.
        """
        self._size, self._left = (width, height), left
        self._unit = (height if share_px is None else share_px) * fine
        self._colors: Image = np.zeros((height * fine, width * fine, 3), np.uint8)
        self._cover: Image = np.zeros((height * fine, width * fine), np.uint8)

    def _pixels(self, points: Sequence[Point]) -> Image:
        """(n, 2) int32."""
        return np.asarray(np.round((np.array(points) - (self._left, 0)) * self._unit), np.int32)

    def polygon(self, points: Sequence[Point], color: Color) -> None:
        """Fill a polygon."""
        for image, value in (self._colors, color), (self._cover, (255,)):
            cv2.fillPoly(image, [self._pixels(points)], value)

    def ellipse(self, middle: Point, radii: Point, color: Color) -> None:
        """Fill an ellipse."""
        x, y = map(int, self._pixels([middle])[0])
        size = [int(radius * self._unit) for radius in radii]
        for image, value in (self._colors, color), (self._cover, (255,)):
            cv2.ellipse(image, (x, y), size, 0, 0, 360, value, -1)

    def line(self, points: Sequence[Point], width: float, color: Color) -> None:
        """Draw a thick line through points."""
        for image, value in (self._colors, color), (self._cover, (255,)):
            cv2.polylines(image, [self._pixels(points)], False, value, max(1, int(width * self._unit)))

    def layer(self) -> tuple[Floats, Floats]:
        """(h, w, 3) float32, the colors where something is drawn, and (h, w, 1), the share that it covers."""
        colors, cover = (cv2.resize(image, self._size, interpolation=cv2.INTER_AREA).astype(np.float32)
                         for image in (self._colors, self._cover))
        return colors / np.maximum(cover, 1)[..., None] * 255, cover[..., None] / 255

    def flat(self) -> tuple[Image, Image]:
        """The canvas itself: (h, w, 3) uint8, black where nothing is drawn, and (h, w) uint8, white there."""
        return self._colors, self._cover


def person(canvas: Canvas, seconds: float) -> None:
    """Someone walks past from the left to the right, and back, 6 s each way."""
    way = 1 - abs(seconds / 6 % 2 - 1)
    x, swing = -0.15 + 1.65 * way, np.sin(2 * np.pi * 1.1 * seconds)
    for side in -1, 1:
        knee = (x + 0.05 * side * swing, 0.86)
        canvas.line([(x, 0.62), knee, (x + 0.09 * side * swing, 1.1)], 0.09, JEANS)
    canvas.line([(x, 0.33), (x - 0.07 * swing, 0.48), (x - 0.03 * swing + 0.03, 0.62)], 0.055, SHIRT)
    canvas.polygon([(x - 0.1, 0.28), (x + 0.1, 0.28), (x + 0.08, 0.66), (x - 0.08, 0.66)], SHIRT)
    for row in 0.34, 0.42, 0.50, 0.58:
        canvas.line([(x - 0.085, row), (x + 0.085, row)], 0.02, STRIPE)
    canvas.line([(x, 0.31), (x + 0.07 * swing, 0.46), (x + 0.1 * swing + 0.03, 0.6)], 0.05, SHIRT)
    canvas.ellipse((x + 0.1 * swing + 0.03, 0.61), (0.025, 0.03), SKIN)
    canvas.line([(x, 0.24), (x, 0.3)], 0.06, SKIN)
    canvas.ellipse((x, 0.17), (0.062, 0.085), SKIN)
    canvas.ellipse((x - 0.008, 0.13), (0.064, 0.06), HAIR)


def hand(canvas: Canvas, seconds: float) -> None:
    """A hand writes, in lines; after 2 s it comes in from the right and below."""
    into = np.clip((seconds - 2) / 0.8, 0, 1)
    x = 0.42 + 0.05 * (seconds % 4) + 0.008 * np.sin(17 * seconds) + 0.9 * (1 - into)
    y = 0.46 + 0.04 * (seconds // 4 % 3) + 0.012 * np.sin(23 * seconds) + 0.6 * (1 - into)
    canvas.line([(x + 0.36, y + 0.42), (x + 0.9, y + 1.0)], 0.2, SLEEVE)
    canvas.line([(x + 0.16, y + 0.2), (x + 0.4, y + 0.47)], 0.14, SKIN)
    canvas.ellipse((x + 0.13, y + 0.14), (0.095, 0.085), SKIN)
    for reach in 0.0, 0.03, 0.06:
        knuckle, tip = (x + 0.1 + reach, y + 0.1 + reach / 2), (x + 0.045 + reach, y + 0.035 + reach)
        canvas.line([knuckle, tip], 0.034, SKIN)
    canvas.line([(x, y), (x + 0.14, y - 0.08)], 0.012, (150, 40, 30))
    canvas.line([(x + 0.12, y + 0.08), (x + 0.035, y + 0.01)], 0.036, (112, 146, 196))


def robot(canvas: Canvas, seconds: float) -> None:
    """A robot drives by on the floor, with a mast as high as the picture."""
    x = -0.3 + 1.95 * (1 - abs(seconds / 5 % 2 - 1))
    canvas.line([(x, 0.75), (x, 0.34)], 0.035, STEEL)
    canvas.polygon([(x - 0.08, 0.3), (x + 0.08, 0.3), (x + 0.08, 0.38), (x - 0.08, 0.38)], (40, 60, 190))
    for lens in -0.04, 0.04:
        canvas.ellipse((x + lens, 0.34), (0.022, 0.022), TIRE)
    canvas.polygon([(x - 0.24, 0.62), (x + 0.24, 0.62), (x + 0.26, 0.86), (x - 0.26, 0.86)], STEEL)
    canvas.polygon([(x - 0.22, 0.65), (x + 0.22, 0.65), (x + 0.22, 0.70), (x - 0.22, 0.70)], (30, 150, 220))
    canvas.ellipse((x + 0.18, 0.78), (0.02, 0.02), LAMP)
    for wheel in -0.17, 0.17:
        canvas.ellipse((x + wheel, 0.88), (0.09, 0.09), TIRE)
        canvas.ellipse((x + wheel, 0.88), (0.04, 0.04), (150, 150, 150))


NOBODY = 'nobody'
FIGURES: dict[str, Callable[[Canvas, float], None]] = {'person': person, 'hand': hand}
VISITORS = NOBODY, *FIGURES


def draw_visitor(frame: Image, visitor: str, seconds: float, matrix: Floats, rotation: Floats,
                 translation: Floats) -> None:
    """Draw one of FIGURES into a frame, (h, w, 3) BGR uint8, as it moves in front of the wall.

    ``matrix``: (3, 3), the camera matrix. ``rotation``, ``translation``: the view (see wall_to_camera).
    """
    corners = np.array([[LEFT_M, TOP_M, AWAY_M], [LEFT_M + CANVAS_PX[0] / SHARE_PX * SHARE_M, TOP_M, AWAY_M],
                        [LEFT_M, TOP_M - CANVAS_PX[1] / SHARE_PX * SHARE_M, AWAY_M]])
    if np.min(corners @ rotation[2] + translation[2]) <= AWAY_M:
        return  # the camera is so near that it is beside the visitor
    canvas = Canvas(*CANVAS_PX, SHARE_PX, LEFT_M / SHARE_M + 2 / 3, fine=2)
    FIGURES[visitor](canvas, seconds)
    meters = SHARE_M / (2 * SHARE_PX)  # the size of a pixel of the canvas
    plane = np.array([[meters, 0, LEFT_M], [0, -meters, TOP_M], [0, 0, AWAY_M], [0, 0, 1]])
    to_image = matrix @ np.column_stack([rotation, translation]) @ plane
    # The colors are warped together with what they cover, so both fade alike at a rim.
    colors, cover = (cv2.warpPerspective(image, to_image, frame.shape[1::-1]) for image in canvas.flat())
    shown = cv2.cvtColor(cover, cv2.COLOR_GRAY2BGR)
    frame[:] = cv2.add(blend(frame, np.zeros_like(frame), shown), colors)
