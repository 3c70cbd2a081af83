"""The light on the wall: how bright, and of which color, white paper would be at each place."""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.geometry.homography import homography_to
from aruco_ar.geometry.lens import Lens, rectify
from aruco_ar.tags.corner_rays import straight_corners
from aruco_ar.tags.tag import Tag

from .wall_model import WallModel

COARSE = 4            # the light is measured on an image that is smaller by this factor
TAG_PX = 24           # side of the rectified image of a tag
TAG_SCALE = 1.2       # width of that image in sides of the tag; it shows some of the white rim
WHITE_PERCENTILE, BLACK_PERCENTILE = 92, 8
MIN_WHITE = 20.0      # least level of white paper, in gray levels; in less light a tag shows nothing
WINDOWS_PX = 121, 25, 3  # the smallest of these windows in which enough of the wall is free shows the light
ENOUGH = 0.08         # share of a window in which the wall must be free
NOISE = 12.0**2       # a wall that is darker than its root, in gray levels, tells little of the light
MOST = 2.0            # the light at a place is at most this multiple of that on the whole wall
COLORS_EVERY = 4      # with nothing in front, the wall's color is taken anew in every fourth frame


def white_and_black(frame: Image, tags: Sequence[Tag], lens: Lens | None) -> tuple[Floats, Floats]:
    """The levels of the paper and of the ink of tags: two (n, 3) float64, BGR.

    ``frame``: (h, w, 3) BGR uint8, in which the tags are. ``lens``: its Lens, or None.
    """
    scale = np.array([[TAG_SCALE, 0, 0.5 - TAG_SCALE / 2], [0, TAG_SCALE, 0.5 - TAG_SCALE / 2], [0, 0, 1]])
    levels = []
    for tag in tags:
        to_frame = homography_to(straight_corners(tag, lens)) @ scale @ np.diag([1 / TAG_PX, 1 / TAG_PX, 1])
        patch = rectify(frame, to_frame, (TAG_PX, TAG_PX), lens).reshape(-1, 3)
        levels.append(np.percentile(patch, (WHITE_PERCENTILE, BLACK_PERCENTILE), axis=0))
    white, black = np.array(levels).reshape(-1, 2, 3).transpose(1, 0, 2)
    return white, black


class WallLight:
    """The light on a wall that a WallModel knows.

    ``black``: the level of ink as a share of that of paper. A printed picture would not be darker than ink.
    """

    def __init__(self, places: Floats, white: Floats, black: Floats, model: WallModel) -> None:
        """Begin with the levels of the paper and of the ink in the light in which the model first saw the wall.

        ``places``: (n, 2), the tags' centers in the area, which is the unit square. ``white``, ``black``: see
        white_and_black.
        """
        height, width = (max(1, length // COARSE) for length in model.look.shape[:2])
        self._size = width, height
        x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
        away = (x[..., None] - places[:, 0])**2 + (y[..., None] - places[:, 1])**2
        share = 1 / (away + 0.01)
        share /= share.sum(axis=2, keepdims=True)
        first = share @ np.maximum(white, MIN_WHITE)
        self._first = np.ascontiguousarray(first.transpose(2, 0, 1), np.float32)  # (3, h, w)
        self._frees = 0  # frames since something was in front
        self.black = float(np.clip((black / np.maximum(white, MIN_WHITE)).mean(), 0, 0.8))

    def update(self, image: Image, model: WallModel) -> Image:
        """(h, w, 3) uint8: the level of white paper at each place of a frame.

        ``image``: (h, w, 3) BGR uint8, the rectified frame, which the model has taken in.
        """
        seen = self._coarse(image)
        whole = self._first * np.reshape(model.light, (3, 1, 1))
        light = whole
        if model.free.all():
            if self._frees % COLORS_EVERY == 0:
                wall = self._color_of(model)
                self._colors = [_mean(wall, window) for window in WINDOWS_PX[1:]]
            self._frees += 1
            for window, color in zip(WINDOWS_PX[1:], self._colors):
                light = _refined(light, _mean(seen, window), color)
        else:
            self._frees = 0
            free = self._share(model.free)
            seen, color = seen * free, self._color_of(model) * free
            for window in WINDOWS_PX:
                share = np.maximum(_mean(free, window), 1e-4)
                refined = _refined(light, _mean(seen, window) / share, _mean(color, window) / share)
                light = light + np.minimum(share / ENOUGH, 1) * (refined - light)
        light = np.clip(np.minimum(light, MOST * whole), 0, 255)
        return np.ascontiguousarray(light.transpose(1, 2, 0), np.uint8)

    def _color_of(self, model: WallModel) -> Floats:
        """(h, w, 3) float32: the wall's color, as a share of white."""
        color = self._coarse(model.look) / self._first.transpose(1, 2, 0)
        if model.plain is not None:  # on a blank wall, a color that varies is light
            plain = self._share(model.plain)
            mean = (color * plain).sum(axis=(0, 1)) / max(plain.sum(), 1e-3)
            color += plain * (mean - color)
        return color

    def _share(self, mask: Booleans) -> Floats:
        """(h, w, 1) float32: which share of each coarse pixel is in a mask."""
        return self._coarse(mask.astype(np.uint8) * 255)[..., None] / 255

    def _coarse(self, image: Image | Floats) -> Floats:
        return np.asarray(cv2.resize(image, self._size, interpolation=cv2.INTER_AREA), np.float32)


def _refined(light: Floats, seen: Floats, color: Floats) -> Floats:
    """(3, h, w): the light as a small window around each place shows it.

    ``light``: (3, h, w), as it was before. ``seen``, ``color``: (3, h, w), the means of the window. A dark wall
    tells less than a light one, and a dark channel less than the others. So the brightness of all channels is
    followed first, and then each channel for itself: least squares, with the light before as a guess.
    """
    expected = color * light
    gray = expected.sum(axis=0)
    factor = (seen.sum(axis=0) * gray + 9 * NOISE) / (gray * gray + 9 * NOISE)
    expected *= factor
    return np.asarray(light * factor * (seen * expected + NOISE) / (expected * expected + NOISE))


def _mean(image: Floats, px: int) -> Floats:
    """(c, h, w): the mean of a window of that width around each pixel of an image, (h, w, c).

    The outside of the image is 0. Apart, the channels are faster to use.
    """
    mean = cv2.blur(image, (px, px), borderType=cv2.BORDER_CONSTANT)
    return np.ascontiguousarray(np.atleast_3d(mean).transpose(2, 0, 1))
