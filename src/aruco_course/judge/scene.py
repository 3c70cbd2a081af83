"""An output with what is known of its frame, all in pixels of the output."""
from __future__ import annotations

from functools import cached_property
from typing import Callable, Iterable, NamedTuple, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Image

from aruco_course.check import Fault, Shown

from .drawing import drawing_of, place_of
from .polygons import NEAR_PX, area_mask, filled, outlined
from .views import area_of, centers_of, course_detect

LEAST_CHANGED = 12  # pixels: with fewer, nothing is drawn
GREEN, PURPLE, WHITE = (0, 255, 0), (255, 0, 150), (255, 255, 255)


class Scene:
    """What was drawn on a frame, where its tags are, and how it is said that something is wrong there."""

    def __init__(self, shown: Shown) -> None:
        self.shown = shown
        self.drawing = drawing_of(shown)
        self.changed: Booleans = self.drawing.changed
        self.tags = shown.view.tags
        self.ids = [tag.id for tag in self.tags]
        # (n, 4, 2) and (n, 2)
        self.corners = self.drawing.place(np.array([tag.corners for tag in self.tags]).reshape(-1, 4, 2))
        self.centers = self.drawing.place(centers_of(shown.view))
        sides = np.linalg.norm(self.corners - np.roll(self.corners, -1, axis=1), axis=2)
        self.side = float(np.median(sides)) if len(sides) else 0.0

    @property
    def empty(self) -> bool:
        """Whether nothing is drawn."""
        return int(self.changed.sum()) < LEAST_CHANGED

    @cached_property
    def area(self) -> Floats:
        """(4, 2): the four centers from the top left one, clockwise."""
        return self.drawing.place(area_of(self.shown.view))

    @cached_property
    def found(self) -> list[int]:
        """The indices of the tags in the order in which the course's lines find them, then those they miss."""
        corners, _, _ = course_detect(self.drawing.frame)
        order: list[int] = []
        for quad in corners:
            distances = np.linalg.norm(self.centers - quad.mean(axis=0), axis=1)
            if len(distances) and distances.min() < 0.3 * self.side and int(distances.argmin()) not in order:
                order.append(int(distances.argmin()))
        return order + [i for i in range(len(self.tags)) if i not in order]

    @cached_property
    def rejected(self) -> list[Floats]:
        """Squares that the course's lines reject: (4, 2) each."""
        return course_detect(self.drawing.frame)[2]

    def shows(self, polygon: Floats, closed: bool = True) -> bool:
        """Whether a polygon is drawn, as lines or filled; if it is not ``closed``, as lines."""
        return ((self._near_lines(polygon, closed) and outlined(self.changed, polygon, closed))
                or (closed and (filled(self.changed, polygon, self.side)
                               or filled(self.changed, polygon, self.side, convex=True))))

    @cached_property
    def _wide(self) -> Image:
        """(h, w) uint8: what is drawn, wider by NEAR_PX."""
        size = 2 * int(NEAR_PX) + 1
        return cv2.dilate(self.changed.view(np.uint8), np.ones((size, size), np.uint8))

    def _near_lines(self, polygon: Floats, closed: bool) -> bool:
        """Whether something is drawn near most of a polygon's lines: a quick test that rejects most others."""
        ends = np.roll(polygon, -1, axis=0)
        parts = np.linspace(0, 1, 12)[:, None, None]
        points = (1 - parts) * polygon + parts * ends
        if not closed:
            points = points[:, :-1]
        height, width = self._wide.shape
        x, y = np.moveaxis(np.round(points).astype(int), -1, 0)
        inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        near = self._wide[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)] > 0
        return bool(np.all((near | ~inside).mean(axis=0) > 0.6))

    def blank(self) -> Image:
        """A copy of the frame as the output would be if nothing was drawn."""
        return self.drawing.frame.copy()

    def fault(self, what: str, expected: Image | None = None, marked: Booleans | None = None) -> Fault:
        """A Fault with the frame's number."""
        return Fault(what, place_of(self.shown), self.shown, expected, marked)

    def polygon_fault(self, what: str, polygon: Floats) -> Fault:
        """A Fault where another polygon was expected. It is drawn as the learner's: filled or as lines."""
        expected = self.blank()
        area = area_mask(self.changed.shape, polygon)
        whole = area_mask(self.changed.shape, cv2.convexHull(np.asarray(polygon, np.float32))[:, 0])
        points = [np.round(polygon).astype(np.int32)]
        if self.changed.sum() > 0.3 * np.count_nonzero(whole):
            cv2.fillPoly(expected, points, PURPLE)
            wrong = (area > 0) != self.changed
        else:
            cv2.polylines(expected, points, True, PURPLE, 3, cv2.LINE_AA)
            lines = np.zeros_like(area)
            cv2.polylines(lines, points, True, (255,), 3)
            wrong = apart(lines > 0, self.changed)
        return self.fault(what, expected, wide(wrong))


class Mistake(NamedTuple):
    """What people draw instead: the sentence that says so, and the polygons that a Scene shows then.

    If they are not ``closed``, the line from the last corner to the first is missing.
    """

    sentence: str
    polygons: Callable[[Scene], Iterable[Floats]]
    closed: bool = True


def apart(one: Booleans, other: Booleans) -> Booleans:
    """Where one of two drawings is, but the other is not within a few pixels."""
    kernel = np.ones((9, 9), np.uint8)
    near_one, near_other = (cv2.dilate(image.astype(np.uint8), kernel) > 0 for image in (one, other))
    return (one & ~near_other) | (other & ~near_one)


def wide(mask: Booleans) -> Booleans:
    """The mask without what is only a pixel or two wide and comes from rounding; the rest a little wider."""
    opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return cv2.dilate(opened, np.ones((5, 5), np.uint8)) > 0


def words(ids: Sequence[int]) -> str:
    """Ids as words: "3, 1 and 4"."""
    parts = [str(tag_id) for tag_id in ids]
    return parts[0] if len(parts) == 1 else '%s and %s' % (', '.join(parts[:-1]), parts[-1])


def tags(ids: Sequence[int]) -> str:
    """Tags as words: "tag 3", or "the tags 3 and 1"."""
    return ('tag %s' if len(ids) == 1 else 'the tags %s') % words(ids)
