"""The area over time: it stays on the wall while tags come and go."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.geometry.ordering import is_quadrilateral, order_coordinates
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

from .area import Area
from .layout import Layout, tolerance_of
from .motion import AreaMotion
from .texture import Texture

HOLD_S = 0.3
UPRIGHT = 'tags', 'image'
SEARCH_S = 0.45        # so often the whole frame is searched for what is new
GAP_S = 0.5            # frames farther apart than this say nothing about motion
USUAL_S = 1 / 30       # between frames whose stamps do not tell
RELEARN_S = 0.5        # for so long another arrangement of tags must be seen
SIGHTS = 3             # as often must be seen what is new, to be believed
FURTHER = 8            # where one of the four is missing, so many other tags are looked for
SMALL_SIDE_PX = 12     # of tags that are found only if looked for closely
MIN_SIDE_PX = 8        # a tag expected to be smaller is not looked for
AROUND = 1.0           # sides: so far around its place a tag is looked for that is not there
FINER = 2.0            # as if it were so much smaller: a window is small enough to look at it closely
MIN_LIKENESS = 0.6     # of what is where a tag is expected to that tag (see fit_tags)
SAME_PLACE = 0.02      # sides, and 1 px: a further tag is not as far off its place
# What is more unlikely than this (see AreaMotion.unlikeliness) is no error of
# measurement; and after allowing for a jerk of the camera, no jerk.
UNLIKELY, SHAKEN_UNLIKELY = 9.0, 2.0
MANY = 12              # of more tags that contradict each other, those that do most go together
# Of the area's longer side. A frame that shows the corners less exactly does not
# renew the time for which the area is held ...
MAX_DEVIATION = 0.029
# ... which is over at once when they are known less exactly than the first of
# these, and at their speed have moved by the second.
MAX_HELD_DEVIATION, MAX_HELD_MOVE = 0.03, 0.045
# By how much the corners of a tag with a side of SMALL_PX can be off in the same way in every frame; on one
# half as large four times as much.
BIAS_PX, SMALL_PX = 0.10, 30.0
ROUNDING_S = 1e-6      # of stamps
# The wall's texture is looked at where fewer tags than this agree, and none does or they leave a corner open by
# more than so many pixels; for so long after the last tag, since all may have been taken off the wall.
ENOUGH, OPEN_PX, TEXTURE_S = 3, 2.0, 15.0


class Tracker:
    """Follows the area through a sequence of frames.

    Once four tags have been seen together, it knows where on the wall all
    their corners are; from then on every tag in sight says where the area is.
    ``dictionary``, ``ids``: see Detector. ``hold``: seconds, 0 or more, for
    which the area stays at most when the tags in sight do not show well enough
    where it is, or none is in sight; it can be set at any time. ``upright``:
    the picture's top is where the tags' own tops are (``tags``) or where the
    frame's is (``image``). ``detection``: further keywords of Detector, such as
    ``search``, which is how frames without an expected area are searched.
    Raises InputError for any other.
    """

    def __init__(self, dictionary: str = 'DICT_6X6_250', ids: Iterable[int] = (), hold: float = HOLD_S,
                 upright: str = 'tags', **detection: Any) -> None:
        if not isinstance(hold, (int, float)) or not hold >= 0:
            raise InputError('An area cannot be held for %s; give seconds, 0 or more.' % (hold,))
        if upright not in UPRIGHT:
            raise InputError('"%s" is no way to be upright; choose one of %s.' % (upright, ', '.join(UPRIGHT)))
        self._ids = frozenset(ids)
        Detector(dictionary, self._ids)  # raises where the dictionary does not have them
        # Others on the same plane show where the four are.
        self._detector = Detector(dictionary, **detection)
        self._one_way = detection.get('search', 'normal') != 'normal'
        self._layout: Layout | None = None
        self.hold = hold
        self._upright = upright
        self.reset()

    @property
    def tags(self) -> list[Tag]:
        """A list of Tag: those seen in the last frame, of the ids that count."""
        return [Tag(tag_id, np.asarray(corners, np.float32)) for tag_id, corners in self._seen.items()
                if self._counts(tag_id)]

    @property
    def why(self) -> str:
        """A sentence: what the area of the last frame is known by, or why there is none."""
        if self._layout is None:
            return 'Four tags have not been seen together.'
        if self._displaced:
            return 'Tags are not where they were.'
        if self._tagged == self._now:
            return 'Its tags show it.' if self._shown else 'Its tags in sight do not show it well enough.'
        if self._recognized:
            return "The wall's texture shows it."
        if self._shown:
            return 'It is where it should be by now; for a moment nothing shows it.'
        if self._now - self._tagged > TEXTURE_S:
            return 'None of its tags has been in sight for %g s.' % TEXTURE_S
        return "Neither its tags nor the wall's texture show where it is."

    def reset(self) -> None:
        """Forget everything seen so far."""
        self._stamp: float | None = None
        self._shape: tuple[int, ...] = ()
        self._shown = False
        self._searches, self._has_some = 0, False  # how often; whether the usual way found any, last time
        self._now = 0.0  # goes on also where stamps stand still
        self._layout = None
        self._begin([])

    def update(self, frame: Image, stamp: float) -> Area | None:
        """The Area in a frame, or None.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``stamp``: its time in
        seconds. Where time goes back or the frame's size changes, all that was
        seen is forgotten.
        """
        if self._stamp is not None and (not stamp >= self._stamp or frame.shape[:2] != self._shape):
            self.reset()
        passed = USUAL_S if self._stamp in (None, stamp) else stamp - self._stamp
        self._now += passed
        self._stamp, self._shape = stamp, frame.shape[:2]
        if self._layout is None:
            self._begin(self._search_all(frame))
        else:
            self._predict(passed)
            self._look(frame, self._layout)
            if self._motion is not None and not self._displaced:
                self._use_texture(frame, self._layout, self._motion)
        area = self._area()
        self._shown = area is not None
        return area

    def _begin(self, tags: Sequence[Tag]) -> None:
        """Start afresh, with the area that these tags span, if they do."""
        self._seen = {tag.id: tag.corners for tag in tags}
        self._texture, self._recognized = Texture(), False  # and whether it was, in the last frame
        self._agreed: list[int] = []
        self._layout = self._layout_of(tags)
        self._motion: AreaMotion | None = None
        self._displaced: set[int] = set()  # tags seen where they do not belong, and not where they do since
        self._lost: set[int] = set()  # of the four, those that were looked for in the last frame in vain
        self._rival: Layout | None = None
        self._rival_since, self._rival_sights = 0.0, 0
        # Tags besides the four: id -> (place, how often seen there).
        self._further: dict[int, tuple[Floats, int]] = {}
        # When the frame was searched, tags or texture showed the area, tags did, and it was sure.
        self._searched = self._sighted = self._tagged = self._sure = -np.inf
        if self._layout is not None:
            self._searched = self._now
            self._believe(self._layout, self._seen)

    def _counts(self, tag_id: int) -> bool:
        return not self._ids or tag_id in self._ids

    def _layout_of(self, tags: Sequence[Tag]) -> Layout | None:
        """The Layout of those tags that count, or None; of the same four the top stays where it was."""
        first = None if self._layout is None else self._layout.ids[0]
        return Layout.from_tags([tag for tag in tags if self._counts(tag.id)], first)

    def _predict(self, passed: float) -> None:
        """Move on by that time, seconds; after too long, nobody knows where to."""
        if self._motion is not None:
            unseen = self._now - self._sighted
            if passed > GAP_S or unseen > max(GAP_S, self.hold):
                self._motion = None
            else:
                self._motion.predict(passed, calm=unseen > passed)

    def _look(self, frame: Image, layout: Layout) -> None:
        """Find the tags, where they should be, around there, or else anywhere, and correct the motion by them.

        What a search of the whole frame finds also tells about other scenes,
        moved tags and further ones.
        """
        seen, missing = self._follow(frame, layout, self._motion)
        expected = self._expected(layout)
        tags = self._look_around(frame, {tag_id: expected[tag_id] for tag_id in missing})
        lost = set(missing) - {tag.id for tag in tags}
        everywhere = (self._now - self._searched >= SEARCH_S or not (seen or tags or self._recognized)
                      or bool(self._displaced or lost - self._lost))  # it may have been moved
        self._lost = lost
        if everywhere:
            self._searched = self._now
            found = self._search(frame, [expected[tag_id] for tag_id in layout.ids if expected])
            tags = found + [tag for tag in tags if tag.id not in {other.id for other in found}]
        # Of several tags with one id, the one nearest to its place counts.
        for tag in sorted(tags, key=lambda tag: np.abs(tag.corners - expected.get(tag.id, np.inf)).max()):
            seen.setdefault(tag.id, tag.corners)
        self._seen = seen
        known = {tag_id: quad for tag_id, quad in seen.items() if tag_id in layout.places}
        agreed, moved_on = self._believe(layout, known)
        if not tags:
            return
        others = len(seen) - len(known)
        # A few that are known may hang in another scene as well.
        if not moved_on and others > len(agreed) and self._layout_of(tags):
            self._begin(tags)  # another scene
            return
        self._displaced.update(set(known) - set(agreed))
        for tag_id in self._displaced - set(layout.ids):
            layout.forget(tag_id)
        self._displaced &= set(layout.ids)
        if self._displaced:
            if everywhere:
                self._consider_rearranged(tags)
        elif everywhere and self._motion is not None and len(agreed) >= 3:
            self._learn(layout, self._motion, seen, agreed)

    def _expected(self, layout: Layout) -> dict[int, Floats]:
        """{id: (4, 2) pixels}: where the known tags should be, in the frame or out of it."""
        ids = list(layout.places)
        return {} if self._motion is None else dict(zip(ids, self._motion.see(layout.quads(ids))))

    def _follow(self, frame: Image, layout: Layout,
                motion: AreaMotion | None) -> tuple[dict[int, Floats], list[int]]:
        """{id: corners} of the tags found where they should be, and which of the four are not, but could be."""
        if motion is None:
            return {}, []
        expected = self._in_frame(frame, layout, motion)
        four = [tag_id for tag_id in layout.ids if tag_id in expected]
        seen = self._fitted(frame, four, expected)
        missing = [tag_id for tag_id in layout.ids if tag_id not in seen]
        others = [tag_id for tag_id in expected if tag_id not in layout.ids]
        if missing and others:  # those nearest to where one is missing say most about that corner
            gaps, places = layout.quads(missing).mean(axis=1), layout.quads(others).mean(axis=1)
            far = np.linalg.norm(places[:, None] - gaps, axis=2).min(axis=1)
            nearest = np.argsort(far)[:FURTHER]
            seen.update(self._fitted(frame, [others[number] for number in nearest], expected))
        return seen, [tag_id for tag_id in four if tag_id not in seen]

    def _in_frame(self, frame: Image, layout: Layout, motion: AreaMotion) -> dict[int, Floats]:
        """{id: (4, 2) pixels}: where known tags should be, of those large enough and in the frame."""
        ids = list(layout.places)
        quads = motion.see(layout.quads(ids))
        inside = (quads > 1) & (quads < np.array(frame.shape[1::-1]) - 2)
        inside = inside.all(axis=(1, 2)) & (side_of(quads) > MIN_SIDE_PX)
        return {ids[number]: quads[number] for number in np.flatnonzero(inside)}

    def _fitted(self, frame: Image, ids: Sequence[int], expected: Mapping[int, Floats]) -> dict[int, Floats]:
        """{id: corners} of those of the tags that are where they are expected."""
        if not ids:
            return {}
        quads, found, likeness = self._detector.fit(frame, ids, np.array([expected[tag_id] for tag_id in ids]))
        found &= likeness > MIN_LIKENESS
        return {tag_id: quad for tag_id, quad, fits in zip(ids, quads, found) if fits}

    def _look_around(self, frame: Image, missing: Mapping[int, Floats]) -> list[Tag]:
        """The tags found near where those that are missing, {id: (4, 2) pixels}, should be."""
        found = []
        for tag_id, quad in missing.items():
            side = side_of(quad[None])[0]
            low = np.maximum(quad.min(axis=0) - AROUND * side, 0).astype(int)
            high = np.minimum(quad.max(axis=0) + AROUND * side + 1, frame.shape[1::-1]).astype(int)
            around = self._detector.search(frame[low[1]:high[1], low[0]:high[0]], side / FINER)
            found += [Tag(tag_id, tag.corners + np.float32(low)) for tag in around if tag.id == tag_id]
        return found

    def _search(self, frame: Image, expected: Sequence[Floats]) -> list[Tag]:
        """The tags anywhere in the frame: of about the size of those expected, (4, 2) pixels, if any are."""
        if not expected:
            return self._search_all(frame)
        return self._detector.search(frame, max(side_of(np.array(expected)).min(), MIN_SIDE_PX))

    def _search_all(self, frame: Image) -> list[Tag]:
        """The tags anywhere in the frame, of any size.

        There are two ways, each of which finds some more; they take turns. The turn of the close one is both,
        where it shows no area though the usual one found some tags in the frame before.
        """
        self._searches += 1
        if self._one_way or self._searches % 2:
            tags = self._detector.detect(frame)
            self._has_some = len(tags) > 0
            return tags
        tags = self._detector.search(frame, SMALL_SIDE_PX)
        if self._has_some and self._layout_of(tags) is None:
            known = {tag.id for tag in tags}
            tags += [tag for tag in self._detector.detect(frame) if tag.id not in known]
        return tags

    def _believe(self, layout: Layout, seen: Mapping[int, Floats]) -> tuple[list[int], bool]:
        """Take in where known tags are seen, {id: corners}.

        Returns the ids of those that agree, and whether they moved on as they did before.
        """
        agreed, moved_on = self._correct(layout, seen)
        self._agreed = agreed
        if agreed:
            self._sighted = self._tagged = self._now
            self._displaced -= set(agreed)
        return agreed, moved_on

    def _correct(self, layout: Layout, seen: Mapping[int, Floats]) -> tuple[list[int], bool]:
        """Correct the motion by what is seen; the same as ``_believe``."""
        if not seen:
            return [], False
        if self._motion is None:
            return self._locate(layout, seen), False
        if self._motion.correct(*_measured(layout, seen, seen), UNLIKELY):
            return list(seen), True
        # Not all are where they should be; some may be so nearly, or all after a jerk.
        for motion, limit in (self._motion, UNLIKELY), (self._motion.shaken(), SHAKEN_UNLIKELY):
            agreed = _likely(layout, seen, motion, limit)
            if agreed:
                moved_on, self._motion = motion is self._motion, motion
                motion.correct(*_measured(layout, seen, agreed))
                return agreed, moved_on
        # One tag alone may just have been moved.
        return self._locate(layout, seen) if len(seen) > 1 else [], False

    def _locate(self, layout: Layout, seen: Mapping[int, Floats]) -> list[int]:
        """Begin to follow the area from where one frame shows it; the ids of the tags that agree."""
        corners, agreed = layout.locate(seen)
        if corners is not None:
            self._motion = AreaMotion(corners, self._shape[::-1], *_measured(layout, seen, agreed))
            self._sure = -np.inf
        return agreed

    def _consider_rearranged(self, tags: list[Tag]) -> None:
        """Some tags are elsewhere; if they stay there, that is the new arrangement."""
        seen = {tag.id: tag.corners for tag in tags}
        if self._rival is not None:
            _, agreed = self._rival.locate(seen)
            if set(agreed) >= set(self._rival.ids):
                self._rival_sights += 1
                if self._rival_sights >= SIGHTS and self._now - self._rival_since >= RELEARN_S:
                    self._begin(tags)
                return
        self._rival = self._layout_of(tags)
        self._rival_since, self._rival_sights = self._now, 1

    def _learn(self, layout: Layout, motion: AreaMotion, seen: Mapping[int, Floats], agreed: list[int]) -> None:
        """Learn more exactly where the tags are, and further tags on the same plane."""
        to_plane = np.linalg.inv(homography_to(motion.corners))
        quads = np.array(list(seen.values()), np.float64)
        places = dict(zip(seen, transform(to_plane, quads)))
        if set(agreed) >= set(layout.ids):
            layout.learn(agreed, [places[tag_id] for tag_id in agreed])
        known = [self._further.get(tag_id, (places[tag_id], 0))[0] for tag_id in seen]
        off = np.abs(motion.see(np.array(known)) - quads).max(axis=(1, 2)) > SAME_PLACE * side_of(quads) + 1
        for tag_id, is_off in zip(seen, off):
            if tag_id in layout.ids:
                continue
            place, sights = self._further.get(tag_id, (places[tag_id], 0))
            if is_off:  # Moved, or not on the plane: seen from elsewhere, it is beside its place.
                place, sights = places[tag_id], 0
                layout.forget(tag_id)
            self._further[tag_id] = place, sights + 1
            if sights + 1 >= SIGHTS and tag_id not in layout.places:
                layout.learn([tag_id], [place])

    def _use_texture(self, frame: Image, layout: Layout, motion: AreaMotion) -> None:
        """Learn the wall's texture where tags show the area, and correct the motion by it where they do not."""
        self._recognized = False
        if set(self._agreed) >= set(layout.ids) and self._texture.is_due(self._now):
            self._texture.study(frame, motion.corners, motion.see(layout.quads(layout.places)), self._now)
        if (len(self._agreed) >= ENOUGH or (self._agreed and motion.deviation.max() < OPEN_PX)
                or self._now - self._tagged > TEXTURE_S):
            return
        found = self._texture.find(frame, motion.corners)
        if found is None:
            return
        if motion.correct(*found, UNLIKELY):
            self._recognized = True
        elif not self._agreed:  # a jerk of the camera?
            self._motion = motion.shaken()
            self._recognized = self._motion.correct(*found, SHAKEN_UNLIKELY)
            if not self._recognized:
                self._motion = motion
        if self._recognized:
            self._sighted = self._now

    def _area(self) -> Area | None:
        """What is known about the area, if it is known well enough to be shown."""
        if self._layout is None or self._motion is None or self._displaced:
            return None
        corners = self._motion.corners
        if not is_quadrilateral(corners):  # seen from behind, or along the wall
            self._motion = None
            return None
        longer = np.hypot(*(corners - corners[[1, 2, 3, 0]]).T).max()
        deviation = self._motion.deviation.max()
        if self._sighted == self._now and deviation < MAX_DEVIATION * longer:
            self._sure = self._now
        unsure = self._now - self._sure
        if unsure > self.hold + ROUNDING_S:
            return None
        if deviation > MAX_HELD_DEVIATION * longer and unsure * self._motion.speed > MAX_HELD_MOVE * longer:
            self._sure = -np.inf
            return None
        corners, ratio = corners.astype(np.float32), self._layout.ratio
        if self._upright == 'tags':
            return Area(corners, ratio)
        ordered = order_coordinates(corners)
        on_its_side = np.any(ordered[0] != corners[0]) and np.any(ordered[0] != corners[2])
        return Area(ordered, 1 / ratio if on_its_side else ratio)


def _measured(layout: Layout, seen: Mapping[int, Floats],
              ids: Iterable[int]) -> tuple[Floats, Floats, Floats, Floats]:
    """Of tags what AreaMotion.correct takes: points, pixels, deviation and bias."""
    quads = np.array([seen[tag_id] for tag_id in ids], np.float64)
    side = side_of(quads)
    deviation, bias = 0.15 + 0.002 * side, BIAS_PX * (SMALL_PX / side)**2
    return (layout.quads(ids).reshape(-1, 2), quads.reshape(-1, 2), np.repeat(deviation, 4), np.repeat(bias, 4))


def _likely(layout: Layout, seen: Mapping[int, Floats], motion: AreaMotion, limit: float) -> list[int]:
    """The ids of the tags that, so moving, can be where they are seen, all together."""
    def unlikeliness(some: list[int]) -> float:
        points, pixels, _, _ = _measured(layout, seen, some)
        deviation = np.repeat(tolerance_of(pixels.reshape(-1, 4, 2)) / 3, 4)
        return motion.unlikeliness(points, pixels, deviation)
    ids = list(seen)
    if len(ids) > MANY:  # to leave out each of them in turn takes too long
        alone = {tag_id: unlikeliness([tag_id]) for tag_id in ids}
        ids.sort(key=alone.__getitem__)
        while len(ids) > MANY and unlikeliness(ids) > limit:
            del ids[-(len(ids) // MANY):]
    while ids and unlikeliness(ids) > limit:
        ids = min(([other for other in ids if other != tag_id] for tag_id in ids),
                  key=lambda some: unlikeliness(some) if some else 0)
    return ids
