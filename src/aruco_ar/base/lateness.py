"""Stale frames, which are not published."""
from __future__ import annotations

from collections import deque

# A period is the time between two frames of the camera.
STALE_PERIODS = 1.25     # an older result is stale: a subscriber should get it before it is two periods old
DELAYED_PERIODS = 0.5    # a frame that arrives this much later than usual was delayed; the next follows soon
NEXT_PERIODS = 1.25      # a frame that has not arrived this long after the usual time of the one before is lost
MAX_WAIT_S = 0.1         # waiting longer for the next frame is not worthwhile
MEDIAN_OF = 15           # the camera's period is the median of this many periods
SMOOTHING = 1 / 16       # the weight of a new frame in the running means
USUAL_AGE_DRIFT = 0.001  # periods by which the usual age grows with each frame, unless a younger one arrives


class Lateness:
    """Says which frames are stale, in a node that keeps up with its camera as a rule.

    If the node is too slow for its camera, or if the clocks of the two differ,
    most frames are old. Then no frame counts as stale, so that something is
    published at all. All times are seconds.
    """

    def __init__(self) -> None:
        self._stamp = float('nan')
        self._periods: deque[float] = deque(maxlen=MEDIAN_OF)
        self._usual_age = float('inf')  # the age of a frame when it arrives, if nothing delays it
        self._arrived = self._processing_s = 0.0
        self._old_share = 1.0  # the share of old frames among the last ones; at first all are assumed to be old

    def wait_for_next(self, stamp: float, now: float, missing: int) -> float:
        """How long to wait for the next frame, to process it instead of this one; 0 to process this one.

        ``missing``: how many frames were dropped before this one. A node that
        needs nearly a whole period for a frame never catches up after a delay,
        unless it skips a frame.
        """
        if stamp > self._stamp:  # False for the first frame, since NaN compares so
            self._periods.append((stamp - self._stamp) / (missing + 1))
        self._stamp, self._arrived = stamp, now
        period, age = self._period(), now - stamp
        self._usual_age = min(age, self._usual_age + USUAL_AGE_DRIFT * period)
        is_delayed = age > self._usual_age + DELAYED_PERIODS * period
        if not (is_delayed and age + self._processing_s > STALE_PERIODS * period > self._processing_s):
            return 0.0
        return max(0.0, min(self._usual_age + NEXT_PERIODS * period - age, MAX_WAIT_S))

    def is_stale(self, now: float) -> bool:
        """Whether the last frame is too old to be published, now that it has been processed."""
        self._processing_s += SMOOTHING * (now - self._arrived - self._processing_s)
        is_old = bool(self._periods) and now - self._stamp > STALE_PERIODS * self._period()
        self._old_share += SMOOTHING * ((is_old or not self._periods) - self._old_share)
        return is_old and self._keeps_up()

    def _period(self) -> float:
        return sorted(self._periods)[len(self._periods) // 2] if self._periods else 0.0

    def _keeps_up(self) -> bool:
        return self._old_share < 0.5
