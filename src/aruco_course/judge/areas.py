"""Areas in the learner's outputs: which part was made white or black, and why it is not the right one."""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Iterator, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Image, Numbers

from aruco_course.check import Shown

from .drawing import Drawing, brightest, drawing_of
from .views import area_of, centers_of

RIM_PX = 4            # an area may be that much smaller or larger: centers are rounded, and taken as means
NEAR_TAG = 2.0        # what is drawn outside of the area is free up to so many times the tag's size
ON_TAG = 1.3          # the same inside of the area
FITS = 0.9            # an explanation of a part: the share that both have in common, of what either has
NOISE = 10            # gray levels that an untouched pixel may differ from all its neighbors
COURSE_SCALE = 0.7    # the course shrinks its images to that
CORNER_NAMES = 'first', 'second', 'third', 'fourth'


@dataclass(frozen=True, eq=False)
class Sight:
    """Where the area is in one of the learner's outputs, (h, w) pixels.

    ``area``: (4, 2), its corners from the top left, clockwise. ``ids``: of the tags there. ``tags``: (4, 4, 2),
    the corners of these tags, each from its own top left, clockwise.
    """

    shown: Shown
    drawing: Drawing
    area: Floats
    ids: tuple[int, ...]
    tags: Floats

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the output."""
        height, width = self.drawing.image.shape[:2]
        return height, width

    @cached_property
    def inside(self) -> Booleans:
        """(h, w): what is in the area for sure."""
        return cv2.erode(fill(self.shape, self.area), _disc(RIM_PX)) > 0

    @cached_property
    def outside(self) -> Booleans:
        """(h, w): what is outside of it for sure."""
        return cv2.dilate(fill(self.shape, self.area), _disc(RIM_PX)) == 0

    @cached_property
    def near_tags(self) -> Booleans:
        """(h, w): where circles, outlines and ids may be drawn: on the tags, and around them."""
        around, on = (fill(self.shape, *(grown(tag, factor) for tag in self.tags))
                      for factor in (NEAR_TAG, ON_TAG))
        return ((around > 0) & self.outside) | (on > 0)


def sight_of(shown: Shown, output: int = -1) -> Sight:
    """The Sight of one of the outputs, by default the last. The View has four tags."""
    drawing = drawing_of(shown, output)
    if drawing.fault is not None:  # then what it was compared with may be anything
        frame = cv2.resize(shown.view.frame, drawing.image.shape[1::-1])
        drawing = replace(drawing, frame=frame)
    area, centers = area_of(shown.view), centers_of(shown.view)
    order = [int(np.argmin(np.linalg.norm(centers - corner, axis=1))) for corner in area]
    tags = [shown.view.tags[i] for i in order]
    return Sight(shown, drawing, drawing.place(area), tuple(tag.id for tag in tags),
                 drawing.place([tag.corners for tag in tags]))


def turned_sight(sight: Sight, quarters: int) -> Sight:
    """The Sight with an area that begins at another corner, so many farther clockwise."""
    area, tags = (np.roll(points, -quarters, axis=0) for points in (sight.area, sight.tags))
    return replace(sight, area=area, tags=tags, ids=tuple(np.roll(sight.ids, -quarters).tolist()))


def fill(shape: Sequence[int], *polygons: Floats) -> Image:
    """(h, w) uint8: 255 in the polygons, (n, 2) pixels each; where one crosses itself, as OpenCV fills it."""
    image = np.zeros(shape[:2], np.uint8)
    for polygon in polygons:
        cv2.fillPoly(image, [_pixels(polygon)], (255,))
    return image


def grown(polygon: Floats, factor: float) -> Floats:
    """A polygon, (n, 2), so many times larger around its middle."""
    middle = polygon.mean(axis=0)
    return middle + factor * (polygon - middle)


def around(points: Floats) -> Floats:
    """Points, (n, 2), in the order of their directions from their middle, clockwise in the image."""
    x, y = (points - points.mean(axis=0)).T
    return points[np.argsort(np.arctan2(y, x))]


def where(part: Booleans, sight: Sight) -> str:
    """In which direction from the area's middle a part, (h, w), of the output is, such as "at the left"."""
    rows, columns = np.nonzero(part)
    x, y = np.array([columns.mean(), rows.mean()]) - sight.area.mean(axis=0)
    size = np.ptp(sight.area, axis=0)
    if max(abs(x) / size[0], abs(y) / size[1]) < 0.2:
        return 'along its rim' if np.mean(part[sight.inside]) < 0.5 else 'almost everywhere'
    if abs(x) / size[0] > abs(y) / size[1]:
        return 'at the right' if x > 0 else 'at the left'
    return 'at the bottom' if y > 0 else 'at the top'


def ids_text(ids: Sequence[int]) -> str:
    """Ids for a sentence: "3, 1, 4, 2"."""
    return ', '.join(str(tag_id) for tag_id in ids)


def other_shapes(sight: Sight, before: Sequence[Sight]) -> Iterator[tuple[str, Floats]]:
    """What is often taken for the area: how it goes, which follows "Its rim", and its corners, (n, 2).

    ``before``: the Sights of the frames before it.
    """
    area, tags = sight.area, sight.tags
    for number, name in enumerate(CORNER_NAMES):
        yield ("goes through the tags' %s corners, corner[%d], not through their centers: the center is the "
               'mean of all four.' % (name, number), around(tags[:, number]))
    distances = np.linalg.norm(tags - area.mean(axis=0), axis=2)
    every = np.arange(4)
    yield ("goes through the tags' outer corners, not through their centers.",
           tags[every, distances.argmax(axis=1)])
    yield ('goes around all of the tags, not through their centers.',
           _floats(cv2.convexHull(np.asarray(tags.reshape(-1, 2), np.float32))[:, 0]))
    yield ("goes through the tags' inner corners, not through their centers.",
           tags[every, distances.argmin(axis=1)])
    yield ('is an upright rectangle around the centers, but the area is the polygon through them.', _box(area))
    yield ('is an upright rectangle around all of the tags, not the polygon through their centers.',
           _box(tags.reshape(-1, 2)))
    yield ('is a turned rectangle around the centers, but the area is the polygon through them.',
           _floats(cv2.boxPoints(cv2.minAreaRect(np.asarray(area, np.float32)))))
    yield 'has x and y exchanged: a point is (x, y), but an array is indexed by [y, x].', area[:, ::-1]
    scale = float(sight.drawing.scale[0])
    for factor in (COURSE_SCALE, 1 / COURSE_SCALE, scale, 1 / scale, 0.5, 2):
        if abs(factor - 1) > 0.05:
            sentence = ('is %.3g times as far from the top left of the image as it should be: find the tags in '
                        'an image of the same size as the one that you draw on.')
            yield sentence % factor, area * factor
    for other in (*before[:1], *before[-1:]):
        if other.shape == sight.shape and np.abs(other.area - area).max() > 2 * RIM_PX:
            yield ('is still that of frame %d: find the tags in each frame anew.' % other.shown.number,
                   other.area)
    for factor in 0.8, 0.85, 0.9, 0.95, 1.05, 1.1, 1.15, 1.2:
        yield ('is too far %s: it should go through the centers of the tags.' % ('in' if factor < 1 else 'out'),
               grown(area, factor))
    for missing in range(4):
        yield ('leaves out the center of tag %d. Is a center taken twice?' % sight.ids[missing],
               np.delete(area, missing, axis=0))


def crossing_orders(sight: Sight) -> Iterator[tuple[str, Image]]:
    """The two ways to go through the centers so that the rim crosses itself, and what OpenCV fills then.

    How it goes follows "Its rim". What is filled is (h, w) uint8.
    """
    for order in (0, 2, 1, 3), (0, 1, 3, 2):
        sentence = 'crosses itself: its corners come in the order of the tags %s.' % ids_text(
            [sight.ids[i] for i in order])
        yield sentence, fill(sight.shape, sight.area[list(order)])
        for first in range(4):  # this function draws something else for each first corner and direction
            for turned in np.roll(order, -first), np.roll(order, -first)[::-1]:
                image = np.zeros(sight.shape, np.uint8)
                cv2.fillConvexPoly(image, _pixels(sight.area[turned]), (255,))
                yield sentence, image


def why_not(part: Booleans, sight: Sight, before: Sequence[Sight]) -> str:
    """Why a part of an output, (h, w), is not the area: how it goes, which follows "Its rim", or nothing."""
    shapes = [(sentence, fill(sight.shape, corners)) for sentence, corners in other_shapes(sight, before)]
    shapes += crossing_orders(sight)
    shapes.append(('is that of the tags themselves, not of the polygon through their centers.',
                   fill(sight.shape, *sight.tags)))
    if before:
        union = fill(sight.shape, sight.area, *(other.area for other in before if other.shape == sight.shape))
        shapes.append(('also goes around the areas of earlier frames: begin with a new black mask for each.',
                       union))
    least = likeness(part, fill(sight.shape, sight.area) > 0)
    sentence, best = max(((sentence, likeness(part, image > 0)) for sentence, image in shapes),
                         key=lambda shape: shape[1])
    return sentence if best > max(FITS, least) else ''


def likeness(part: Booleans, other: Booleans) -> float:
    """How alike two parts of an image, (h, w), are: 1 for the same, 0 if they have nothing in common."""
    either = np.count_nonzero(part | other)
    return np.count_nonzero(part & other) / either if either else 1.0


def is_outline(part: Booleans, sight: Sight) -> bool:
    """Whether a part of an output, (h, w), is only the outline of the area."""
    line = np.zeros(sight.shape, np.uint8)
    cv2.polylines(line, [_pixels(sight.area)], True, (255,), 1)
    near = cv2.dilate(line, _disc(3 * RIM_PX)) > 0
    followed = cv2.dilate(part.astype(np.uint8), _disc(RIM_PX)) > 0
    return bool(np.mean(near[part]) > 0.9 and np.mean(followed[line > 0]) > 0.7)


def changed(image: Image, frame: Image) -> Booleans:
    """(h, w): where an image is not the frame, (h, w, 3) both, not even if it was shrunk and enlarged again."""
    square = np.ones((3, 3), np.uint8)
    return outside_of(image, cv2.erode(frame, square), cv2.dilate(frame, square), NOISE)


def outside_of(image: Image, low: Image, high: Image, slack: int) -> Booleans:
    """(h, w): where an image is not between two others, (h, w, 3) all, by more than ``slack`` gray levels."""
    return brightest(cv2.max(cv2.subtract(low, image), cv2.subtract(image, high))) > slack


def _box(points: Floats) -> Floats:
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def _pixels(points: Numbers) -> Image:
    return np.asarray(np.round(np.clip(points, -1e4, 1e4)), np.int32)


def _floats(points: Numbers) -> Floats:
    return np.asarray(points, np.float64)


def _disc(radius: int) -> Image:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
