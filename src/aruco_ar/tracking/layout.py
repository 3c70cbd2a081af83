"""Where the corners of tags lie in the plane of the area.

In that plane the area's corners, the centers of four tags, are (0, 0), (1, 0),
(1, 1), (0, 1). Seen from anywhere, one homography takes all of it to the frame.
"""
from __future__ import annotations

from typing import Iterable, Mapping, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

from .area import find_area, ratio_of

UNIT_SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
LEARN_SIGHTS = 20  # over as many the places of the corners are averaged


def tolerance_of(quads: Floats) -> Floats:
    """(n,) pixels: farther off than this, a corner is not where it was learned to be."""
    return 1.0 + 0.03 * side_of(quads)


class Layout:
    """The places of tags, and the four that span the area.

    ``ids``: those four, in the order of the area's corners, the first of which
    is the picture's top left: as the tags' own tops have it or, where they
    disagree, as the frame had it in which they were first seen. ``places``:
    {id: (4, 2) float64} of all tags. ``ratio``: how many times as wide as high
    the area is on the wall.
    """

    def __init__(self, tags: Sequence[Tag], corners: Floats, first: int | None = None) -> None:
        """From tags seen in one frame, and the area's corners in it, (4, 2); for ``first`` see from_tags."""
        near = [min(tags, key=lambda tag: np.linalg.norm(tag.center - corner)) for corner in corners]
        to_plane = np.linalg.inv(homography_to(corners))
        tops = {_top_of(transform(to_plane, np.asarray(tag.corners, np.float64))) for tag in near}
        ids = [tag.id for tag in near]
        turn = tops.pop() if len(tops) == 1 else ids.index(first) if first in ids else 0
        self.ids = ids[turn:] + ids[:turn]
        to_plane = np.linalg.inv(homography_to(np.roll(corners, -turn, axis=0)))
        self.places = {tag.id: transform(to_plane, np.asarray(tag.corners, np.float64)) for tag in tags}
        # The first is not counted: tags that are searched for are found less exactly than those followed.
        self._sights = dict.fromkeys(self.places, 0)
        self.ratio = ratio_of(self.quads(self.ids))

    @classmethod
    def from_tags(cls, tags: Sequence[Tag], first: int | None = None) -> Layout | None:
        """The Layout of tags seen in one frame, or None if they do not span an area.

        ``first``: the id of the tag that is at the picture's top left if it is
        one of the four and the tags' own tops disagree.
        """
        area = find_area(tags)
        if area is None:
            return None
        ids = [tag.id for tag in tags]
        single = [tag for tag in tags if ids.count(tag.id) == 1]
        return cls(single, np.asarray(area.corners, np.float64), first)

    def quads(self, ids: Iterable[int]) -> Floats:
        """(n, 4, 2): the places of those tags."""
        return np.array([self.places[tag_id] for tag_id in ids])

    def learn(self, ids: Iterable[int], places: Iterable[Floats]) -> None:
        """Take the mean of where tags were seen in the plane, now at places (n, 4, 2), and before."""
        for tag_id, place in zip(ids, places):
            known = self.places.setdefault(tag_id, place)
            self._sights[tag_id] = min(self._sights.get(tag_id, 0) + 1, LEARN_SIGHTS)
            self.places[tag_id] = known + (place - known) / self._sights[tag_id]
        # The area is where the centers are, whatever was learned about the corners.
        drift = np.linalg.inv(homography_to([Tag(0, self.places[tag_id]).center for tag_id in self.ids]))
        self.places = dict(zip(self.places, transform(drift, self.quads(self.places))))
        self.ratio = ratio_of(self.quads(self.ids))

    def forget(self, tag_id: int) -> None:
        """Forget a tag that is none of the four, if it is known."""
        self.places.pop(tag_id, None)
        self._sights.pop(tag_id, None)

    def locate(self, seen: Mapping[int, Floats]) -> tuple[Floats | None, list[int]]:
        """Where the area must be for tags, {id: (4, 2) pixels}, to be where they are seen.

        Returns its corners, (4, 2), and the ids of the tags that agree with
        it, found from more than half of those that are known. None, [] if so many
        do not agree.
        """
        ids = [tag_id for tag_id in seen if tag_id in self.places]
        if not ids:
            return None, []
        points, quads = self.quads(ids), np.stack([seen[tag_id] for tag_id in ids])
        limits = tolerance_of(quads)
        homography = _homography(points, quads, cv2.RANSAC, float(limits.min()))
        if homography is None:
            return None, []

        def agree(homography: Floats) -> Booleans:
            off = np.linalg.norm(transform(homography, points.reshape(-1, 2)) - quads.reshape(-1, 2), axis=1)
            return off.reshape(-1, 4).max(axis=1) < limits
        good = agree(homography)
        if 2 * good.sum() <= len(ids):
            return None, []
        homography = _homography(points[good], quads[good])
        if homography is None:
            return None, []
        corners = transform(homography, UNIT_SQUARE)
        if not is_quadrilateral(corners):
            return None, []
        return corners, [tag_id for tag_id, fits in zip(ids, agree(homography)) if fits]


def _homography(points: Floats, quads: Floats, method: int = 0, limit: float = 3.0) -> Floats | None:
    """(3, 3): from points of the plane, (n, 4, 2), to quads, (n, 4, 2) pixels; see cv2.findHomography."""
    found, _ = cv2.findHomography(points.reshape(-1, 2), quads.reshape(-1, 2), method, limit)
    return None if found is None else np.asarray(found, np.float64)


def _top_of(place: Floats) -> int:
    """Which side of the unit square a tag's own top points to: 0, 1, 2, 3 for up, right, down, left."""
    x, y = place[:2].sum(axis=0) - place[2:].sum(axis=0)
    return int(np.argmax([-y, x, y, -x]))
