"""Frames that come too late to be worth showing."""
from collections import deque
from typing import Deque, Optional

MAX_PERIODS = 1.5   # of the camera; what is made of a frame shall be out before it is two periods old
PERIODS = 15        # the median of so many is the camera's
SMOOTHING = 1 / 16  # of a frame in what is known of those before


class Lateness:
    """Tells which frames are too old, as a rule for a node that keeps up with its camera.

    Where a node is too slow for its camera, or the clocks of the two differ,
    most frames are old, and none is too old to be shown.
    """

    def __init__(self):
        self._last: Optional[float] = None
        self._periods: Deque[float] = deque(maxlen=PERIODS)
        self._share = 1.0  # of old frames among the last; all, until it shows that it is not so

    def is_late(self, stamp, now, missing):
        """Whether a frame is too old. ``stamp``, ``now``: seconds. ``missing``: so many were dropped before."""
        if self._last is not None and stamp > self._last:
            self._periods.append((stamp - self._last) / (missing + 1))
        self._last = stamp
        if not self._periods:
            return False
        period = sorted(self._periods)[len(self._periods) // 2]
        is_old = now - stamp > MAX_PERIODS * period
        self._share += SMOOTHING * (is_old - self._share)
        return is_old and self._share < 0.5
