"""What differs from the wall by more than light and noise can explain: something stands before it."""
from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats

from .parts import closed, grown, shrunk

# Light changes the brightness of a pixel, and its color a little: by this share of the brightness. Besides,
# a pixel may differ by so many deviations of its noise, and by gray levels. The rims of a pattern may be
# blurred, or off by a pixel: there it may differ by a share of the contrast within some pixels.
SHARE, DEVIATIONS, LEVELS, RIM_SHARE, RIM_PX = 0.08, 3.5, 2.0, 0.5, 5
DARKEST, LIGHTEST = 0.36, 2.6  # the light at a pixel, relative to that on the whole wall: a shadow, a spot
SHARP = 0.22          # the rim of a shadow is softer than this change of the light's logarithm within 3 pixels
NEAR_PX = 5           # so near to what is surely in front, weaker evidence is enough
BRIDGE_PX = 21        # and between it, where the light is not the usual one around
AROUND_PX = 61        # of the window that shows the usual light
RIM_MARGIN_PX = 8     # around the things in front, for their rims
MIN_CONTRAST = 5.0    # gray levels between a thing and the wall that show a pixel's share
LIKE = 0.8            # the correlation with the wall's pattern, if that is seen
PATTERN_PX = 15       # of the window for the correlation
PATTERN_LEVELS = 6.0  # standard deviation of a pattern that can be recognized


@dataclass(frozen=True)
class Difference:
    """How a frame differs from the wall. ``front``: (h, w), where something seems to stand before it.

    ``light``: (h, w) float32, the light on each pixel relative to that on the whole wall. ``error``: (h, w)
    float32, gray levels by which the color is off that light cannot explain.
    """

    front: Booleans
    light: Floats
    error: Floats


def difference(seen: Floats, wall: Floats, variance: Floats, usable: Booleans) -> Difference:
    """Compare a rectified frame with the wall.

    ``seen``, ``wall``: (h, w, 3) float32, the frame, and the wall as it looks in the light of the frame.
    ``variance``: (h, w) float32, of the noise. ``usable``: (h, w), where both are known.
    """
    gray, wall_gray = _mean(seen), np.maximum(_mean(wall), 1)
    light = gray / wall_gray
    kernel = np.ones((RIM_PX, RIM_PX), np.uint8)
    contrast = np.asarray(cv2.subtract(cv2.dilate(wall, kernel), cv2.erode(wall, kernel)), np.float32)
    noise = np.float32(LEVELS) + np.float32(DEVIATIONS) * np.sqrt(variance)
    excess = error = np.zeros(light.shape, np.float32)
    for color, wall_color, rim in zip(*map(cv2.split, (seen, wall, contrast))):  # one after the other is faster
        lit = np.asarray(wall_color * light)
        off = np.abs(color - lit)
        allowed = np.float32(SHARE) * lit + np.float32(RIM_SHARE) * (rim * light) + noise
        excess, error = np.maximum(excess, off / allowed), np.maximum(error, off)
    rims = np.float32(RIM_SHARE) * _mean(contrast)
    slack = (np.float32(2 / 3) * noise + rims) / wall_gray
    step = _range(np.log(np.maximum(light, 0.02))) - 2 * slack / np.maximum(light, 0.1)
    front = (excess > 1) | (light < DARKEST - slack) | (light > LIGHTEST + slack) | (step > SHARP)
    front &= usable
    if front.any():
        free = ~usable | _shows_pattern(gray, wall_gray)
        front = cv2.morphologyEx((front & ~free).astype(np.uint8), cv2.MORPH_OPEN,
                                 cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0
        unusual = np.abs(light - _usual(light, usable & ~grown(front, NEAR_PX))) * wall_gray - rims > noise / 2
        weak = excess > 0.5
        front |= grown(front, NEAR_PX) & (weak | ((step > SHARP / 2) & unusual))
        front |= closed(front, BRIDGE_PX) & (weak | unusual)
        front &= ~free
    return Difference(front, light, error)


def soft_rim(seen: Floats, wall: Floats, front: Booleans) -> Floats:
    """(h, w) float32, 0 to 1: how much of each pixel the things in front cover.

    ``seen``, ``wall``: see difference. A pixel at a rim is a mixture of the colors on both sides. The place of
    its color on the line between the two shows its share.
    """
    share = np.zeros(front.shape, np.float32)
    x, y, width, height = cv2.boundingRect(front.astype(np.uint8))
    part = slice(max(y - RIM_MARGIN_PX, 0), y + height + RIM_MARGIN_PX), \
        slice(max(x - RIM_MARGIN_PX, 0), x + width + RIM_MARGIN_PX)
    seen, wall, front = seen[part], wall[part], front[part]
    core = shrunk(front, 5)
    weight = core + np.float32(0.01) * front  # the color of the core nearby, or of what there is without a core
    weights = np.maximum(cv2.blur(weight, (7, 7)), 1e-4)
    both = length = np.zeros(front.shape, np.float32)
    for color, wall_color in zip(cv2.split(seen), cv2.split(wall)):
        contrast = cv2.blur(color * weight, (7, 7)) / weights - wall_color
        both, length = both + (color - wall_color) * contrast, length + contrast * contrast
    mixed = np.clip(both / np.maximum(length, 3 * MIN_CONTRAST**2), 0, 1)
    share[part] = np.where(core, 1, np.where(grown(front, 3), mixed, 0))
    return share


def largest_difference(one: Floats, other: Floats) -> Floats:
    """(h, w) float32: the largest difference among the channels of two images, (h, w, 3) float32."""
    blue, green, red = cv2.split(cv2.absdiff(one, other))
    return np.asarray(cv2.max(cv2.max(blue, green), red), np.float32)


def _mean(image: Floats) -> Floats:
    """(h, w) float32: the mean of the channels."""
    return np.asarray(cv2.transform(image, np.full((1, 3), 1 / 3, np.float32)), np.float32)


def _range(image: Floats) -> Floats:
    """(h, w) float32: the largest difference within 3 x 3 pixels."""
    kernel = np.ones((3, 3), np.uint8)
    return np.asarray(cv2.subtract(cv2.dilate(image, kernel), cv2.erode(image, kernel)), np.float32)


def _usual(light: Floats, free: Booleans) -> Floats:
    """(h, w) float32: the mean light around each pixel, where it is free; 1 where nothing is free."""
    weight, size = free.astype(np.float32), (AROUND_PX, AROUND_PX)
    sums, weights = (cv2.boxFilter(image, -1, size) for image in (light * weight, weight))
    return np.asarray((sums + 1e-3) / (weights + 1e-3))


def _shows_pattern(gray: Floats, wall: Floats) -> Booleans:
    """Where the wall's pattern is seen, so that nothing stands before it, whatever the light or a glare does.

    Both are (h, w) float32. It is seen where their normalized correlation in a window is high.
    """
    def mean(image: Floats) -> Floats:
        return np.asarray(cv2.boxFilter(image, -1, (PATTERN_PX, PATTERN_PX)))
    gray, wall = gray - mean(gray), wall - mean(wall)
    own, known = (np.maximum(mean(image * image), 0) for image in (gray, wall))  # rounding can make it negative
    return np.asarray((mean(gray * wall) > LIKE * np.sqrt(own * known)) & (known > PATTERN_LEVELS**2)
                      & (own > PATTERN_LEVELS**2 / 16))
