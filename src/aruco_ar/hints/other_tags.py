"""Tags in sight that nobody looks for: of another dictionary, or with other ids."""
from __future__ import annotations

from typing import Iterable, Sequence

import cv2

from aruco_ar.base.arrays import Image
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import DICTIONARIES, DICTIONARY_NAMES, get_dictionary

WAIT_S = 2.0     # no tag must be in sight for this time before others are looked for
LOOK_S = 0.25    # time between two searches; each is for the tags of one family of dictionaries
ENOUGH = 2       # number of different tags that must be found, since some dictionaries find one in anything
LOOKS = 3        # number of searches in a row that must find them
LARGE_PX = 1000  # frames with longer sides are halved
FORGET_S = 10.0  # a hint that is not confirmed for this time is withdrawn


class OtherTags:
    """Looks for other tags, seldom and cheaply, while no wanted tag is in sight.

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
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self.hint: str | None = None
        self._next, self._hits = 0, 0
        self._seen: frozenset[int] = frozenset()
        self._since: float | None = None  # time when a wanted tag was last seen, or of the first frame
        self._looked = self._hinted = 0.0

    def update(self, frame: Image, stamp: float, found_wanted: bool) -> None:
        """Take in a frame, (h, w, 3) BGR uint8, with its time, seconds.

        ``found_wanted``: whether any wanted tag is in sight.
        """
        if found_wanted or self._since is None or stamp < self._since:
            self.reset()
            self._since = stamp
        if stamp - self._since < WAIT_S or 0 <= stamp - self._looked < LOOK_S:
            return
        self._looked = stamp
        family = self._families[self._next]
        ids = self._detect(frame, family[-1])
        again = ids & self._seen if self._hits else ids
        if len(again) >= ENOUGH:
            self._seen, self._hits = again, self._hits + 1
            if self._hits >= LOOKS:
                self.hint, self._hinted = self._sentence(family, sorted(ids)), stamp
                self._hits = LOOKS - 1  # the next look confirms it
            return
        self._hits, self._seen = 0, frozenset()
        self._next = (self._next + 1) % len(self._families)
        if stamp - self._hinted > FORGET_S:
            self.hint = None

    def _detect(self, frame: Image, dictionary: str) -> frozenset[int]:
        """The ids that are in sight exactly once."""
        if max(frame.shape[:2]) > LARGE_PX:
            frame = cv2.resize(frame, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        if dictionary not in self._detectors:
            self._detectors[dictionary] = Detector(dictionary, correction=0.5)
        ids = [tag.id for tag in self._detectors[dictionary].detect(frame)]
        return frozenset(tag_id for tag_id in ids if ids.count(tag_id) == 1)

    def _sentence(self, family: Sequence[str], ids: Sequence[int]) -> str:
        smallest = next(name for name in family if max(ids) < len(get_dictionary(name).bytesList))
        is_own = DICTIONARIES[self._dictionary] in map(DICTIONARIES.get, family) and \
            max(ids) < len(get_dictionary(self._dictionary).bytesList)
        text = '%d tags of %s (%s) are in sight, but ' % (
            len(ids), self._dictionary if is_own else smallest, ', '.join(map(str, ids[:8])))
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
