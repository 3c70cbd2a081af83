"""Which frame a published image shows, whatever is drawn on it, and whether its colors are exchanged."""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Floats, Image

SMALL = 320, 240  # pixels: images are compared at this size
CLIP = 40.0       # gray levels: more than this counts as this, since much may be painted over
SURE = 0.6        # with exchanged colors the frame fits much better: at most this share of the difference
LEAST = 1.0       # gray levels: differences below this are noise


class Background:
    """The frames of a check, of which one is behind each published image."""

    def __init__(self, frames: Sequence[Image]) -> None:
        """``frames``: (h, w, 3) BGR uint8."""
        self._colors = [_small(frame) for frame in frames]
        self._grays = [_small(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)) for frame in frames]

    def number(self, image: Image) -> int:
        """The number, from 0, of the frame that an image, gray or BGR, is most like."""
        small = _small(image)
        if image.ndim == 2:
            return int(np.argmin([_unlike(small, gray) for gray in self._grays]))
        # The mean of the colors is the same if they are exchanged.
        return int(np.argmin([_unlike(small.mean(axis=2), color.mean(axis=2)) for color in self._colors]))


def has_exchanged_colors(frames: Sequence[Image], images: Sequence[Image]) -> bool:
    """Whether blue is red in most of what was not drawn on.

    ``images``: what was made of the frames, gray or BGR.
    """
    pairs = [(_small(frame), _small(image)) for frame, image in zip(frames, images) if image.ndim == 3]
    as_is = sum(_unlike(frame, image) for frame, image in pairs)
    exchanged = sum(_unlike(frame, image[..., ::-1]) for frame, image in pairs)
    return exchanged < SURE * as_is and as_is - exchanged > LEAST * len(pairs)


def _small(image: Image) -> Floats:
    return cv2.resize(image, SMALL, interpolation=cv2.INTER_AREA).astype(np.float32)


def _unlike(one: Floats, other: Floats) -> float:
    return float(np.minimum(np.abs(one - other), CLIP).mean())
