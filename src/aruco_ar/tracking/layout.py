"""The layout of tags: the places of their corners in the plane of the area.

In that plane the area's corners, the centers of four tags, are (0, 0), (1, 0),
(1, 1), (0, 1). From any viewpoint, one homography maps this plane to the frame.
"""
from __future__ import annotations

from typing import Iterable, Mapping, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_from, transform
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

from .area import find_area, ratio_of
from .motion import AreaMotion

MEAN_OF = 20  # a tag's place is the running mean of about this many measurements
EXACT = 8     # so many measurements make the place of a tag exact, compared with what is seen in a frame
MIN_SIGHTINGS, RELEARN_S = 3, 0.5  # a new tag must be seen this many times; a new arrangement also this long
SAME_PLACE_SIDES = 0.02  # a further tag is in its place if it is off by less than this, in its sides, plus 1 px


def tolerance_of(quads: Floats) -> Floats:
    """(n,) pixels: if a corner of tags, (n, 4, 2), is off by more than this, the tag is not in its place."""
    return 1.0 + 0.03 * side_of(quads)


class Layout:
    """The places of tags, and the four tags that span the area.

    ``ids``: those four, in the order of the area's corners, beginning with the
    picture's top left. The tags' own tops decide which side is up. If they
    disagree, the first frame with these tags decides. ``places``: {id: (4, 2)
    float64} of all tags. ``ratio``: the area's width divided by its height on
    the wall.
    """

    def __init__(self, ids: Sequence[int], places: Mapping[int, Floats], measured: int = 0) -> None:
        """``ids``, ``places``: see above. ``measured``: of how many measurements each place is the mean."""
        self.ids, self.places = list(ids), dict(places)
        self._measured = dict.fromkeys(self.places, measured)
        self.ratio = ratio_of(self.quads(self.ids))

    @classmethod
    def from_tags(cls, tags: Sequence[Tag], first: int | None = None) -> Layout | None:
        """The Layout of tags in one frame, or None if they do not span an area.

        ``first``: the id of the tag at the picture's top left, or None. It is
        used if the tags' own tops disagree, and if it is one of the four.
        """
        area = find_area(tags)
        if area is None:
            return None
        ids = [tag.id for tag in tags]
        single = [tag for tag in tags if ids.count(tag.id) == 1]
        corners = np.asarray(area.corners, np.float64)
        near = [min(single, key=lambda tag: np.linalg.norm(tag.center - corner)) for corner in corners]
        to_plane = homography_from(corners)
        tops = {_top_of(transform(to_plane, np.asarray(tag.corners, np.float64))) for tag in near}
        ids = [tag.id for tag in near]
        turn = tops.pop() if len(tops) == 1 else ids.index(first) if first in ids else 0
        to_plane = homography_from(np.roll(corners, -turn, axis=0))
        # The first measurement does not count, since a search finds corners less exactly than tracking does.
        return cls(ids[turn:] + ids[:turn],
                   {tag.id: transform(to_plane, np.asarray(tag.corners, np.float64)) for tag in single})

    @property
    def is_exact(self) -> bool:
        """Whether the places of all tags are means of EXACT measurements or more."""
        return min(self._measured.values()) >= EXACT

    def measured_places(self) -> dict[int, Floats]:
        """``places`` of the tags that were measured repeatedly."""
        return {tag_id: place for tag_id, place in self.places.items()
                if self._measured[tag_id] >= MIN_SIGHTINGS}

    def quads(self, ids: Iterable[int]) -> Floats:
        """(n, 4, 2): the places of those tags."""
        return np.array([self.places[tag_id] for tag_id in ids])

    def learn(self, ids: Iterable[int], places: Iterable[Floats]) -> None:
        """Update the mean places of tags by new measurements, (n, 4, 2), in the plane."""
        for tag_id, place in zip(ids, places):
            known = self.places.setdefault(tag_id, place)
            self._measured[tag_id] = min(self._measured.get(tag_id, 0) + 1, MEAN_OF)
            self.places[tag_id] = known + (place - known) / self._measured[tag_id]
        # The means have shifted the four centers; by definition they are the corners of the unit square.
        drift = homography_from([Tag(0, self.places[tag_id]).center for tag_id in self.ids])
        self.places = dict(zip(self.places, transform(drift, self.quads(self.places))))
        self.ratio = ratio_of(self.quads(self.ids))

    def forget(self, tag_id: int) -> None:
        """Forget a tag, if it is known; it must not be one of the four."""
        self.places.pop(tag_id, None)
        self._measured.pop(tag_id, None)

    def locate(self, seen: Mapping[int, Tag]) -> tuple[Floats | None, list[int]]:
        """Locate the area by tags in one frame, {id: Tag}.

        Returns the area's corners, (4, 2), and the ids of the tags that agree
        with them. More than half of the known tags must agree. Otherwise the
        result is None and an empty list.
        """
        ids = [tag_id for tag_id in seen if tag_id in self.places]
        if not ids:
            return None, []
        points, quads = self.quads(ids), np.stack([seen[tag_id].corners for tag_id in ids])
        limits = tolerance_of(quads)
        homography = _homography(points, quads, cv2.RANSAC, float(limits.min()))
        if homography is None:
            return None, []

        def agree(homography: Floats) -> Booleans:
            off = np.linalg.norm(transform(homography, points.reshape(-1, 2)) - quads.reshape(-1, 2), axis=1)
            return off.reshape(-1, 4).max(axis=1) < limits
        agrees = agree(homography)
        if 2 * agrees.sum() <= len(ids):
            return None, []
        homography = _homography(points[agrees], quads[agrees])
        if homography is None:
            return None, []
        corners = transform(homography, UNIT_SQUARE)
        if not is_quadrilateral(corners):
            return None, []
        return corners, [tag_id for tag_id, fits in zip(ids, agree(homography)) if fits]


class FurtherTags:
    """The tags besides the four that span the area. Those on its plane become part of the layout."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[Floats, int]] = {}  # id -> (place, how often seen there)

    def learn(self, layout: Layout, motion: AreaMotion, seen: Mapping[int, Tag],
              agreed: Sequence[int]) -> None:
        """Improve the places of the tags that agree, and learn further tags on the same plane.

        ``seen``: {id: Tag}. ``agreed``: the ids of those that agree with the layout and the motion.
        """
        quads = np.array([tag.corners for tag in seen.values()], np.float64)
        places = dict(zip(seen, transform(homography_from(motion.corners), quads)))
        if set(agreed) >= set(layout.ids):
            layout.learn(agreed, [places[tag_id] for tag_id in agreed])
        known = [self._seen.get(tag_id, (places[tag_id], 0))[0] for tag_id in seen]
        off = np.abs(motion.project(np.array(known)) - quads).max(axis=(1, 2))
        new = {}
        for tag_id, is_off in zip(seen, off > SAME_PLACE_SIDES * side_of(quads) + 1):
            if tag_id in layout.ids:
                continue
            place, sightings = self._seen.get(tag_id, (places[tag_id], 0))
            if is_off:  # it was moved, or it is not on the plane and so seems to move with the camera
                place, sightings = places[tag_id], 0
                layout.forget(tag_id)
            self._seen[tag_id] = place, sightings + 1
            if sightings + 1 >= MIN_SIGHTINGS and tag_id not in layout.places:
                new[tag_id] = place
        if new:
            layout.learn(new, new.values())


class NewLayout:
    """The new arrangement of displaced tags. It counts when they have stayed in their new places for long."""

    def __init__(self) -> None:
        self._layout: Layout | None = None
        self._since, self._sightings = 0.0, 0

    def stays(self, tags: Sequence[Tag], layout: Layout | None, seconds: float) -> bool:
        """Whether the tags have stayed where they are. ``layout``: the Layout that they have in this frame."""
        if self._layout is not None:
            _, agreed = self._layout.locate({tag.id: tag for tag in tags})
            if set(agreed) >= set(self._layout.ids):
                self._sightings += 1
                return self._sightings >= MIN_SIGHTINGS and seconds - self._since >= RELEARN_S
        self._layout, self._since, self._sightings = layout, seconds, 1
        return False


def _homography(points: Floats, quads: Floats, method: int = 0, limit: float = 3.0) -> Floats | None:
    """(3, 3): the homography from points of the plane, (n, 4, 2), to quads, (n, 4, 2) pixels, or None.

    ``method``, ``limit``: see cv2.findHomography.
    """
    found, _ = cv2.findHomography(points.reshape(-1, 2), quads.reshape(-1, 2), method, limit)
    return None if found is None else np.asarray(found, np.float64)


def _top_of(place: Floats) -> int:
    """The side of the unit square that a tag's own top points to: 0, 1, 2, 3 for up, right, down, left."""
    x, y = place[:2].sum(axis=0) - place[2:].sum(axis=0)
    return int(np.argmax([-y, x, y, -x]))
