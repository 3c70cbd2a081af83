"""Tags in sight that nobody looks for: of another dictionary, or with other ids."""
from __future__ import annotations

from functools import partial
from typing import Callable, Iterable, Sequence

from aruco_ar.base.arrays import Image
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import DICTIONARIES, DICTIONARY_NAMES, get_dictionary

from .searches import Found, Searches, shrunk

WAIT_S = 2.0     # no tag must be in sight for this time before others are looked for
PAUSE_S = 0.25   # time between two searches, at least; each is for the tags of one family of dictionaries
ENOUGH = 2       # number of different tags that must be found, since some dictionaries find one in anything
HITS = 3         # number of searches in a row that must find them
FORGET_S = 10.0  # a hint that is not confirmed for this time is withdrawn
SURE = 10        # number of frames with wanted tags after which the dictionary and the ids are right


class OtherTags:
    """Looks for other tags, seldom and cheaply, until wanted tags have been in sight.

    ``hint``: a sentence about the tags that are in sight, with what to do; None without such tags.
    """

    def __init__(self, dictionary: str, ids: Iterable[int]) -> None:
        """``dictionary``, ``ids``: those of the Detector for the tags that are wanted."""
        self._dictionary, self._ids = dictionary, tuple(ids)
        families = _families()
        own = [family for family in families if DICTIONARIES[dictionary] in map(DICTIONARIES.get, family)]
        self._families = own + [family for family in families if family not in own]
        if not self._ids:
            self._families = self._families[len(own):] + own  # a larger dictionary of the family may have them
        self._detectors: dict[str, Detector] = {}
        self._searches = Searches(PAUSE_S)
        self._wanted_frames = 0
        self.reset()

    def reset(self) -> None:
        """Forget the other tags that were seen, but not that wanted ones were."""
        self.hint: str | None = None
        self._next, self._hits = 0, 0
        self._seen: Found = frozenset()
        self._since: float | None = None  # time when a wanted tag was last seen, or of the first frame
        self._hinted = 0.0
        self._searches.begin_anew()

    def update(self, frame: Image, stamp: float, found_wanted: bool) -> Callable[[], None] | None:
        """Take in a frame, (h, w, 3) BGR uint8, with its time, seconds.

        ``found_wanted``: whether any wanted tag is in sight. Returns None or, if it is time to search this
        frame, a function that does so; it may be called in another thread. A later frame brings the hint.
        """
        if found_wanted or self._since is None or stamp < self._since:
            self.reset()
            self._since = stamp
        self._wanted_frames += found_wanted
        if self._wanted_frames >= SURE:  # other tags in sight now hang on another wall
            return None
        found = self._searches.take()
        if found is not None:
            self._judge(found, stamp)
        if stamp - self._since < WAIT_S or not self._searches.is_due(stamp):
            return None
        return self._searches.start(stamp, partial(self._find, frame, self._families[self._next][-1]))

    def may_search(self, stamp: float) -> bool:
        """Whether ``update`` may return a search of a frame at that time, seconds."""
        return (self._since is not None and stamp - self._since >= WAIT_S and self._wanted_frames < SURE
                and self._searches.may_be_due(stamp))

    def _find(self, frame: Image, dictionary: str) -> Found:
        """The ids that are in sight exactly once."""
        if dictionary not in self._detectors:
            self._detectors[dictionary] = Detector(dictionary, correction=0.5)
        ids = [tag.id for tag in self._detectors[dictionary].detect(shrunk(frame)[0])]
        return frozenset(tag_id for tag_id in ids if ids.count(tag_id) == 1)

    def _judge(self, ids: Found, stamp: float) -> None:
        """Draw conclusions from the ids of the family of dictionaries that was searched for."""
        again = ids & self._seen if self._hits else ids
        if len(again) >= ENOUGH:
            self._seen, self._hits = again, self._hits + 1
            if self._hits >= HITS:
                self.hint, self._hinted = self._sentence(self._families[self._next], again), stamp
                self._hits = HITS - 1  # the next search confirms it
            return
        self._hits, self._seen = 0, frozenset()
        self._next = (self._next + 1) % len(self._families)
        if stamp - self._hinted > FORGET_S:
            self.hint = None

    def _sentence(self, family: Sequence[str], ids: Found) -> str | None:
        smallest = next(name for name in family if max(ids) < len(get_dictionary(name).bytesList))
        count = len(get_dictionary(self._dictionary).bytesList)
        is_family = DICTIONARIES[self._dictionary] in map(DICTIONARIES.get, family)
        if is_family and not ids.isdisjoint(self._ids or range(count)):
            return None  # the node looks for these, but its own search misses them: see MissedTags
        is_own = is_family and max(ids) < count
        text = '%d tags of %s (%s) are in sight, but ' % (
            len(ids), self._dictionary if is_own else smallest, ', '.join(map(str, sorted(ids)[:8])))
        if is_own:
            wanted = ','.join(map(str, self._ids))
            return text + 'none of ids:=%s. Give the ids of four of them, or ids:=any.' % wanted
        return text + 'the node looks for tags of %s. Give dictionary:=%s.' % (self._dictionary, smallest)


def _families() -> list[list[str]]:
    """The names of the dictionaries with the same tags, the smallest dictionary first."""
    families: dict[str, list[str]] = {}
    for name in DICTIONARY_NAMES:
        family = name.rpartition('_')[0] if name.rpartition('_')[2].isdigit() else name
        families.setdefault(family, []).append(name)
    return [sorted(names, key=lambda name: len(get_dictionary(name).bytesList)) for names in families.values()]
