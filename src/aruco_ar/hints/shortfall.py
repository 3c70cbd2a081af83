"""Tags in sight that span no area."""
from __future__ import annotations

WAIT_S = 8.0  # a hint is given when it has been true for this time
GONE_S = 1.0  # and withdrawn after this time


class Shortfall:
    """Watches whether the tags in sight span no area. ``hint``: a sentence that says why, or None."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the frames before."""
        self.hint: str | None = None
        self._since = self._last = float('-inf')

    def update(self, stamp: float, sentence: str | None, has_area: bool) -> None:
        """Take in a frame at a time, seconds. ``sentence``: why its tags span no area; None without tags."""
        if has_area or not 0 <= stamp - self._last <= GONE_S:
            self.reset()
            self._since = stamp
        if sentence is not None:
            self._last = stamp
            self.hint = sentence if stamp - self._since >= WAIT_S else None
