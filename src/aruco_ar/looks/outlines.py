"""Whether a thing has come or has left: its outline is in the frame, or in what was taken for the wall."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Integers

from .parts import outline_of

RIM_PX = 5           # a mask is off by up to half of this, so the contrast in a window of this width counts
SHARP_LEVELS = 8.0   # an outline that is sharper than in the other image by less than this says nothing


def came_or_left(labels: Integers, count: int, seen: Floats, wall: Floats) -> tuple[Booleans, Booleans]:
    """(count + 1,) each: which parts have come since the wall was seen, and which were there and have left.

    ``labels``, ``count``: see parts_of. ``seen``, ``wall``: (h, w, 3) float32, the frame and what was taken for
    the wall, in the same light. Each part differs in them. A thing that has come has its outline in the frame.
    One that has left has it in the wall. A glare has no sharp outline at all, so it does neither.
    """
    outline = outline_of(labels > 0)
    sharper = _contrast(seen)[outline] - _contrast(wall)[outline]
    length = np.bincount(labels[outline], minlength=count + 1)
    mean = np.bincount(labels[outline], sharper, count + 1) / np.maximum(length, 1)
    return mean > SHARP_LEVELS, mean < -SHARP_LEVELS


def _contrast(image: Floats) -> Floats:
    """(h, w) float32: the difference between the lightest and the darkest pixel in a window, in gray levels."""
    gray, window = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.ones((RIM_PX, RIM_PX), np.uint8)
    return np.asarray(cv2.dilate(gray, window) - cv2.erode(gray, window), np.float32)
