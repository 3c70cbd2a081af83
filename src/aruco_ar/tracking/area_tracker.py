"""Tracking an area, which stays on the wall while tags come and go."""
from __future__ import annotations

from dataclasses import dataclass
from math import dist
from typing import Iterable, Mapping, NamedTuple, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.homography import UNIT_SQUARE, transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.ordering import is_quadrilateral, order_coordinates
from aruco_ar.settings.settings import UPRIGHT, ids_as_text
from aruco_ar.tags.tag import Tag
from aruco_ar.walls.remembered import RememberedWall

from .area import Area
from .covered_tags import short_tags
from .features import Views
from .frame_clock import FrameClock
from .layout import EXACT, FurtherTags, Layout, NewLayout, tolerance_of
from .learned_wall import LearnedWall
from .measurement import consistent_tags, measurement
from .motion import AreaMotion
from .no_area import NEVER_SEEN, why_no_area
from .sharpness import Sharpness
from .sight import SeenArea
from .strays import Strays
from .tag_search import ANY_SIDE, FrameSearch, expected_places, found_tags
from .texture import Texture
from .wall_search import WallSearch

# The whole frame is searched at intervals of SEARCH_S: for new tags, for those that were moved, and to make the
# places of known ones more exact. While all four are in sight, and there is nothing to learn, each search makes
# the interval longer by as much, up to CALM times.
SEARCH_S, CALM = 0.45, 4
LATE_S = 0.1           # in a frame that was searched, the wall is not studied yet, unless it is late by this
GAP_S = 0.5            # frames that are farther apart say nothing about the motion
# A measurement that is more unlikely than this (see AreaMotion.unlikeliness) is not explained by
# errors. If it is more unlikely than the second limit, a jerk of the camera does not explain it either.
UNLIKELY, UNLIKELY_AFTER_JERK = 9.0, 2.0
# The next three limits are relative to the area's longer side. The time of ``hold`` starts after the last
# frame in which the deviation of the corners was below this limit.
MAX_DEVIATION = 0.029
# The time of ``hold`` ends early if the deviation exceeds the first of these limits while the corners may have
# moved by the second.
MAX_HELD_DEVIATION, MAX_HELD_MOVE = 0.03, 0.045
ROUNDING_S = 1e-6      # largest rounding error of the difference of two stamps
# The wall's look is asked where the area is if motion has blurred a tag, if fewer than ENOUGH_TAGS are in their
# places, if one of the four is not and a corner's deviation was above OPEN_PX, or if tags contradict what is
# expected.
ENOUGH_TAGS, OPEN_PX = 3, 0.3
# While so many are in their places, one of the four that stays missing is looked for near its own only after as
# long as it has been missing, or after LOOK_S. In its place, it is found in any frame.
LOOK_S = 0.2
REFIT_PX = 1.0         # if it shows a tag this far from its expected place, the tags are looked for anew


class Lost(NamedTuple):
    """Since when a tag has been missing, and when it is to be looked for near its place again; seconds."""

    since: float
    due: float


@dataclass(frozen=True)
class Nearby:
    """What an AreaTracker finds in a frame before the whole frame is searched.

    ``tags``: {id: Tag}, those in their expected places. ``others``: those found
    near their places. ``expected``: {id: (4, 2)}, the places of all known tags.
    ``lost``: {id: Lost}, those of the four that were not found. ``smallest``: how
    small the tags are that the whole frame should be searched for: pixels, or
    ANY_SIDE. It is None if the frame need not be searched.
    """

    tags: Mapping[int, Tag]
    others: Sequence[Tag]
    expected: Mapping[int, Floats]
    lost: Mapping[int, Lost]
    smallest: float | None


class AreaTracker:
    """Tracks one area through a sequence of frames; see Tracker, which is one that also searches the frames.

    ``ids``: those of the area's tags, or none for any. ``upright``: see Tracker. ``wall``: the RememberedWall
    that is known from the first frame on, or None. ``in_thread``: see WallSearch. Raises InputError.
    """

    def __init__(self, ids: Iterable[int] = (), upright: str = 'tags', wall: RememberedWall | None = None,
                 in_thread: bool = False) -> None:
        if upright not in UPRIGHT:
            raise InputError('The value "%s" of upright is unknown; choose one of %s.'
                             % (upright, ', '.join(UPRIGHT)))
        self._ids, self._upright = frozenset(ids), upright
        self._wall, self._in_thread = wall, in_thread
        if wall is not None and self._ids not in (frozenset(), frozenset(wall.ids)):
            raise InputError('The remembered wall has its area between the tags %s, not between %s. Give these '
                             'ids, or none.' % (ids_as_text(wall.ids), ids_as_text(tuple(sorted(self._ids)))))
        if wall is not None and wall.look is not None:
            Texture.remembered(wall.look, None)  # raises if it does not fit
        self._frame: Image | None = None  # while it is looked at
        self.reset()

    @property
    def tags(self) -> list[Tag]:
        """A list of Tag: those with the ids that count, found in the last frame."""
        return found_tags([tag for tag in self._seen.values() if self._counts(tag.id)], self._lens)

    @property
    def repeated(self) -> list[Tag]:
        """A list of Tag: more tags with the ids of others, while nothing is known yet of where the area is."""
        if self._layout is not None:
            return []
        return found_tags([tag for tag in self._repeated if self._counts(tag.id)], self._lens)

    @property
    def shortfall(self) -> str | None:
        """Until an area is known: why the tags of the last frame span none; None without tags."""
        if self._layout is not None:
            return None
        return why_no_area(self._ids, self._seen, [tag.id for tag in self._repeated])

    @property
    def explanation(self) -> str:
        """A sentence that says how the area of the last frame is known, or why there is none."""
        if self._layout is None:
            return self.shortfall or NEVER_SEEN
        if self._displaced:
            return 'Tags are not where they were.'
        if self._tags_agreed_at == self._clock.now:
            return 'Its tags show it.' if self._shown else 'Its tags in sight do not show it well enough.'
        if self._recognized:
            return "The wall's texture shows it."
        if self._shown:
            return 'It is held in its predicted place, since nothing shows it at the moment.'
        return "Neither its tags nor the wall's texture show where it is."

    @property
    def located(self) -> bool:
        """Whether tags or the wall's texture showed in the last frame where the area is."""
        return self._located_at == self._clock.now

    @property
    def deviation(self) -> Floats | None:
        """(4,) pixels: the standard deviation of each corner of the area in the last frame, or None.

        The corners are those of the area with ``upright`` at ``tags``. They are rarely off by more than three
        times this.
        """
        return None if self._motion is None else self._motion.deviation

    def reset(self) -> None:
        """Forget everything seen so far."""
        self._clock = FrameClock()
        self._lens: Lens | None = None
        self._shape: tuple[int, ...] = ()  # that of the last frame
        self._shown = False                # whether the last frame had an area
        self._repeated: list[Tag] = []     # see repeated
        self._layout: Layout | None = None
        self._start([])

    def find_nearby(self, search: FrameSearch, stamp: float, hold: float) -> Nearby:
        """Begin a frame: predict where the area is, and look for tags there.

        ``stamp``: the frame's time, seconds. ``hold``: see Tracker. All is forgotten if the time goes back,
        or if the frame's size or lens changes.
        """
        shape = search.frame.shape[:2]
        if self._clock.goes_back(stamp) or self._shape not in ((), shape) or search.lens is not self._lens:
            self.reset()
            search.reset()
        passed = self._clock.advance(stamp)
        self._shape, self._lens = shape, search.lens
        if self._layout is None and self._wall is not None:
            self._recall(self._wall)
        if self._layout is None:
            return Nearby({}, [], {}, {}, ANY_SIDE)
        self._predict(passed, hold)
        self._frame = search.frame
        self._recognized = self._motion is None and self._find_wall(search.frame)
        expected = expected_places(self._layout, self._motion)
        seen, missing = search.fit_expected(self._layout, expected)
        if not self._recognized and self._needs_look(self._layout, seen) and self._use_look(seen):
            before, expected = expected, expected_places(self._layout, self._motion)
            if max(np.abs(expected[tag_id] - before[tag_id]).max() for tag_id in self._layout.ids) > REFIT_PX:
                seen, missing = search.fit_expected(self._layout, expected)
        # While the wall's look is recognized, a tag is looked for beside its place only when it was just lost.
        now, is_located = self._clock.now, len(seen) >= ENOUGH_TAGS
        looked_for = [tag_id for tag_id in missing if tag_id not in self._lost or not (
            self._recognized or (is_located and now < self._lost[tag_id].due))]
        others = search.find_near({tag_id: expected[tag_id] for tag_id in looked_for})
        lost = dict(self._lost)
        for tag_id in looked_for:
            since = lost[tag_id].since if tag_id in lost else now
            lost[tag_id] = Lost(since, now + min(now - since, LOOK_S))
        found = {tag.id for tag in others}
        lost = {tag_id: lost[tag_id] for tag_id in missing if tag_id not in found}
        # The whole frame is searched at times, for new tags, displaced tags and another wall. A lost tag
        # may be displaced.
        if search.is_done or not {*seen, *found} >= set(self._layout.ids):
            self._calm = 1
        interval = SEARCH_S * self._calm
        is_due = (now - self._searched_at >= interval
                  or bool(self._displaced or lost.keys() - self._lost.keys())
                  or not (seen or others or self._recognized))
        return Nearby(seen, others, expected, lost, search.smallest_side(
            [expected[tag_id] for tag_id in self._layout.ids if expected]) if is_due else None)

    def locate(self, search: FrameSearch, nearby: Nearby, found: Sequence[Tag], hold: float) -> SeenArea:
        """Finish a frame. ``found``: the tags in the whole frame, if ``nearby`` asks for them."""
        before = self._layout
        if self._layout is None:
            self._start(*self._without_covers(found, search))
        else:
            self._use_tags(self._layout, nearby, found, search)
        if self._layout is not None and self._motion is not None and not self._displaced:
            self._learn_look(search.frame, self._layout, self._motion, self._layout is not before)
        self._frame = None
        area = self._area(hold)
        self._shown = area is not None
        self._deviation = np.inf if self._motion is None else float(self._motion.deviation.max())
        return SeenArea(area, tuple(self.tags), tuple(self.repeated), self.located, self.explanation,
                        self.shortfall)

    def learned(self) -> LearnedWall:
        """What was learned of the wall so far. Raises InputError if that is not enough to know it again."""
        if self._displaced:
            raise InputError('Tags are not where they were. Wait until the area is back, and save the wall '
                             'then.')
        places = {} if self._layout is None else self._layout.measured_places()
        if self._layout is None or not places.keys() >= set(self._layout.ids):
            of_tags = ' of the tags %s' % ids_as_text(tuple(sorted(self._ids))) if self._ids else ''
            raise InputError('The wall%s is not known yet. Show all four tags, sharp, for some seconds.'
                             % of_tags)
        return LearnedWall(tuple(self._layout.ids), places, self._texture.look, self._views.copy())

    def shows_area(self, tags: Sequence[Tag]) -> bool:
        """Whether these tags, with undistorted corners, span the area."""
        return self._layout_of(tags) is not None

    def _start(self, tags: Sequence[Tag], is_covered: bool = False) -> None:
        """Start anew, with the area that these tags span, if they span one.

        ``is_covered``: whether something covers a side of one of them.
        """
        self._seen = {tag.id: tag for tag in tags}
        self._repeated = [tag for tag in tags if self._seen[tag.id] is not tag]
        self._texture, self._views = Texture(self._lens), Views()
        self._wall_search: WallSearch | None = None  # for a wall that is remembered
        self._recognized = False  # whether the last frame showed the wall's look
        self._sharpness = Sharpness()
        self._is_sharp = False    # whether all four tags agreed in the last frame, and were sharp
        self._agreed: list[int] = []  # the tags that agreed in the last frame
        self._layout = self._layout_of(tags)
        self._motion: AreaMotion | None = None
        self._strays = Strays()
        self._deviation = np.inf  # of the corners in the last frame, pixels
        self._displaced: set[int] = set()  # the tags last seen elsewhere than in their places
        self._lost: Mapping[int, Lost] = {}  # those of the four that were not found in the last frame
        self._further, self._new_layout = FurtherTags(), NewLayout()
        self._calm = 1            # see CALM
        # The last times of four events: the whole frame was searched, tags or texture located the area, tags
        # located it, and it was located well enough.
        self._searched_at = self._located_at = self._tags_agreed_at = self._certain_at = -np.inf
        if self._layout is not None:
            self._searched_at = self._clock.now
            self._take_in(self._layout, self._seen)
            self._is_sharp = (not is_covered and self._sharpness.take_in(
                self._seen[tag_id] for tag_id in self._layout.ids))

    def _recall(self, wall: RememberedWall) -> None:
        """Begin with what is remembered of a wall."""
        self._layout, self._views = Layout(wall.ids, wall.places, EXACT), Views(wall.features)
        self._texture = Texture(self._lens)
        if wall.look is not None:
            self._texture = Texture.remembered(wall.look, self._lens)
            self._wall_search = WallSearch(wall.features, self._in_thread)

    def _find_wall(self, frame: Image) -> bool:
        """Find a remembered wall without tags, and start the motion there. Returns whether it was found."""
        if self._wall_search is None or self._displaced:
            return False
        corners = self._wall_search.find(frame, self._lens, self._clock.now)
        # Features may deceive, so the look is compared as closely as if the wall could be anywhere.
        found = None if corners is None else self._texture.find(frame, corners, np.inf, True)
        if found is None:
            return False
        homography = np.asarray(cv2.findHomography(*found[:2])[0], np.float64)
        self._motion = AreaMotion(transform(homography, UNIT_SQUARE), self._shape[::-1], *found)
        self._located_at, self._certain_at = self._clock.now, -np.inf
        return True

    def _counts(self, tag_id: int) -> bool:
        return not self._ids or tag_id in self._ids

    def _layout_of(self, tags: Sequence[Tag]) -> Layout | None:
        """The Layout of those tags that count, or None. If possible, the picture's top stays where it was."""
        first = None if self._layout is None else self._layout.ids[0]
        return Layout.from_tags([tag for tag in tags if self._counts(tag.id)], first)

    def _predict(self, passed: float, hold: float) -> None:
        """Predict the motion after that time, seconds; forget it if that is too long."""
        if self._motion is not None:
            unseen = self._clock.now - self._located_at
            if passed > GAP_S or unseen > max(GAP_S, hold):
                self._motion = None
            else:
                self._motion.predict(passed, calm=unseen > passed)

    def _use_tags(self, layout: Layout, nearby: Nearby, found: Sequence[Tag], search: FrameSearch) -> None:
        """Correct the motion by the tags of a frame. ``found``: see locate."""
        has_searched = nearby.smallest is not None
        if has_searched:
            self._searched_at = self._clock.now
        ids = {tag.id for tag in found}
        self._lost = {tag_id: lost for tag_id, lost in nearby.lost.items() if tag_id not in ids}
        tags = [*found, *(tag for tag in nearby.others if tag.id not in ids)]
        seen = dict(nearby.tags)
        # Of several tags with one id, the one nearest to its place counts.
        expected = nearby.expected
        for tag in sorted(tags, key=lambda tag: np.abs(tag.corners - expected.get(tag.id, np.inf)).max()):
            seen.setdefault(tag.id, tag)
        known, covered = self._completed(layout, {tag_id: tag for tag_id, tag in seen.items()
                                                  if tag_id in layout.places}, expected, search)
        self._seen = seen = {**seen, **known}
        agreed, moved_on = self._take_in(layout, known)
        has_all = set(agreed) >= set(layout.ids)
        self._is_sharp = (has_all and not covered
                          and self._sharpness.take_in(seen[tag_id] for tag_id in layout.ids))
        if has_searched:
            has_learned = len(seen) == len(known) and layout.is_exact
            self._calm = min(self._calm + 1, CALM) if has_learned else 1
        if tags:
            # A few known ids may also occur on another wall.
            if not moved_on and len(seen) - len(known) > len(agreed) and self._layout_of(tags):
                self._start(*self._without_covers(tags, search))
                return
            self._note_displaced(layout, known, set(known) - set(agreed))
        if self._displaced:
            if has_searched and tags and self._new_layout.stays(tags, self._layout_of(tags), self._clock.now):
                self._start(*self._without_covers(tags, search))
        elif has_searched and self._motion is not None and len(agreed) >= 3 and (self._is_sharp or not has_all):
            self._further.learn(layout, self._motion, seen, agreed)

    def _without_covers(self, tags: Sequence[Tag], search: FrameSearch) -> tuple[list[Tag], bool]:
        """Tags of a frame that may span an area, as they are without what covers some; whether it does."""
        layout = self._layout_of(tags)
        four = [] if layout is None else search.complete([tag for tag in tags if tag.id in layout.ids])
        completed = {tag.id: tag for tag in four}
        return [completed.get(tag.id, tag) for tag in tags], bool(completed)

    def _completed(self, layout: Layout, seen: Mapping[int, Tag], expected: Mapping[int, Floats],
                   search: FrameSearch) -> tuple[dict[int, Tag], frozenset[int]]:
        """Known tags of a frame, {id: Tag}, as they are without what covers some, and the ids of these.

        ``expected``: {id: (4, 2) pixels}, the places of all known tags.
        """
        completed = {}
        short = {} if self._motion is None else short_tags(layout, self._motion, seen, expected)
        for tag_id, possible in short.items():
            tag = search.complete_short(seen[tag_id], possible)
            if tag is not None:
                completed[tag_id] = tag
        return {**seen, **completed}, frozenset(completed)

    def _note_displaced(self, layout: Layout, seen: Mapping[int, Tag], ids: set[int]) -> None:
        """Take in which of the known tags, {id: Tag}, are not in their places.

        Those that do not span the area are forgotten.
        """
        if self._recognized and self._motion is not None:
            places = self._motion.project(layout.quads(ids)) if ids else ()
            ids = self._strays.moved(seen, dict(zip(ids, places)))
        self._displaced |= ids
        for tag_id in self._displaced - set(layout.ids):
            layout.forget(tag_id)
        self._displaced &= set(layout.ids)

    def _take_in(self, layout: Layout, seen: Mapping[int, Tag]) -> tuple[list[int], bool]:
        """Take in the known tags of a frame, {id: Tag}.

        Returns the ids of the tags that agree, and whether they agree with the predicted motion.
        """
        agreed, moved_on = self._correct(layout, seen)
        self._agreed = agreed
        if agreed:
            self._located_at = self._tags_agreed_at = self._clock.now
            self._displaced -= set(agreed)
        return agreed, moved_on

    def _correct(self, layout: Layout, seen: Mapping[int, Tag]) -> tuple[list[int], bool]:
        """Correct the motion by tags, {id: Tag}; returns the same as ``_take_in``."""
        if not seen:
            return [], False
        if self._motion is None:
            return self._locate(layout, seen), False
        if self._recognized:
            in_place = self._in_place(layout, seen)
            if self._strays.note(set(self._telling(seen)) - set(in_place), self._clock.now):
                # The wall was learned when these tags were elsewhere, or seemed so.
                self._texture, self._recognized = Texture(self._lens), False
            elif len(seen) < 2 * len(in_place) < 2 * len(seen) and len(layout.locate(seen)[1]) < len(seen):
                seen = in_place
        if self._agrees(layout, seen):
            if not self._recognized:
                self._strays.note((), self._clock.now)
            return list(seen), True
        if not self._recognized and not self._displaced and self._frame is not None and self._use_look(seen):
            return self._correct(layout, seen)
        # Not all tags are in their places. Perhaps some are, or all are after a jerk of the camera.
        for motion, limit in (self._motion, UNLIKELY), (self._motion.after_jerk(), UNLIKELY_AFTER_JERK):
            agreed = consistent_tags(layout, seen, motion, limit)
            if agreed:
                break
        # Or the camera has moved farther. Then more tags agree with each other than with the motion.
        # A single tag may have been displaced, so it does not locate the area anew.
        if len(agreed) < len(seen):
            anew = self._locate(layout, seen, max(len(agreed), 1) + 1)
            if anew:
                return anew, False
        if agreed:
            moved_on, self._motion = motion is self._motion, motion
            telling = self._telling({tag_id: seen[tag_id] for tag_id in agreed})
            if telling:
                motion.correct(*measurement(layout, seen, telling))
            return agreed, moved_on
        return [], False

    def _in_place(self, layout: Layout, seen: Mapping[int, Tag]) -> dict[int, Tag]:
        """Those of the tags, {id: Tag}, that are where the motion says."""
        assert self._motion is not None
        quads = np.array([tag.corners for tag in seen.values()])
        off = np.linalg.norm(self._motion.project(layout.quads(seen)) - quads, axis=2).max(axis=1)
        return {tag_id: tag for (tag_id, tag), fits in zip(seen.items(), off < tolerance_of(quads)) if fits}

    def _telling(self, seen: Mapping[int, Tag]) -> Mapping[int, Tag]:
        """Those of the tags, {id: Tag}, that correct the motion: all, or those that are sharp.

        When motion blurs tags, the wall's look says better where they are.
        """
        if not self._recognized:
            return seen
        return {tag_id: tag for tag_id, tag in seen.items() if not self._sharpness.is_blurred(tag)}

    def _agrees(self, layout: Layout, seen: Mapping[int, Tag]) -> bool:
        """Whether tags, {id: Tag}, agree with the motion, which they correct then."""
        assert self._motion is not None
        telling = self._telling(seen)
        if len(telling) < len(seen) and self._motion.unlikeliness(
                *measurement(layout, seen, seen)[:3]) > UNLIKELY:
            return False
        return not telling or self._motion.correct(*measurement(layout, telling, telling), UNLIKELY)

    def _locate(self, layout: Layout, seen: Mapping[int, Tag], least: int = 1) -> list[int]:
        """Start the motion anew from one frame, in which at least ``least`` tags agree.

        Returns their ids. If they are fewer, nothing changes.
        """
        corners, agreed = layout.locate(seen)
        if corners is None or len(agreed) < least:
            return []
        self._motion = AreaMotion(corners, self._shape[::-1], *measurement(layout, seen, agreed))
        self._certain_at = -np.inf
        return agreed

    def _needs_look(self, layout: Layout, seen: Mapping[int, Tag]) -> bool:
        """Whether to ask the wall's look where the area is. ``seen``: {id: Tag}, the tags in their places."""
        if self._motion is None or self._displaced:
            return False
        return (len(seen) < ENOUGH_TAGS or self._has_blurred(seen)
                or (self._deviation > OPEN_PX and not set(layout.ids) <= set(seen)))

    def _has_blurred(self, seen: Mapping[int, Tag]) -> bool:
        return any(self._sharpness.is_blurred(tag) for tag in seen.values())

    def _use_look(self, seen: Mapping[int, Tag]) -> bool:
        """Correct the motion by the wall's look, and return whether that was recognized.

        ``seen``: {id: Tag}, the tags in their places.
        """
        assert self._motion is not None and self._frame is not None
        found = self._texture.find(self._frame, self._motion.corners, float(self._motion.deviation.max()),
                                   not seen or self._has_blurred(seen))
        if found is None:
            return False
        for motion, limit in (self._motion, UNLIKELY), (self._motion.after_jerk(), UNLIKELY_AFTER_JERK):
            if motion.correct(*found, limit):
                self._motion, self._recognized, self._located_at = motion, True, self._clock.now
                return True
        return False

    def _learn_look(self, frame: Image, layout: Layout, motion: AreaMotion, is_first: bool) -> None:
        """Learn the wall's look while all four tags agree, and are sharp. ``is_first``: see Texture.study."""
        may_wait = LATE_S if self._searched_at == self._clock.now else 0
        if self._is_sharp and self._texture.is_due(self._clock.now - may_wait):
            self._texture.study(frame, motion.corners, motion.project(layout.quads(layout.places)),
                                float(motion.deviation.max()), self._clock.now, is_first)
            self._views.take_in(frame, motion.corners, self._lens)

    def _area(self, hold: float) -> Area | None:
        """The Area, if it is known well enough, or None."""
        if self._layout is None or self._motion is None or self._displaced:
            return None
        corners = self._motion.corners
        if not is_quadrilateral(corners):  # seen from behind, or along the wall
            self._motion = None
            return None
        points = corners.tolist()
        longer = max(map(dist, points, points[1:] + points[:1]))
        deviation = max(self._motion.deviation.tolist())
        if self._located_at == self._clock.now and deviation < MAX_DEVIATION * longer:
            self._certain_at = self._clock.now
        held = self._clock.now - self._certain_at
        if held > hold + ROUNDING_S:
            return None
        if deviation > MAX_HELD_DEVIATION * longer and held * self._motion.speed > MAX_HELD_MOVE * longer:
            self._certain_at = -np.inf
            return None
        corners, ratio = corners.astype(np.float32), self._layout.ratio
        if self._upright == 'tags':
            return Area.from_undistorted(corners, ratio, self._lens)
        ordered = order_coordinates(corners)
        on_its_side = np.any(ordered[0] != corners[0]) and np.any(ordered[0] != corners[2])
        return Area.from_undistorted(ordered, 1 / ratio if on_its_side else ratio, self._lens)
