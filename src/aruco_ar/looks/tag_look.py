"""What a tag and its paper look like, so that what stands in front of them is known."""
from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.geometry.lens import Lens
from aruco_ar.tracking.area import Area

from .difference import contrast_of, difference, soft_rim
from .parts import parts_of

SIZE = 64, 64         # of what is looked at, rectified, in pixels
MEAN_OF = 60          # the look is the running mean of about this many frames
LASTING = 60          # what is in front of a tag that is in sight for so many frames is a part of its look
VARIANCE = 4.0        # assumed variance of the noise


class Front(NamedTuple):
    """What is in front of a tag. ``share``: SIZE, float32, how much of each place it covers, 0 to 1.

    ``off``: SIZE and 3 colors, float32, how the frame differs from the tag without it.
    """

    share: Floats
    off: Floats


class TagLook:
    """Learns what a tag and its paper look like."""

    def __init__(self) -> None:
        self._look: Floats = np.zeros((*SIZE, 3), np.float32)
        self._light: Floats = np.ones(3)  # the mean color around the tag that belongs to the look
        self._count = self._hindered = 0  # frames in the look, and frames in a row with something in front

    def front(self, frame: Image, quad: Floats, lens: Lens | None, light: Floats, seen: bool) -> Front | None:
        """What is in front of the tag, or None if there is nothing.

        ``frame``: (h, w, 3) BGR uint8. ``quad``: (4, 2) undistorted pixels, what is looked at. ``lens``: that
        of the frame, or None. ``light``: (3,), the mean color around the tag. ``seen``: whether the tag is in
        sight. If it is, and nothing is in front of it, the frame is taken into the look.
        """
        area = Area.from_undistorted(quad, lens=lens)
        image, valid = area.rectified(frame, SIZE), area.in_frame(frame, SIZE)
        colors = np.asarray(image, np.float32)
        change = np.asarray(np.maximum(light, 1) / np.maximum(self._light, 1), np.float32)
        if self._count:
            apart = difference(cv2.blur(image, (3, 3)), self._look, change, contrast_of(self._look),
                               np.full(SIZE, VARIANCE, np.float32), valid).front
            labels, count = parts_of(apart) if apart.any() else (apart, 0)
            self._hindered = self._hindered + 1 if seen and count else 0
            if count and self._hindered < LASTING:
                look = self._look * change
                return Front(soft_rim(colors, look, labels > 0), colors - look)
        if seen and valid.all():
            self._count = 1 if self._hindered else min(self._count + 1, MEAN_OF)
            if self._count == 1:
                self._look, self._light = colors, light
            else:
                self._look = self._look + (colors / change - self._look) / np.float32(self._count)
        return None
