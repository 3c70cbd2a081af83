"""The search for tags in a frame: where they are expected, near there, or in the whole frame."""
from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Mapping, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.geometry.lens import Lens
from aruco_ar.tags.corner_rays import found_corners, undistort_corners
from aruco_ar.tags.detector import SEARCH_SIDE_PX, Detector
from aruco_ar.tags.edges import room_of, side_of
from aruco_ar.tags.tag import Tag

from .layout import Layout
from .motion import AreaMotion

MAX_SUBSTITUTES = 8       # if one of the four tags is missing, at most this many other tags are fitted
MIN_SIDE_PX = 8           # a tag that is expected to be smaller is not searched for
EXPECTED_LIKENESS = 0.6   # a tag in its expected place must have more than this likeness (see fit_tags)
EXPECTED_OUTSIDE_PX = 2.0  # a tag that is expected to be this far out of the frame may be in it
NEAR_SIDES = 1.0          # a missing tag is searched for this far around its place, in sides of the tag
NEAR_SCALE = 2.0          # such a search is for tags smaller by this factor: the window is small, so it is fast
SMALL_SIDE_PX = 16        # a fine search is for tags of at least this side
ANY_SIDE = 0.0            # the wish for tags of any size


class TagSearch:
    """Searches the frames of a camera for tags of any id. The arguments are those of Detector."""

    def __init__(self, dictionary: str, **detection: Any) -> None:
        self.detector = Detector(dictionary, **detection)
        self._never_fine = detection.get('search', 'normal') != 'normal'
        self.reset()

    def reset(self) -> None:
        """Forget how earlier frames were searched."""
        self._searches = 0
        self._ids: set[int] = set()  # of all tags that find_all has found

    def find_all(self, frame: Image, is_enough: Callable[[list[Tag]], bool]) -> list[Tag]:
        """The tags in a frame, of any size.

        Usual and fine searches take turns, since each finds some tags that the other misses. If the fine one is
        not enough, both are done the first time, and later if it misses tags that were found before.
        """
        self._searches += 1
        if self._never_fine or self._searches % 2:
            tags = self.detector.detect(frame)
        else:
            tags = self.detector.search(frame, SMALL_SIDE_PX)
            found = {tag.id for tag in tags}
            misses = self._ids if self._searches == 2 else self._ids - found
            if misses and not is_enough(tags):
                tags += [tag for tag in self.detector.detect(frame) if tag.id not in found]
        self._ids.update(tag.id for tag in tags)
        return tags

    def find_large(self, frame: Image, side: float) -> list[Tag]:
        """The tags in a frame with sides of at least ``side`` pixels.

        Only every other search enlarges a frame in which tags are small: it takes twice as long, and finds a
        few more.
        """
        self._searches += 1
        return self.detector.search(frame, side if self._searches % 2 else max(side, SEARCH_SIDE_PX))


class FrameSearch:
    """The search of one frame, for all areas.

    All positions that it takes and returns are undistorted pixels. Without a lens, these are pixels of the
    frame.
    """

    def __init__(self, search: TagSearch, frame: Image, lens: Lens | None,
                 tags: Sequence[Tag] | None = None) -> None:
        """``lens``: that of the frame, or None. ``tags``: all tags in it, if it was searched already."""
        self.frame, self.lens = frame, lens
        self._search, self._detector = search, search.detector
        self._near: dict[int, list[Tag]] = {}  # what was found near the places of missing tags, as it was found
        self._tags = None if tags is None else undistorted_tags(tags, lens)

    @property
    def is_done(self) -> bool:
        """Whether all tags in the frame are known already, so that ``find`` costs nothing."""
        return self._tags is not None

    def reset(self) -> None:
        """Search as if this frame were the first one."""
        self._search.reset()

    def fit_expected(self, layout: Layout, places: Mapping[int, Floats]) -> tuple[dict[int, Tag], list[int]]:
        """{id: Tag} of the tags in their expected places, and the ids of the four tags that are missing.

        A tag is missing if it should be in the frame, but is not in its place. ``places``: see expected_places.
        """
        if not places:
            return {}, []
        seen = self._fit(layout.ids, places)
        missing = [tag_id for tag_id in layout.ids if tag_id not in seen]
        if missing and len(places) > len(layout.ids):
            others = self._in_frame([tag_id for tag_id in places if tag_id not in layout.ids], places)
            # The tags nearest to a missing one show most about that corner of the area.
            gaps, middles = (layout.quads(ids).reshape(-1, 4, 2).mean(axis=1) for ids in (missing, others))
            distance = np.linalg.norm(middles[:, None] - gaps, axis=2).min(axis=1)
            nearest = np.argsort(distance)[:MAX_SUBSTITUTES]
            seen.update(self._fit([others[number] for number in nearest], places))
        return seen, self._in_frame(missing, places)

    def find_near(self, expected: Mapping[int, Floats]) -> list[Tag]:
        """The tags found near their expected places, {id: (4, 2) pixels}."""
        if not expected:
            return []
        if self._tags is not None:
            return [tag for tag in self._tags if tag.id in expected]
        missing = [tag_id for tag_id in expected if tag_id not in self._near]
        quads = self._distorted([expected[tag_id] for tag_id in missing])
        self._near.update((tag.id, [tag]) for tag in self._detector.find_shifted(self.frame, missing, quads))
        for tag_id, quad in zip(missing, quads):
            if tag_id in self._near:
                continue
            side = side_of(quad[None])[0]
            low = np.maximum(quad.min(axis=0) - NEAR_SIDES * side, 0).astype(int)
            high = np.minimum(quad.max(axis=0) + NEAR_SIDES * side + 1, self.frame.shape[1::-1]).astype(int)
            tags = self._detector.search(self.frame[low[1]:high[1], low[0]:high[0]], side / NEAR_SCALE, tag_id)
            self._near[tag_id] = [replace(tag, corners=tag.corners + np.float32(low)) for tag in tags]
        return undistorted_tags([tag for tag_id in expected for tag in self._near[tag_id]], self.lens)

    def find(self, smallest: float, is_enough: Callable[[list[Tag]], bool]) -> list[Tag]:
        """The tags in the whole frame. Those with sides much shorter than ``smallest``, pixels, may be missing.

        ``is_enough``: tells whether some tags are all that is needed: see TagSearch. It is asked for ANY_SIDE.
        """
        if self._tags is not None:
            return self._tags
        tags = self._search.find_all(self.frame, lambda some: is_enough(undistorted_tags(some, self.lens))) \
            if smallest == ANY_SIDE else self._search.find_large(self.frame, max(smallest, MIN_SIDE_PX))
        return undistorted_tags(tags, self.lens)

    def complete(self, tags: Sequence[Tag]) -> list[Tag]:
        """Those of the tags of which something covers a side, as they are without that."""
        found = found_tags(tags, self.lens)
        quads = [self._detector.completion(tag.id).complete(self.frame, tag.corners) for tag in found]
        return undistorted_tags([replace(tag, corners=quad) for tag, quad in zip(found, quads)
                                 if quad is not None], self.lens)

    def complete_short(self, tag: Tag, completed: Mapping[int, Floats]) -> Tag | None:
        """A tag that is too short, as it is without what covers a side of it; None if nothing seems to.

        ``completed``: {side: (4, 2) pixels}, its corners if that side is covered.
        """
        found, *quads = self._distorted([tag.corners, *completed.values()])
        side = self._detector.completion(tag.id).covered_side(self.frame, found, dict(zip(completed, quads)))
        return None if side is None else replace(tag, corners=np.asarray(completed[side], np.float32))

    def smallest_side(self, expected: Sequence[Floats]) -> float:
        """The side of the smallest tag that is expected, (4, 2) pixels each; ANY_SIDE if none is."""
        return float(side_of(self._distorted(expected)).min()) if len(expected) else ANY_SIDE

    def _fit(self, ids: Sequence[int], places: Mapping[int, Floats]) -> dict[int, Tag]:
        """{id: Tag} of those of the tags that are where ``places`` says."""
        if not ids:
            return {}
        quads, found, likeness = self._detector.fit(self.frame, ids,
                                                    self._distorted([places[tag_id] for tag_id in ids]))
        each = zip(ids, quads, *(one.tolist() for one in (
            likeness, found, room_of(quads, self.frame), side_of(quads))))
        confidence = self._detector.confidence
        tags = undistorted_tags([Tag(tag_id, quad, like, confidence(tag_id, like, is_expected=True))
                                 for tag_id, quad, like, is_found, room, side in each
                                 if is_found and like > EXPECTED_LIKENESS and room >= 0 and side > MIN_SIDE_PX],
                                self.lens)
        return {tag.id: tag for tag in tags}

    def _in_frame(self, ids: Sequence[int], places: Mapping[int, Floats]) -> list[int]:
        """The ids of those of the tags that should be in the frame, and are not too small to be found."""
        if not ids:
            return []
        quads = self._distorted([places[tag_id] for tag_id in ids])
        inside = (room_of(quads, self.frame) >= -EXPECTED_OUTSIDE_PX) & (side_of(quads) > MIN_SIDE_PX)
        return [ids[number] for number in np.flatnonzero(inside)]

    def _distorted(self, quads: Sequence[Floats] | Floats) -> Floats:
        """(n, 4, 2): undistorted corners of tags, (n, 4, 2), in pixels of the frame."""
        return np.array(quads) if self.lens is None or not len(quads) else self.lens.distort(quads)


def found_tags(tags: Sequence[Tag], lens: Lens | None) -> list[Tag]:
    """Tags with undistorted corners as Tags with the corners that were found in the frame."""
    if lens is None or not tags:
        return list(tags)
    quads = found_corners(lens, lens.rays_of_undistorted([tag.corners for tag in tags]))
    return [replace(tag, corners=np.asarray(quad, np.float32)) for tag, quad in zip(tags, quads)]


def undistorted_tags(tags: Sequence[Tag], lens: Lens | None) -> list[Tag]:
    """Tags in the frame as Tags with undistorted corners. Those beyond the lens are left out."""
    if lens is None or not tags:
        return list(tags)
    quads = undistort_corners(lens, [tag.corners for tag in tags])
    return [replace(tag, corners=np.asarray(quad, np.float32)) for tag, quad in zip(tags, quads)
            if np.isfinite(quad).all()]


def expected_places(layout: Layout, motion: AreaMotion | None) -> dict[int, Floats]:
    """{id: (4, 2) pixels}: where the known tags should be, inside or outside of the frame."""
    ids = list(layout.places)
    return {} if motion is None else dict(zip(ids, motion.project(layout.quads(ids))))
