"""The time of a sequence of frames."""
from __future__ import annotations

USUAL_PERIOD_S = 1 / 30  # the time between frames that is assumed if their stamps do not differ


class FrameClock:
    """Turns the stamps of frames into a time that always moves on, also while stamps stand still or go back."""

    def __init__(self) -> None:
        self.now = 0.0  # seconds
        self._stamp: float | None = None

    def goes_back(self, stamp: float) -> bool:
        """Whether a frame's stamp, seconds, is earlier than the one before, or is not a number."""
        return self._stamp is not None and not stamp >= self._stamp

    def passed(self, stamp: float) -> float:
        """The seconds from the last frame to one with that stamp, seconds."""
        return USUAL_PERIOD_S if self._stamp is None or not stamp > self._stamp else stamp - self._stamp

    def advance(self, stamp: float) -> float:
        """Move on to a frame's stamp, seconds. Returns the seconds since the frame before it."""
        passed = self.passed(stamp)
        self.now += passed
        self._stamp = stamp
        return passed
