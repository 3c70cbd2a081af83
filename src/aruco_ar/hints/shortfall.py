"""Tags in sight that span no area."""
from __future__ import annotations

from .lasting import Lasting

WAIT_S = 8.0  # a hint is given when it has been true for this time
GONE_S = 1.0  # and withdrawn after this time


class Shortfall:
    """Watches whether the tags in sight span no area. ``hint``: a sentence that says why, or None."""

    def __init__(self) -> None:
        self._lasting: Lasting[str, str] = Lasting(WAIT_S, GONE_S)
        self.reset()

    def reset(self) -> None:
        """Forget the frames before."""
        self.hint: str | None = None
        self._lasting.reset()

    def update(self, stamp: float, sentence: str | None, has_area: bool) -> None:
        """Take in a frame at a time, seconds. ``sentence``: why its tags span no area; None without tags."""
        if has_area:
            self.reset()
        lasting = self._lasting.update(stamp, {} if sentence is None else {'': sentence})
        if sentence is not None or not lasting:  # a hint does not begin with a frame without tags
            self.hint = lasting.get('')
