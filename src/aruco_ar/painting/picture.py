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
        self._levels: dict[tuple[int, int], Image] = {}

    @property
    def shape(self) -> tuple[int, ...]:
        """(h, w, 3) or (h, w, 4)."""
        return self.pixels.shape

    def level(self, across: int, down: int) -> Image:
        """The picture, its width halved ``across`` times, and its height halved ``down`` times.

        Each pixel is the mean of those that it covers; an odd side loses its last pixel. A side of one pixel is
        doubled first. Colors of BGRA are multiplied by their alpha, so that transparent ones do not bleed in.
        Raises IndexError where nothing would be left.
        """
        if (across, down) not in self._levels:
            self._levels[across, down] = self._made(across, down)
        return self._levels[across, down]

    def _made(self, across: int, down: int) -> Image:
        if not across and not down:
            height, width = self.pixels.shape[:2]
            pixels = np.ascontiguousarray(self.pixels)
            if height == 1 or width == 1:
                pixels = pixels.repeat(1 + (height == 1), axis=0).repeat(1 + (width == 1), axis=1)
            return _multiplied(pixels) if pixels.shape[2] == 4 else pixels
        # Both sides at once, as far as possible, is fastest.
        larger = self.level(across - (across >= down), down - (down >= across))
        wide, high = larger.shape[1] >> (across >= down), larger.shape[0] >> (down >= across)
        if not wide or not high:
            raise IndexError('A picture of %d x %d pixels cannot be halved so often.'
                             % self.pixels.shape[1::-1])
        even = larger[:high << (down >= across), :wide << (across >= down)]
        # For a half, this is the mean of two or of four pixels.
        return cv2.resize(even, (wide, high), interpolation=cv2.INTER_LINEAR)


def _multiplied(picture: Image) -> Image:
    """BGRA, its colors multiplied by its alpha."""
    alpha = picture[:, :, 3]
    colors = cv2.multiply(picture[:, :, :3], cv2.cvtColor(alpha, cv2.COLOR_GRAY2BGR), scale=1 / 255)
    return np.dstack([colors, alpha])
