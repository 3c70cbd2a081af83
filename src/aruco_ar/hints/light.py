"""Frames that are so dark or so bright that nothing can be read in them."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Image

WAIT_S = 3.0          # no tag must be in sight, and the light must be bad, for this time
PAUSE_S = 0.5         # time between two looks
STEP_PX = 8           # of the pixels looked at
SHARE = 5             # percent of the pixels that may be lighter than DARK, or darker than BRIGHT
DARK, BRIGHT = 16, 240  # gray levels

TOO_DARK = (f'The image is almost black: 95 % of its pixels are below {DARK} of 255, so tags cannot be '
            'read. Turn on the light, take off the lens cap, or raise the exposure of the camera.')
TOO_BRIGHT = (f'The image is almost white: 95 % of its pixels are above {BRIGHT} of 255, so tags cannot be '
              'read. Lower the exposure of the camera, or the light.')


class Light:
    """Watches the light while no tag is in sight. ``hint``: a sentence about bad light, or None."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the frames before."""
        self.hint: str | None = None
        self._looked, self._problem, self._since = float('-inf'), '', 0.0  # when, what is wrong, and since when

    def update(self, frame: Image, stamp: float, found: bool) -> None:
        """Take in a frame, (h, w, 3) BGR uint8, at a time, seconds. ``found``: whether a tag is in sight."""
        if found:
            self.reset()
            return
        if stamp - self._looked < PAUSE_S:
            return
        self._looked, problem = stamp, _problem_of(frame)
        if problem != self._problem:
            self._problem, self._since = problem, stamp
        self.hint = problem if problem and stamp - self._since >= WAIT_S else None


def _problem_of(frame: Image) -> str:
    gray = cv2.cvtColor(np.ascontiguousarray(frame[::STEP_PX, ::STEP_PX]), cv2.COLOR_BGR2GRAY)
    if np.percentile(gray, 100 - SHARE) < DARK:
        return TOO_DARK
    return TOO_BRIGHT if np.percentile(gray, SHARE) > BRIGHT else ''
