"""What stands before the wall: a person, a hand that writes, a robot; drawn, with exact rims.

Each figure is a function that draws on a Canvas what is to be seen at a time,
seconds. Coordinates are shares of the frame's height, from its top left.
"""
import cv2
import numpy as np

FINE = 4  # a canvas has so many pixels for each of the frame, across and down
SKIN, SLEEVE, SHIRT, STRIPE = (122, 158, 208), (96, 62, 40), (60, 70, 168), (190, 200, 214)
JEANS, HAIR, SHOE = (118, 78, 44), (34, 42, 58), (40, 40, 44)
STEEL, TIRE, LAMP = (84, 82, 80), (30, 30, 30), (70, 200, 80)


class Canvas:
    """Draws polygons, ellipses and thick lines, and how much of each pixel they cover."""

    def __init__(self, width, height):
        self._size, self._unit = (width, height), height * FINE
        self._colors = np.zeros((height * FINE, width * FINE, 3), np.uint8)
        self._cover = np.zeros((height * FINE, width * FINE), np.uint8)

    def _draw(self, function, points, color):
        points = np.int32(np.round(np.array(points) * self._unit))
        for image, value in (self._colors, color), (self._cover, (255,)):
            function(image, points, value)

    def polygon(self, points, color):
        def draw(image, points, value):
            cv2.fillPoly(image, [points], value)
        self._draw(draw, points, color)

    def ellipse(self, middle, radii, color):
        radii = [int(radius * self._unit) for radius in radii]

        def draw(image, point, value):
            cv2.ellipse(image, tuple(map(int, point)), radii, 0, 0, 360, value, -1)
        self._draw(draw, middle, color)

    def line(self, points, width, color):
        width = max(1, int(width * self._unit))

        def draw(image, points, value):
            cv2.polylines(image, [points], False, value, width)
        self._draw(draw, points, color)

    def layer(self):
        """(h, w, 3) float32, the colors where something is drawn, and (h, w, 1), the share that it covers."""
        cover = cv2.resize(self._cover, self._size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
        colors = cv2.resize(self._colors, self._size, interpolation=cv2.INTER_AREA).astype(np.float32)
        return colors / np.maximum(cover, 1 / 255)[..., None], cover[..., None]


def person(canvas, seconds):
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


def hand(canvas, seconds):
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


def robot(canvas, seconds):
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
