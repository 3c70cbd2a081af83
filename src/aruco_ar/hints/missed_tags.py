"""Tags in sight that only the most thorough search finds."""
from __future__ import annotations

from functools import partial
from typing import AbstractSet, Any, Callable, Mapping

from aruco_ar.base.arrays import Image
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.edges import side_of

from .searches import Found, Searches, shrunk

WAIT_S = 3.0    # less than four tags must be in sight for this time before others are looked for
PAUSE_S = 2.0   # time between two searches, at least
HITS = 3        # number of searches in a row that must find the same tags
FOUR = 4        # with this number of tags in sight, no others are looked for
# After this number of searches in vain, the next ones are rarer. They go on, since the wall may come later.
TRIES, RARER = 10, 10.0
THOROUGH = 'thorough'


class MissedTags:
    """Looks for more tags, seldom, while less than four are in sight and no area is known.

    ``hint``: a sentence about them with what to do; None without such tags.
    """

    def __init__(self, detection: Mapping[str, Any]) -> None:
        """``detection``: the arguments of the Detector that misses them."""
        self._min_side = detection.get('min_side', 0)  # in the whole frame
        self._detector = None if detection.get('search') == THOROUGH else \
            Detector(**{**detection, 'search': THOROUGH, 'min_side': 0})
        self._searches: Searches[int] = Searches(PAUSE_S)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self.hint: str | None = None
        self._since: float | None = None  # when four tags or an area were last in sight, or at first
        self._hits = self._tries = 0
        self._missed: Found = frozenset()
        self._searches.reset()

    def update(self, frame: Image, stamp: float, seen: AbstractSet[int],
               has_area: bool) -> Callable[[], None] | None:
        """Take in a frame, (h, w, 3) BGR uint8, with its time, seconds. ``seen``: the ids of the tags in it.

        Returns None or, if it is time to search this frame, a function that does so. That takes up to some
        seconds; it may be called in another thread. A later frame brings the hint.
        """
        if self._detector is None:
            return None
        if has_area or len(seen) >= FOUR or self._since is None:
            self.reset()
            self._since = stamp
        missed = self._searches.take()
        if missed is not None:
            self._judge(missed)
        if stamp - self._since < WAIT_S or not self._searches.is_due(stamp, self._rarer):
            return None
        return self._searches.start(stamp, partial(self._find, self._detector, frame, frozenset(seen)))

    def may_search(self, stamp: float) -> bool:
        """Whether ``update`` may return a search of a frame at that time, seconds."""
        return (self._detector is not None and self._since is not None and stamp - self._since >= WAIT_S
                and self._searches.may_be_due(stamp, self._rarer))

    @property
    def _rarer(self) -> float:
        return RARER if self._tries >= TRIES else 1.0

    def _find(self, detector: Detector, frame: Image, seen: Found) -> Found:
        small, scale = shrunk(frame)
        return frozenset(tag.id for tag in detector.detect(small)
                         if side_of(tag.corners[None])[0] >= self._min_side * scale) - seen

    def _judge(self, missed: Found) -> None:
        again = missed & self._missed if self._hits else missed
        self._missed, self._hits = (again, self._hits + 1) if again else (missed, int(bool(missed)))
        self._tries = 0 if missed else self._tries + 1
        self.hint = None
        if self._hits >= HITS:
            tags, them = ('1 tag is', 'it') if len(again) == 1 else ('%d tags are' % len(again), 'them')
            self.hint = '%s hard to see: %s. Look harder for %s: search:=%s.' % (
                tags, ', '.join(map(str, sorted(again)[:8])), them, THOROUGH)
