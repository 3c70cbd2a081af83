"""Judges exercise 5.2: every tag is outlined on its corners, and its id is written beside it.

Ids are judged without reading them. A View is rendered again with another id in one place. Wherever the two
frames agree, what the learner's code makes of them may differ only by what it writes for that id.
"""
from __future__ import annotations

from functools import lru_cache
from typing import Callable, Iterator, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Image, Integers
from aruco_ar.walls.wall import WallTag

from aruco_course.check import Fault, Shown, View

from .drawing import as_bgr, brightest
from .polygon_judge import MOST_FRAMES, SHRUNK, nothing_drawn
from .polygons import LEAST_DRAWN, area_mask, line_at, outlined
from .scene import GREEN, Mistake, Scene, apart, tags, wide, words
from .views import Stand, area_views, look, square_wall

NEAR_PX = 3.0         # an outline may be that far from the tag's sides
MOST = 0.7            # share of the polygons of a mistake that must be drawn
LEAST_WRITTEN = 6     # pixels in which two ids differ at least
LEVELS = 40           # by how many gray levels such a pixel differs
ALIKE = 0.6           # what is written is beside the tags if its places differ by less than this many sides
BESIDE = 1.5, 40.0    # it is written near a tag: tag sides, and pixels more

# The same wall four times more, each time with another id in one place. All ids keep their rank, so that a
# position in a sorted list stays the same.
IDS = 5, 160, 31, 87
OTHER_IDS = 18, 233, 64, 112
TURNS = 0, 90, 180, 0
FIRST_IDS = 1, 2, 3, 4   # those of the course's own wall
STAND = Stand(1.75, 0.25, -7, 6)


@lru_cache(maxsize=None)
def tag_views() -> tuple[View, ...]:
    """Ten Views: five for the ids, and others with two to six tags."""
    views = [look(square_wall(IDS, TURNS), STAND)]
    for place, other in enumerate(OTHER_IDS):
        ids = [*IDS[:place], other, *IDS[place + 1:]]
        views.append(look(square_wall(ids, TURNS), STAND))
    ordinary = area_views()
    return (ordinary[0], *views, ordinary[5], ordinary[7],
            look(square_wall((66, 2), (0, 200)), Stand(1.6, 0.1, -4, -6)),
            look(square_wall((11, 3, 249, 30), (0, 0, 90, 0),
                             more=[WallTag(100, 0.0, 0.5, 0.16, 15), WallTag(71, 0.1, 0.16, 0.15)]),
                 Stand(1.7, 0.3, -10, -4)))


def judge_tags(shown: Sequence[Shown]) -> Fault | None:
    """Every tag is outlined, and its own id is written beside it."""
    scenes = [Scene(one) for one in shown]
    for scene in scenes:
        if scene.drawing.fault:
            return scene.drawing.fault
    faulty = [scene for scene in scenes if not all(outlines(scene))]
    if faulty:
        return _outline_fault(faulty, scenes)
    return ids_fault(scenes)


def judge_outlines(shown: Sequence[Shown]) -> Fault | None:
    """Every tag is outlined, and something is written at each."""
    scenes = [Scene(one) for one in shown]
    for scene in scenes:
        if scene.drawing.fault:
            return scene.drawing.fault
    faulty = [scene for scene in scenes if not all(outlines(scene))]
    return _outline_fault(faulty, scenes) if faulty else None


def judge_frame_kept(shown: Sequence[Shown]) -> Fault | None:
    """The output is the frame, whatever is written on it."""
    return next((scene.drawing.fault for scene in map(Scene, shown) if scene.drawing.fault), None)


def outlines(scene: Scene) -> list[bool]:
    """For each tag, whether it is outlined, or filled."""
    return [outlined(scene.changed, quad, near=NEAR_PX) or _filled(scene, quad) for quad in scene.corners]


def _filled(scene: Scene, quad: Floats) -> bool:
    mask = area_mask(scene.changed.shape, quad)
    inside = cv2.erode(mask, np.ones((5, 5), np.uint8)) > 0
    distance = cv2.distanceTransform(cv2.bitwise_not(mask), cv2.DIST_L2, 3)
    around = (distance > 5) & (distance < 10)
    return bool(scene.changed[inside].mean() > LEAST_DRAWN and scene.changed[around].mean() < 0.5)


def _expected_fault(what: str, scene: Scene) -> Fault:
    """A Fault with the tags as they should be drawn."""
    expected = scene.blank()
    lines = np.zeros(scene.changed.shape, np.uint8)
    for tag_id, quad in zip(scene.ids, scene.corners):
        points = [np.round(quad).astype(np.int32)]
        cv2.polylines(expected, points, True, GREEN, 2, cv2.LINE_AA)
        cv2.polylines(lines, points, True, (255,), 2)
        write_id(expected, tag_id, quad)
    near_tags = cv2.dilate(lines, np.ones((25, 25), np.uint8)) > 0
    wrong = apart(lines > 0, scene.changed)
    for quad, right in zip(scene.corners, outlines(scene)):
        if right:  # what else is near a tag that is outlined may be its id
            wrong &= ~(cv2.dilate(area_mask(scene.changed.shape, quad), np.ones((61, 61), np.uint8)) > 0)
        else:
            wrong |= (area_mask(scene.changed.shape, quad) > 0) & near_tags & ~scene.changed
    return scene.fault(what, expected, wide(wrong))


def write_id(image: Image, tag_id: int, quad: Floats) -> None:
    """Write the id above a tag, as the expected pictures have it."""
    left, top = np.min(quad, axis=0)
    place = round(float(left)), max(round(float(top)) - 8, 16)
    cv2.putText(image, 'id %d' % tag_id, place, cv2.FONT_HERSHEY_SIMPLEX, 0.55, (0, 0, 0), 4, cv2.LINE_AA)
    cv2.putText(image, 'id %d' % tag_id, place, cv2.FONT_HERSHEY_SIMPLEX, 0.55, GREEN, 1, cv2.LINE_AA)


def _outline_fault(faulty: Sequence[Scene], scenes: Sequence[Scene]) -> Fault:
    empty = [scene for scene in faulty if scene.empty]
    if empty and len(empty) in (len(faulty), len(scenes)):
        return _expected_fault(nothing_drawn(empty, len(scenes), 'tag'), empty[0])
    faulty = [scene for scene in faulty if not scene.empty]
    partly = [scene for scene in faulty if any(outlines(scene))]
    if len(partly) == len(faulty):
        scene = partly[0]
        done = [(tag_id, right) for some in scenes for tag_id, right in zip(some.ids, outlines(some))]
        lost = [tag_id for tag_id, right in zip(scene.ids, outlines(scene)) if not right]
        if all(right == (tag_id in FIRST_IDS) for tag_id, right in done):
            return _expected_fault('only tags with the ids 1 to 4 are outlined, but an id may be any: %s, for '
                                   'example.' % words(lost), scene)
        if all(right == (tag_id < 50) for tag_id, right in done):
            return _expected_fault('the tags with ids from 50 on are not outlined: %s. Does the dictionary '
                                   'have them, as DICT_6X6_250 does?' % words(lost), scene)
        if all(_most([outlined(some.changed, quad, True, NEAR_PX) for quad in _wrapped(some)])
               for some in faulty):
            return _expected_fault('the outlines of tags on the right, or below, are elsewhere: their corners '
                                   'are numbers beyond 255, where uint8 ends. Use int32.', scene)
        if all(sum(outlines(some)) == 1 for some in faulty):
            return _expected_fault('only one tag is outlined, not %s. Draw in a loop over all of them, and '
                                   'return behind it.'
                                   % words(lost), scene)
        if all(any(_sides(scene, scene.corners[scene.ids.index(tag_id)])) for tag_id in lost):
            return _expected_fault('the outline of %s is not on its edges everywhere.' % tags(lost), scene)
        return _expected_fault('%s %s not outlined.' % (tags(lost), 'is' if len(lost) == 1 else 'are'), scene)
    faulty = faulty[:MOST_FRAMES]
    best, most = None, 0
    for sentence, quads, closed in MISTAKES:
        fits = [scene for scene in faulty
                if _most([outlined(scene.changed, quad, closed, NEAR_PX) for quad in quads(scene)])]
        if len(fits) > most:
            best, most = _expected_fault(sentence, fits[0]), len(fits)
    return best or _expected_fault(_what_is_missing(faulty[0]), faulty[0])


def _most(drawn: Sequence[bool]) -> bool:
    return bool(drawn) and sum(drawn) > MOST * len(drawn)


def _exchanged(scene: Scene) -> Iterator[Floats]:
    for quad in scene.corners:
        if quad.max() < scene.changed.shape[0]:  # those that are in the frame then
            yield quad[:, ::-1]


def _scaled(factor: float) -> Callable[[Scene], Iterator[Floats]]:
    def quads(scene: Scene) -> Iterator[Floats]:
        for quad in scene.corners * factor:
            if np.all(quad < scene.changed.shape[1::-1]):
                yield quad
    return quads


def _wrapped(scene: Scene) -> Iterator[Floats]:
    """The corners of tags beyond 255, as uint8 has them."""
    for quad in scene.corners:
        if quad.max() >= 256:
            yield np.trunc(quad) % 256


def _upright(scene: Scene) -> Iterator[Floats]:
    for quad in scene.corners:
        (left, top), (right, foot) = quad.min(axis=0), quad.max(axis=0)
        yield np.array([[left, top], [right, top], [right, foot], [left, foot]])


def _between(first: int) -> Callable[[Scene], Iterator[Floats]]:
    """Upright rectangles between a corner and the opposite one."""
    def quads(scene: Scene) -> Iterator[Floats]:
        for quad in scene.corners:
            (x, y), (end_x, end_y) = quad[first], quad[first + 2]
            yield np.array([[x, y], [end_x, y], [end_x, end_y], [x, end_y]])
    return quads


def _open(scene: Scene) -> Iterator[Floats]:
    for quad in scene.corners:
        yield next((turned for turned in (np.roll(quad, first, axis=0) for first in range(4))
                    if outlined(scene.changed, turned, False, NEAR_PX)), quad)


def _crossed(scene: Scene) -> Iterator[Floats]:
    for quad in scene.corners:
        yield next((crossed for crossed in (quad[[0, 1, 3, 2]], quad[[0, 2, 1, 3]])
                    if outlined(scene.changed, crossed, True, NEAR_PX)), quad)


def _through_all(scene: Scene) -> Iterator[Floats]:
    yield scene.corners[scene.found].reshape(-1, 2)


# What people draw instead. Most of the polygons must be there.
MISTAKES = (
    Mistake('you draw upright rectangles around the tags. Draw the lines through their four corners.',
            _upright),
    Mistake('one line goes through the corners of all tags. Draw each tag by itself.', _through_all),
    Mistake('the outlines are not closed: the line from the last corner to the first is missing.',
            _open, False),
    Mistake('x and y are exchanged. Drawing functions take (x, y), while an array has the row, which is y, '
            'first.', _exchanged),
    Mistake('the outlines are too near to the top left: the tags were found in a frame that was shrunk to '
            '0.7, but drawn on the whole frame. Find and draw in the same image.', _scaled(SHRUNK)),
    Mistake('the outlines are too far to the right and too low: the tags were found in the whole frame, but '
            'drawn on one that was shrunk to 0.7. Find and draw in the same image.', _scaled(1 / SHRUNK)),
    Mistake('squares are outlined that the detector rejected. It returns corners, ids and rejected candidates, '
            'in this order; draw the first.', lambda scene: scene.rejected),
    Mistake('the outlines cross themselves: the corners of a tag come clockwise, so take them in their order.',
            _crossed),
    *(Mistake('you draw upright rectangles between two corners of each tag. Draw the lines through all four '
              'corners.', _between(corner)) for corner in (0, 1)),
)


def _what_is_missing(scene: Scene) -> str:
    """The sentence if no known mistake fits."""
    near = cv2.dilate(_tags_mask(scene), np.ones((41, 41), np.uint8)) > 0
    if not scene.changed[near].any():
        return 'something is drawn, but nowhere near a tag.'
    if not any(any(_sides(scene, quad)) for quad in scene.corners):
        return ('the tags are not outlined, though something is drawn there. Draw lines from each corner of a '
                'tag to the next. The corners are the first of what detectMarkers returns.')
    return 'the outlines are not on the edges of the tags.'


def _sides(scene: Scene, quad: Floats) -> list[bool]:
    """For each side of a tag, whether a line is drawn there."""
    return [line_at(scene.changed, quad[i], quad[i - 1], NEAR_PX).drawn for i in range(4)]


def _tags_mask(scene: Scene) -> Image:
    mask: Image = np.zeros(scene.changed.shape, np.uint8)
    for quad in scene.corners:
        mask = cv2.max(mask, area_mask(mask.shape, quad))
    return mask


def ids_fault(scenes: Sequence[Scene]) -> Fault | None:
    """The Fault if what is written at the tags does not depend on their ids alone."""
    first, others = _id_scenes(scenes)
    if first is None:
        return None
    places = []
    for place, scene in enumerate(others):
        if scene is None:
            return None
        written = _written(first, scene)
        if written.sum() < LEAST_WRITTEN:
            pair = first.ids[place], scene.ids[place]
            what = 'the id of tag %d is not written at it, or beside it.' % pair[1]
            if _something_written(scene, place):
                what = ('the same is written for the ids %d and %d. Write the id of each tag at it, not its '
                        'position in the list, nor the id of another.' % pair)
            if not any(_something_written(scene, number) for number in range(4)):
                what = 'the tags are outlined, but their ids are not written.'
            return _written_fault(what, scene, place)
        y, x = np.nonzero(written)
        places.append(np.stack([x, y], axis=-1))
    return _places_fault(first, [scene for scene in others if scene], places)


def _places_fault(first: Scene, others: Sequence[Scene], places: Sequence[Integers]) -> Fault | None:
    """The Fault if ids are written, but not at their own tags. ``places``: for each tag, the pixels, (n, 2)."""
    middles = np.array([np.median(pixels, axis=0) for pixels in places])
    offsets = middles - first.centers
    if np.all(np.linalg.norm(offsets - offsets.mean(axis=0), axis=1) < ALIKE * first.side) \
            and np.all(np.abs(offsets.mean(axis=0)) < BESIDE[0] * first.side + BESIDE[1]):
        return None
    for place, (scene, pixels) in enumerate(zip(others, places)):
        distances = np.linalg.norm(pixels[:, None] - first.centers[None], axis=2)
        nearest = np.bincount(distances.argmin(axis=1), minlength=len(first.centers))
        if np.median(distances.min(axis=1)) > BESIDE[0] * first.side + BESIDE[1]:
            return _written_fault('the ids are written, but not beside their tags.', scene, place)
        if np.count_nonzero(nearest > 0.5 * nearest.max()) > 2:
            return _written_fault('all ids are written at each tag, or several of them. At each belongs its '
                                  'own alone: str(ids[i][0]).', scene, place)
        if nearest.argmax() != place:
            return _written_fault(
                'the id %d is written at tag %d. Take the corners and the id from the same position of their '
                'lists.' % (scene.ids[place], scene.ids[int(nearest.argmax())]), scene, place)
    return None


def _id_scenes(scenes: Sequence[Scene]) -> tuple[Scene | None, list[Scene | None]]:
    """The scene with IDS, and for each place the one where this id is another. None if there is none."""
    by_ids = {tuple(scene.ids): scene for scene in scenes}
    others = [by_ids.get((*IDS[:place], other, *IDS[place + 1:])) for place, other in enumerate(OTHER_IDS)]
    return by_ids.get(IDS), others


def _written(first: Scene, other: Scene) -> Booleans:
    """Where two outputs differ by more than a pixel's shift, though their frames agree."""
    if first.changed.shape != other.changed.shape:
        return np.zeros_like(first.changed)
    one, two = first.drawing.image, other.drawing.image
    agree = brightest(cv2.absdiff(first.drawing.frame, other.drawing.frame)) <= 2
    # Where the tags' own cells differ, what is drawn on one alone tells as much.
    only_one, only_two = first.changed & ~other.changed, other.changed & ~first.changed
    return (agree | only_one) & _new(one, two) | (agree | only_two) & _new(two, one)


def _new(one: Image, two: Image) -> Booleans:
    """Where an image is unlike another one, even if that is shifted by a pixel."""
    height, width = two.shape[:2]
    padded = cv2.copyMakeBorder(as_bgr(two), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    least = np.full((height, width), 255, np.uint8)
    for y in range(3):
        for x in range(3):
            least = np.minimum(least, brightest(cv2.absdiff(one, padded[y:y + height, x:x + width])))
    return least > LEVELS


def _something_written(scene: Scene, place: int) -> bool:
    """Whether more than the outline and marks of the corners is drawn at a tag."""
    quad = scene.corners[place]
    mask = area_mask(scene.changed.shape, quad)
    rim = cv2.morphologyEx(mask, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    lines = cv2.distanceTransform(cv2.bitwise_not(rim), cv2.DIST_L2, 3)
    beside = cv2.distanceTransform(cv2.bitwise_not(mask), cv2.DIST_L2, 3)
    return int((scene.changed & (lines > 8) & (beside < scene.side + 20)).sum()) > 25


def _written_fault(what: str, scene: Scene, place: int) -> Fault:
    """A Fault with the tags as they should be drawn. What is near the tag in that place is marked."""
    fault = _expected_fault(what, scene)
    left, top = scene.corners[place].min(axis=0)
    right, foot = scene.corners[place].max(axis=0)
    marked = np.zeros_like(scene.changed)
    marked[max(round(float(top)) - 24, 0):round(float(foot)) + 3,
           max(round(float(left)) - 3, 0):round(float(right)) + 3] = True
    return scene.fault(what, fault.expected, marked)
