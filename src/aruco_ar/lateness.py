"""Frames that are too old to be worth showing."""
from __future__ import annotations

from collections import deque

MAX_PERIODS = 1.25     # of the camera; who listens shall have what is made of a frame before it is two old
HELD_UP_PERIODS = 0.5  # later than usual: the next frame comes soon
DUE_PERIODS = 1.25     # after the last it has come, or does not
MOST_S = 0.1           # for which it is worth waiting for it
PERIODS = 15           # the median of so many is the camera's
SMOOTHING = 1 / 16     # of a frame in what is known of those before
FORGET = 0.001         # of a period by which the usual age grows with each frame, unless one comes younger


class Lateness:
    """Tells which frames are too old, as a rule for a node that keeps up with its camera.

    Where a node is too slow for its camera, or the clocks of the two differ,
    most frames are old, and none is too old to be shown. All times are seconds.
    """

    def __init__(self) -> None:
        self._stamp = float('nan')
        self._periods: deque[float] = deque(maxlen=PERIODS)
        self._usual = float('inf')  # age at which frames come, if nothing holds them up
        self._began = self._spent = 0.0
        self._share = 1.0  # of old frames among the last; all, until it shows that it is not so

    def begins(self, stamp: float, now: float, missing: int) -> float:
        """For how long to wait for a frame in place of this one: 0 where it may well be in time.

        ``missing``: so many were dropped before it. A node that is held up has
        each frame come late from then on, if it needs nearly all the time that
        there is for one; unless it leaves one out.
        """
        if stamp > self._stamp:  # not so of the first
            self._periods.append((stamp - self._stamp) / (missing + 1))
        self._stamp, self._began = stamp, now
        period, age = self._period(), now - stamp
        self._usual = min(age, self._usual + FORGET * period)
        is_held_up = age > self._usual + HELD_UP_PERIODS * period
        if not (is_held_up and age + self._spent > MAX_PERIODS * period > self._spent):
            return 0.0
        return max(0.0, min(self._usual + DUE_PERIODS * period - age, MOST_S))

    def is_late(self, now: float) -> bool:
        """Whether that frame has become too old, when all is made of it."""
        self._spent += SMOOTHING * (now - self._began - self._spent)
        is_old = bool(self._periods) and now - self._stamp > MAX_PERIODS * self._period()
        self._share += SMOOTHING * ((is_old or not self._periods) - self._share)
        return is_old and self._keeps_up()

    def _period(self) -> float:
        return sorted(self._periods)[len(self._periods) // 2] if self._periods else 0.0

    def _keeps_up(self) -> bool:
        return self._share < 0.5
