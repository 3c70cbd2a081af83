"""Tags in sight that nobody looks for: of another dictionary or border, with other ids, or mirrored."""
from __future__ import annotations

from functools import partial
from typing import AbstractSet, Callable, Iterable, Sequence

import numpy as np

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
# Some dictionaries find a tag in anything, but rarely the same ones in the next frames; and a few tags are the
# same when they are mirrored. So wanted tags are believed if FOUR are in STEADY frames in a row, or if they
# show an area. After fewer, it takes FOUR tags of another kind, and twice as many.
STEADY, FOUR = 5, 4

# How the tags of a dictionary are looked for.
PLAIN, MIRRORED, BORDER = 'plain', 'mirrored', 'border'
USUAL_BORDER, WIDE_BORDER = 1, 2  # cells
SENTENCES = {
    MIRRORED: '%s are mirrored in the image, so they cannot be read. If the camera or its driver mirrors or '
              'flips the image, turn off this mirroring.',
    BORDER: '%s have a black border {0} wide, but the node looks for one {1} wide. Give border:={2}.'}


class OtherTags:
    """Looks for other tags, seldom and cheaply, until wanted tags have been in sight.

    ``hint``: a sentence about the tags that are in sight, with what to do; None without such tags.
    ``has_looked``: whether all kinds of tags have been looked for, or need not be.
    """

    def __init__(self, dictionary: str, ids: Iterable[int], border: float = USUAL_BORDER) -> None:
        """The arguments are those of the Detector for the tags that are wanted."""
        self._dictionary, self._ids, self._border = dictionary, tuple(ids), int(border)
        self._other_border = WIDE_BORDER if self._border == USUAL_BORDER else USUAL_BORDER
        families = _families()
        own = [family for family in families if DICTIONARIES[dictionary] in map(DICTIONARIES.get, family)]
        plain = [(PLAIN, family) for family in families if family not in own]
        # The wanted tags themselves first. Without ids, a larger dictionary of the family may have them.
        plain = [(PLAIN, own[0]), *plain] if self._ids else [*plain, (PLAIN, own[0])]
        self._kinds = [*((way, [dictionary]) for way in SENTENCES), *plain]
        self._detectors: dict[tuple[str, int], Detector] = {}
        self._searches = Searches(PAUSE_S)
        self.has_looked = False
        self._wanted_frames = 0
        self.reset()

    def reset(self) -> None:
        """Forget the other tags that were seen, but not that wanted ones were."""
        self.hint: str | None = None
        self._next, self._hits = 0, 0
        self._seen: Found = frozenset()
        self._since: float | None = None  # time when wanted tags were last seen, or of the first frame
        self._streaks: dict[int, int] = {}  # for each wanted id, in how many frames in a row it is
        # When wanted tags were last found that may be false, and how many others then count.
        self._doubtful, self._least = float('-inf'), FOUR
        self.has_looked = self._wanted_frames >= SURE  # whether all kinds of tags have been searched for
        self._hinted = 0.0
        self._searches.begin_anew()

    def update(self, frame: Image, stamp: float, seen: AbstractSet[int],
               has_area: bool) -> Callable[[], None] | None:
        """Take in a frame, (h, w, 3) BGR uint8, with its time, seconds.

        ``seen``: the ids of the wanted tags in it. ``has_area``: whether they show an area. Returns None or, if
        it is time to search this frame, a function that does so; it may be called in another thread. A later
        frame brings the hint.
        """
        streaks = {tag_id: self._streaks.get(tag_id, 0) + 1 for tag_id in seen}
        found_wanted = has_area or sum(streak >= STEADY for streak in streaks.values()) >= FOUR
        if found_wanted or self._since is None or stamp < self._since:
            self.reset()
            self._since = stamp
        self._streaks = streaks
        if seen:
            self._doubtful, self._least = stamp, max(FOUR, 2 * len(seen))
        self._wanted_frames += found_wanted
        if self._wanted_frames >= SURE:  # other tags in sight now hang on another wall
            self.has_looked = True
            return None
        found = self._searches.take()
        if found is not None:
            self._judge(found, stamp)
        if stamp - self._since < WAIT_S or not self._searches.is_due(stamp):
            return None
        return self._searches.start(stamp, partial(self._find, frame, *self._kinds[self._next]))

    def may_search(self, stamp: float) -> bool:
        """Whether ``update`` may return a search of a frame at that time, seconds."""
        return (self._since is not None and stamp - self._since >= WAIT_S and self._wanted_frames < SURE
                and self._searches.may_be_due(stamp))

    def _find(self, frame: Image, way: str, family: Sequence[str]) -> Found:
        """The ids that are in sight exactly once, but in one way only."""
        small, dictionary = shrunk(frame)[0], family[-1]
        ids = self._read(small, way, dictionary)
        if way != PLAIN and len(ids) >= ENOUGH and 2 * len(self._read(small, PLAIN, dictionary)) > len(ids):
            return frozenset()  # they are there as they should be
        return frozenset(tag_id for tag_id in ids if ids.count(tag_id) == 1)

    def _read(self, frame: Image, way: str, dictionary: str) -> list[int]:
        """The ids of the tags of a dictionary that are found in one way."""
        if way == MIRRORED:
            frame = np.ascontiguousarray(frame[:, ::-1])
        kind = dictionary, self._other_border if way == BORDER else self._border
        if kind not in self._detectors:
            self._detectors[kind] = Detector(dictionary, correction=0.5, border=kind[1])
        return [tag.id for tag in self._detectors[kind].detect(frame)]

    def _judge(self, ids: Found, stamp: float) -> None:
        """Draw conclusions from the ids of the kind of tags that was searched for."""
        again = ids & self._seen if self._hits else ids
        if len(again) >= (self._least if stamp - self._doubtful < FORGET_S else ENOUGH):
            self._hits += 1
            if self._hits <= HITS:  # later searches only confirm it, so that the sentence stays the same
                self._seen = again
            if self._hits >= HITS:
                self.hint, self._hinted = self._sentence(*self._kinds[self._next], self._seen), stamp
            return
        self._hits, self._seen = 0, frozenset()
        self._next = (self._next + 1) % len(self._kinds)
        self.has_looked |= self._next == 0
        if stamp - self._hinted > FORGET_S:
            self.hint = None

    def _sentence(self, way: str, family: Sequence[str], ids: Found) -> str | None:
        if way != PLAIN:
            return SENTENCES[way].format(_cells(self._other_border), _cells(self._border), self._other_border) \
                % _described(family[-1], ids)
        smallest = next(name for name in family if max(ids) < len(get_dictionary(name).bytesList))
        count = len(get_dictionary(self._dictionary).bytesList)
        is_family = DICTIONARIES[self._dictionary] in map(DICTIONARIES.get, family)
        if is_family and not ids.isdisjoint(self._ids or range(count)):
            return None  # the node looks for these, but its own search misses them: see MissedTags
        is_own = is_family and max(ids) < count
        text = _described(self._dictionary if is_own else smallest, ids) + ' are in sight, but '
        if is_own:
            wanted = ','.join(map(str, self._ids))
            return text + 'none of ids:=%s. Give the ids of four of them, or ids:=any.' % wanted
        return text + 'the node looks for tags of %s. Give dictionary:=%s.' % (self._dictionary, smallest)


def _described(dictionary: str, ids: Found) -> str:
    return '%d tags of %s (%s)' % (len(ids), dictionary, ', '.join(map(str, sorted(ids)[:8])))


def _cells(count: int) -> str:
    return '1 cell' if count == 1 else '%d cells' % count


def _families() -> list[list[str]]:
    """The names of the dictionaries with the same tags, the smallest dictionary first."""
    families: dict[str, list[str]] = {}
    for name in DICTIONARY_NAMES:
        family = name.rpartition('_')[0] if name.rpartition('_')[2].isdigit() else name
        families.setdefault(family, []).append(name)
    return [sorted(names, key=lambda name: len(get_dictionary(name).bytesList)) for names in families.values()]
