"""Tags in sight that only the most thorough search finds."""
from __future__ import annotations

from typing import AbstractSet, Iterable

from aruco_ar.base.arrays import Image
from aruco_ar.tags.detector import Detector

WAIT_S = 3.0    # less than four tags must be in sight for this time before others are looked for
LOOK_S = 2.0    # time between two searches, since such a search takes long
LOOKS = 3       # number of searches in a row that must find the same tags
FOUR = 4        # with this number of tags in sight, no others are looked for
THOROUGH = 'thorough'


class MissedTags:
    """Looks for more tags, seldom, while less than four are in sight and no area is known.

    ``hint``: a sentence about them with what to do; None without such tags.
    """

    def __init__(self, dictionary: str, ids: Iterable[int], search: str) -> None:
        """``dictionary``, ``ids``, ``search``: those of the Detector that misses them."""
        self._detector = None if search == THOROUGH else Detector(dictionary, ids, THOROUGH)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self.hint: str | None = None
        self._since: float | None = None  # when four tags or an area were last in sight, or at first
        self._looked, self._hits = 0.0, 0
        self._missed: frozenset[int] = frozenset()

    def update(self, frame: Image, stamp: float, seen: AbstractSet[int], has_area: bool) -> None:
        """Take in a frame, (h, w, 3) BGR uint8, with its time, seconds. ``seen``: the ids of the tags in it."""
        if self._detector is None:
            return
        if has_area or len(seen) >= FOUR or self._since is None or stamp < self._since:
            self.reset()
            self._since = stamp
        if stamp - self._since < WAIT_S or 0 <= stamp - self._looked < LOOK_S:
            return
        self._looked = stamp
        missed = frozenset(tag.id for tag in self._detector.detect(frame)) - seen
        again = missed & self._missed if self._hits else missed
        self._missed, self._hits = (again, self._hits + 1) if again else (missed, int(bool(missed)))
        self.hint = None
        if self._hits >= LOOKS:
            self.hint = '%d tags are hard to see: %s. Look harder for them: search:=%s.' % (
                len(again), ', '.join(map(str, sorted(again)[:8])), THOROUGH)
