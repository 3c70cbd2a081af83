"""A picture in several sizes."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Image


class Picture:
    """A picture that is painted. It keeps its smaller sizes, so that shrinking it skips no pixels.

    ``pixels``: (h, w, 3) BGR or (h, w, 4) BGRA uint8, which must not be changed any more.
    """

    def __init__(self, pixels: Image) -> None:
        self.pixels = pixels
        self._levels = [pixels]

    @property
    def shape(self) -> tuple[int, ...]:
        """(h, w, 3) or (h, w, 4)."""
        return self.pixels.shape

    def levels(self, count: int) -> list[Image]:
        """The picture, and at most ``count`` smaller ones, each half as wide and high as the one before."""
        while len(self._levels) <= count and min(self._levels[-1].shape[:2]) > 1:
            self._levels.append(_half(self._levels[-1]))
        return self._levels[:count + 1]


def _half(picture: Image) -> Image:
    """The picture at half its size. Each pixel is the mean of four; an odd side loses its last pixel."""
    picture = picture[:picture.shape[0] // 2 * 2, :picture.shape[1] // 2 * 2]
    if picture.shape[2] == 3:
        return cv2.resize(picture, None, None, 0.5, 0.5, cv2.INTER_AREA)
    # Colors count by their alpha, so that transparent ones do not bleed in.
    alpha = np.asarray(picture[:, :, 3:], np.float32)
    colors = cv2.resize(picture[:, :, :3] * alpha, None, None, 0.5, 0.5, cv2.INTER_AREA)
    mean = cv2.resize(alpha[:, :, 0], None, None, 0.5, 0.5, cv2.INTER_AREA)[:, :, None]
    return np.asarray(np.round(np.concatenate([colors / np.maximum(mean, 1e-3), mean], axis=2)), np.uint8)
