"""Tags in sight that nobody looks for: of another dictionary or border, of none, of other ids, or mirrored."""
from __future__ import annotations

from collections import Counter, deque
from functools import partial
from typing import AbstractSet, Callable, FrozenSet, Iterable, NamedTuple, Sequence, Tuple

import cv2

from aruco_ar.base.arrays import Image
from aruco_ar.tags.tag import DICTIONARIES, get_dictionary

from .searches import Searches, shrunk
from .squares import MIRRORED, PLAIN, UNKNOWN, Kind, Meanings, families, read_squares, smallest_with

WAIT_S = 2.0     # no tag must be in sight for this time before others are looked for
PAUSE_S = 0.25   # time between two searches, at least
ENOUGH = 2       # number of different tags that must be found, since some dictionaries find one in anything;
                 # FOUR, if they are of another dictionary and also mirrored or of another border
HITS, LAST = 3, 5  # each of them must be found in HITS of the LAST searches
SOONER = 0.5     # the pause between the first LAST searches, as a share of the usual one
FORGET_S = 10.0  # a hint that is not confirmed for this time is withdrawn
SURE = 10        # number of frames with wanted tags after which the dictionary and the ids are right
# Some dictionaries find a tag in anything, but rarely the same ones in the next frames; and a few tags are the
# same when they are mirrored. So wanted tags are believed if FOUR are in STEADY frames in a row, or if they
# show an area. After fewer, it takes FOUR tags of another kind, and twice as many.
STEADY, FOUR = 5, 4
# Of two kinds with as many tags, the latter. Some tags of any kind are also tags of a dictionary, by chance.
CERTAIN = PLAIN, MIRRORED, UNKNOWN

USUAL_BORDER, WIDE_BORDER = 1, 2  # cells
MIRRORED_TAGS = ('%s are mirrored in the image, so they cannot be read. If the camera or its driver mirrors or '
                 'flips the image, turn off this mirroring.')
OTHER_BORDER = '%s have a black border %s wide, but %s looks for one %s wide. %s.'
PRINT_OTHERS = 'Print other tags: rosrun unit5 artag_generator.py'
UNKNOWN_TAGS = ('%d square tags in sight are of no dictionary that %s knows, so it cannot read them. '
                "They may be AprilTag's newer ones, such as tagStandard41h12. %s.")

Found = FrozenSet[Tuple[Kind, int]]  # tags


class Words(NamedTuple):
    """How a hint names who looks for tags, and the options that help, with a place for the value.

    ``border``: None if there is no such option.
    """

    seeker: str = 'the node'
    dictionary: str = 'dictionary:=%s'
    border: str | None = 'border:=%d'


OF_NODES = Words()


class OtherTags:
    """Looks for other tags, seldom and cheaply, until wanted tags have been in sight.

    ``hint``: a sentence about the tags that are in sight, with what to do; None without such tags.
    ``has_looked``: whether other tags have been looked for, or need not be.
    """

    def __init__(self, dictionary: str, ids: Iterable[int], border: float = USUAL_BORDER,
                 words: Words = OF_NODES) -> None:
        """The arguments, but for the ``words`` of the hint, are those of the Detector for the wanted tags."""
        self._words = words
        self._dictionary, self._ids, self._border = dictionary, tuple(ids), int(border)
        self._count = len(get_dictionary(dictionary).bytesList)
        self._family = next(family for family in families()
                            if DICTIONARIES[dictionary] in map(DICTIONARIES.get, family))
        self._borders = sorted({self._border, USUAL_BORDER, WIDE_BORDER})
        self._searches: Searches[tuple[Kind, int]] = Searches(PAUSE_S)
        self._wanted_frames = 0
        self.reset()

    def reset(self) -> None:
        """Forget the other tags that were seen, but not that wanted ones were."""
        self.hint: str | None = None
        self._hinted = 0.0  # when the hint was last confirmed
        self._kind: Kind | None = None  # which it is about
        self._last: deque[Found] = deque(maxlen=LAST)
        self._since: float | None = None  # time when wanted tags were last seen, or of the first frame
        self._streaks: dict[int, int] = {}  # for each wanted id, in how many frames in a row it is
        # When wanted tags were last found that may be false, and how many others then count.
        self._doubtful, self._least = float('-inf'), FOUR
        self.has_looked = self._wanted_frames >= SURE
        self._searches.reset()

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
        self._doubt(seen, stamp)
        self._wanted_frames += found_wanted
        if self._wanted_frames >= SURE:  # other tags in sight now hang on another wall
            self.has_looked = True
            return None
        found = self._searches.take()
        if found is not None:
            self._judge(found, stamp)
        if stamp - self._since < WAIT_S or not self._searches.is_due(stamp, self._sooner):
            return None
        return self._searches.start(stamp, partial(self._find, frame))

    def may_search(self, stamp: float) -> bool:
        """Whether ``update`` may return a search of a frame at that time, seconds."""
        return (self._since is not None and stamp - self._since >= WAIT_S and self._wanted_frames < SURE
                and self._searches.may_be_due(stamp, self._sooner))

    @property
    def _sooner(self) -> float:
        return SOONER if len(self._last) < LAST else 1.0

    def look_at(self, frame: Image) -> None:
        """Search a frame, (h, w, 3) BGR uint8, such as a photo that has no time; in place of ``update``.

        It takes a while. After HITS frames, there may be a hint.
        """
        found = self._find(frame)
        self._doubt({tag_id for kind, tag_id in found if kind == (PLAIN, self._border, self._family)}, 0.0)
        self._judge(found, 0.0)

    def _doubt(self, seen: AbstractSet[int], stamp: float) -> None:
        """Take in the ids of the wanted tags in a frame, which may be false."""
        if seen:
            self._doubtful, self._least = stamp, max(FOUR, 2 * len(seen))

    def _find(self, frame: Image) -> Found:
        """The tags that are in sight exactly once."""
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        squares = read_squares(shrunk(gray)[0], self._borders)
        times = Counter(tag for meanings in self._in_one_way(squares) for tag in meanings.items())
        return frozenset(tag for tag, count in times.items() if count == 1)

    def _in_one_way(self, squares: Sequence[Meanings]) -> Sequence[Meanings]:
        """The squares, none of which is both a tag of a dictionary and a mirrored one of the same.

        A frame is mirrored or it is not. So all tags are seen in the way in which more wanted ones can be seen,
        or more tags at all. Those of DICT_ARUCO_ORIGINAL are others when they are mirrored: only ids can tell.
        """
        tags = [tag for meanings in squares for tag in meanings.items()]
        times = Counter(kind for kind, _ in tags)
        wanted = Counter(kind for kind, tag_id in tags if kind.family == self._family and tag_id in self._ids)

        def is_kept(kind: Kind, meanings: Meanings) -> bool:
            other = kind._replace(way=MIRRORED if kind.way == PLAIN else PLAIN)
            more = wanted[kind] - wanted[other]
            if abs(more) < ENOUGH:
                more = times[kind] - times[other]
            return other not in meanings or more > 0 or (more == 0 and kind.way == PLAIN)
        return [{kind: tag_id for kind, tag_id in meanings.items() if is_kept(kind, meanings)}
                for meanings in squares]

    def _judge(self, found: Found, stamp: float) -> None:
        """Draw conclusions from the tags that were found."""
        self._last.append(found)
        self.has_looked |= len(self._last) >= HITS
        steady: dict[Kind, set[int]] = {}
        for (kind, tag_id), count in Counter(tag for tags in self._last for tag in tags).items():
            if count >= HITS:
                steady.setdefault(kind, set()).add(tag_id)
        kinds = [kind for kind, ids in steady.items() if len(ids) >= self._needed(kind, stamp)]
        if kinds:
            kind = max(kinds, key=lambda each: (len(steady[each]), CERTAIN.index(each.way)))
            self._hinted = stamp
            if kind != self._kind:  # later searches only confirm it, so that the sentence stays the same
                self._kind, self.hint = kind, self._sentence(kind, steady[kind])
        elif stamp - self._hinted > FORGET_S:
            self._kind = self.hint = None

    def _needed(self, kind: Kind, stamp: float) -> int:
        """The number of tags of a kind that it takes."""
        is_usual = kind.way == UNKNOWN or kind.family == self._family or kind[:2] == (PLAIN, self._border)
        return max(ENOUGH if is_usual else FOUR, self._least if stamp - self._doubtful < FORGET_S else 0)

    def _sentence(self, kind: Kind, ids: AbstractSet[int]) -> str | None:
        if kind.way == UNKNOWN:
            return UNKNOWN_TAGS % (len(ids), self._words.seeker, PRINT_OTHERS)
        smallest = smallest_with(kind.family, max(ids))
        is_family = kind.family == self._family
        is_own = is_family and max(ids) < self._count
        tags = '%d tags of %s (%s)' % (len(ids), self._dictionary if is_own else smallest,
                                       ', '.join(map(str, sorted(ids)[:8])))
        if kind.way == MIRRORED:
            return MIRRORED_TAGS % tags
        if kind.border != self._border:
            remedy = 'Give ' + self._words.border % kind.border if self._words.border else PRINT_OTHERS
            return OTHER_BORDER % (tags, _cells(kind.border), self._words.seeker, _cells(self._border), remedy)
        if is_family and not ids.isdisjoint(self._ids or range(self._count)):
            return None  # the node looks for these, but its own search misses them: see MissedTags
        if is_own:
            wanted = ','.join(map(str, self._ids))
            return '%s are in sight, but none of ids:=%s. Give the ids of four of them, or ids:=any.' % (
                tags, wanted)
        return '%s are in sight, but %s looks for tags of %s. Give %s.' % (
            tags, self._words.seeker, self._dictionary, self._words.dictionary % smallest)


def _cells(count: int) -> str:
    return '1 cell' if count == 1 else '%d cells' % count
