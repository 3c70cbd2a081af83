"""Judges the polygon through the centers of four tags: exercises 5.3 and 5.4."""
from __future__ import annotations

from itertools import combinations, permutations
from typing import Callable, Iterator, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Floats

from aruco_course.check import Fault, Shown

from .polygons import line_at, outlined
from .scene import Mistake, Scene, tags, words

# The three ways around four points that are given in order: the first does not cross itself.
CYCLES = (0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 1, 3)
CIRCLE_PX = 3         # a center is marked if something is drawn that near
TINY_PX = 10          # a polygon whose points are 0 to 3 is no larger
MOST_FRAMES = 4       # so many frames are looked at to name a mistake
SHRUNK = 0.7          # by how much the course shrinks the frame

Polygons = Iterator[Floats]


def judge_centers(shown: Sequence[Shown]) -> Fault | None:
    """Exercise 5.3: the polygon goes through all four centers, in whatever order."""
    def right(scene: Scene) -> bool:
        return any(scene.shows(polygon) for polygon in cycles(scene.area))
    return _judge(shown, right, lambda scene: scene.centers[scene.found])


def judge_order(shown: Sequence[Shown]) -> Fault | None:
    """Exercise 5.4: the polygon goes around through all four centers."""
    def right(scene: Scene) -> bool:
        return scene.shows(scene.area) and not _diagonals(scene)
    return _judge(shown, right, lambda scene: scene.area, _order_fault)


def cycles(points: Floats) -> Polygons:
    """The three polygons through four points that are given in order; of other numbers, only that one."""
    if len(points) != 4:
        yield points
        return
    for cycle in CYCLES:
        yield points[list(cycle)]


def _judge(shown: Sequence[Shown], right: Callable[[Scene], bool], expected: Callable[[Scene], Floats],
           first: Callable[[list[Scene]], Fault | None] = lambda faulty: None) -> Fault | None:
    """The Fault that fits best, if the right solution does not fit. ``first``: what is tried first."""
    faulty, total = [], 0
    for one in shown:
        scene = Scene(one)
        if scene.drawing.fault:
            return scene.drawing.fault
        total += 1
        if not right(scene):
            faulty.append(scene)
    if not faulty:
        return None
    if all(_is_tiny(scene) for scene in faulty):
        return faulty[0].polygon_fault(
            'a polygon of a few pixels is drawn at the top left of the frame. Its points seem to be places in '
            'the list of centers, as argmin gives them: take the centers there, centers[np.argmin(…)].',
            expected(faulty[0]))
    empty = [scene for scene in faulty if scene.empty]
    if empty and len(empty) in (len(faulty), total):
        return empty[0].polygon_fault(nothing_drawn(empty, total, 'polygon'), expected(empty[0]))
    faulty = [scene for scene in faulty if not scene.empty]
    fault = first(faulty)
    if fault:
        return fault
    # The mistake that explains most frames names itself.
    faulty = faulty[:MOST_FRAMES]
    best, most = None, 0
    for sentence, polygons, closed in MISTAKES:
        fits = [scene for scene in faulty
                if any(scene.shows(polygon, closed) for polygon in polygons(scene))]
        if len(fits) > most:
            best, most = fits[0].polygon_fault(sentence, expected(fits[0])), len(fits)
        if most == len(faulty):
            break
    return best or faulty[0].polygon_fault(_what_is_missing(faulty[0]), expected(faulty[0]))


def nothing_drawn(empty: Sequence[Scene], total: int, what: str) -> str:
    """The sentence for frames on which nothing is drawn. ``total``: how many frames there are."""
    ids = [scene.ids for scene in empty]
    if len(empty) == total:
        return ('nothing is drawn: your image is the frame as it came. Were the tags found (dictionary '
                'DICT_6X6_250)? Do you return the image on which you draw?')
    if all(not set(some) <= {1, 2, 3, 4} for some in ids):
        if any(max(some) < 50 for some in ids):
            return ('no %s is drawn, though it is on other frames. The tags here are %s: an id may be any, not '
                    'only 1 to 4.' % (what, words(ids[0])))
        return ('no %s is drawn, though it is on other frames. The tags here are %s: does your dictionary have '
                'all of them, as DICT_6X6_250 does?' % (what, words(ids[0])))
    return 'no %s is drawn, though it is on other frames.' % what


def _diagonals(scene: Scene) -> bool:
    """Whether both diagonals are drawn as lines, too."""
    return all(line_at(scene.changed, scene.area[i], scene.area[i + 2], trim=scene.side).drawn for i in (0, 1))


def _order_fault(faulty: Sequence[Scene]) -> Fault | None:
    """The Fault if the polygon goes through all four centers, but crosses itself."""
    for scene in faulty:
        if outlined(scene.changed, scene.area) and _diagonals(scene):
            return scene.polygon_fault('the polygon in the right order is there, but the one that crosses '
                                       'itself is drawn, too. Draw only the ordered one.', scene.area)
    crossing = [(scene, cycle) for scene in faulty for cycle in CYCLES[1:]
                if scene.shows(scene.area[list(cycle)])]
    if not crossing or len({id(scene) for scene, _ in crossing}) < len(faulty) / 2:
        return None
    scene, cycle = crossing[0]
    indices, reason = list(_around(scene)[list(cycle)]), ''
    for sentence, rule in RULES:
        if all(_same_cycle(rule(some), list(_around(some)[list(way)])) for some, way in crossing):
            indices, reason = rule(scene), sentence
            break
    order = ', '.join(str(scene.ids[index]) for index in indices)
    return scene.polygon_fault('your polygon crosses itself. Its corners come in the order of the tags %s.%s'
                               % (order, reason and ' ' + reason), scene.area)


def _around(scene: Scene) -> Floats:
    """(4,) the indices of the tags from the top left one, clockwise."""
    distances = np.linalg.norm(scene.area[:, None] - scene.centers[None], axis=2)
    return distances.argmin(axis=1)


def _same_cycle(one: Sequence[int], other: Sequence[int]) -> bool:
    """Whether two orders of four are the same way around, in either direction."""
    neighbors = [{frozenset((way[i], way[i - 1])) for i in range(4)} for way in (one, other)]
    return neighbors[0] == neighbors[1]


def _by(key: Callable[[Scene], Floats]) -> Callable[[Scene], list[int]]:
    return lambda scene: [int(index) for index in np.argsort(key(scene), kind='stable')]


# In which orders people take the centers, so that the polygon crosses itself.
RULES: Sequence[tuple[str, Callable[[Scene], list[int]]]] = (
    ('That is the order in which they were found.', lambda scene: scene.found),
    ('That is sorted by id, which says nothing of where a tag is.', _by(lambda scene: np.array(scene.ids))),
    (('That is column by column, as if sorted by x or by x + y alone. Four corners need two numbers, such as '
      'x + y and y - x, or the angle around their middle, np.arctan2.'),
     _by(lambda scene: scene.centers[:, 0])),
    ('That is row by row, as if sorted by y alone: after the top right comes the bottom right.',
     _by(lambda scene: scene.centers[:, 1])),
    ('That is sorted by x + y alone: it takes a second number to tell the corners apart.',
     _by(lambda scene: scene.centers.sum(axis=1))),
    ('That is sorted by y - x alone: it takes a second number to tell the corners apart.',
     _by(lambda scene: scene.centers[:, 1] - scene.centers[:, 0])),
    ('That is sorted by the angle around (0, 0). Take it around their middle, the mean of the four.',
     _by(lambda scene: np.arctan2(scene.centers[:, 1], scene.centers[:, 0]))),
    ('That is row by row: after the top right comes the bottom right.',
     lambda scene: [int(index) for index in _around(scene)[[0, 1, 3, 2]]]),
)


def _exchanged(scene: Scene) -> Polygons:
    return cycles(scene.area[:, ::-1])


def _corner(number: int) -> Callable[[Scene], Polygons]:
    return lambda scene: cycles(_sorted_around(scene.corners[:, number]))


def _middles(scene: Scene) -> Polygons:
    """Through the middle of a side of each tag, the same one."""
    for first in range(4):
        yield from cycles(_sorted_around((scene.corners[:, first] + scene.corners[:, first - 1]) / 2))


def _scaled(factor: float) -> Callable[[Scene], Polygons]:
    return lambda scene: cycles(scene.area * factor)


def _three(scene: Scene) -> Polygons:
    for three in combinations(range(4), 3):
        yield scene.area[list(three)]


def _three_there_and_back(scene: Scene) -> Polygons:
    """Two lines between three of the centers, there and back, since one center is there twice."""
    for three in permutations(range(4), 3):
        yield scene.area[list(three)]


def _one_coordinate(axis: int) -> Callable[[Scene], Polygons]:
    """x or y taken for both."""
    return lambda scene: cycles(scene.area[:, [axis, axis]])


def _bytes(scene: Scene) -> Polygons:
    """Coordinates in bytes, where 0 follows 255."""
    yield from cycles(scene.area % 256)


def _axis_missing(scene: Scene) -> Polygons:
    """What c[:, 0].mean() and c[:, 1].mean() are if c is (1, 4, 2): each of one corner's x and y."""
    yield from cycles(scene.corners[_around(scene), :2].mean(axis=2))


def _with_zero(scene: Scene) -> Polygons:
    """Some of the centers, and the top left of the frame."""
    for count in 3, 2, 1:
        for some in combinations(range(4), count):
            points = np.vstack([[0, 0], scene.area[list(some)]])
            yield from cycles(points)


def _all_corners(scene: Scene) -> Polygons:
    yield scene.corners[scene.found].reshape(-1, 2)


def _hull_of_corners(scene: Scene) -> Polygons:
    yield np.asarray(cv2.convexHull(np.asarray(scene.corners.reshape(-1, 2), np.float32))[:, 0], np.float64)


def _extreme(outer: bool) -> Callable[[Scene], Polygons]:
    """Through each tag's corner that is farthest from the middle, or nearest to it."""
    def polygons(scene: Scene) -> Polygons:
        distances = np.linalg.norm(scene.corners - scene.area.mean(axis=0), axis=2)
        best = distances.argmax(axis=1) if outer else distances.argmin(axis=1)
        return cycles(_sorted_around(scene.corners[np.arange(len(best)), best]))
    return polygons


def _upright(scene: Scene) -> Polygons:
    """The upright rectangle around the centers, and those with two of them as corners."""
    for some in [(0, 1, 2, 3), *combinations(range(4), 2)]:
        (left, top), (right, foot) = (f(scene.area[list(some)], axis=0) for f in (np.min, np.max))
        yield np.array([[left, top], [right, top], [right, foot], [left, foot]])


def _rotated(scene: Scene) -> Polygons:
    yield np.asarray(cv2.boxPoints(cv2.minAreaRect(np.asarray(scene.area, np.float32))), np.float64)


def _axes_apart(scene: Scene) -> Polygons:
    """x and y sorted each by itself."""
    yield from cycles(np.sort(scene.centers, axis=0))


def _open(scene: Scene) -> Polygons:
    for cycle in cycles(scene.area):
        for first in range(4):
            yield np.roll(cycle, first, axis=0)


def _sorted_around(points: Floats) -> Floats:
    arms = points - points.mean(axis=0)
    return points[np.argsort(np.arctan2(arms[:, 1], arms[:, 0]))]


THREE = 'your polygon has only three corners, so one center is missing, or another is taken twice.'
CENTER = 'A center is the mean of the four corners.'
# What people draw instead.
MISTAKES = (
    Mistake('x and y are exchanged. Drawing functions take (x, y), while an array has the row, which is y, '
            'first.',
            _exchanged),
    *(Mistake("your polygon goes through the tags' %s corners, not through their centers. %s" % (name, CENTER),
              _corner(number)) for number, name in enumerate(('first', 'second', 'third', 'fourth'))),
    Mistake("your polygon goes through the middles of the tags' sides, not through their centers. " + CENTER,
            _middles),
    Mistake('your polygon is too near to the top left: the centers were found in a frame '
            'that was shrunk to 0.7, but drawn on the whole frame. Find and draw in the same '
            'image.', _scaled(SHRUNK)),
    Mistake('your polygon is too far to the right and too low: the centers were found in the whole frame, but '
            'drawn on one that was shrunk to 0.7. Find and draw in the same image.', _scaled(1 / SHRUNK)),
    Mistake('your polygon is twice as far from the top left as it should be. The mean of four '
            'corners is their sum divided by 4.', _scaled(2)),
    Mistake('x is taken for y, too: of a point, [0] is x, and [1] is y.', _one_coordinate(0)),
    Mistake('y is taken for x, too: of a point, [0] is x, and [1] is y.', _one_coordinate(1)),
    Mistake('coordinates of more than 255 begin again at 0, since they are kept in np.uint8. Keep them in '
            'np.int32.',
            _bytes),
    Mistake('corners[i] is an array of 1 x 4 x 2 numbers, so one [0] is missing: the four corners of a tag are '
            'corners[i][0].', _axis_missing),
    Mistake('a corner of your polygon is (0, 0), the top left of the frame: it was never set.', _with_zero),
    Mistake(THREE, _three),
    Mistake('x and y were sorted each by itself, so they no longer belong together. Sort whole centers.',
            _axes_apart),
    Mistake('your polygon goes through all corners of all tags, not through the four centers. ' + CENTER,
            _all_corners),
    Mistake('your polygon goes around all tags, through their outermost corners, not through their centers. '
            + CENTER, _hull_of_corners),
    Mistake("your polygon goes through the tags' outermost corners, not through their centers. " + CENTER,
            _extreme(True)),
    Mistake("your polygon goes through the tags' innermost corners, not through their centers. " + CENTER,
            _extreme(False)),
    Mistake('you draw an upright rectangle. Its corners should be the four centers.', _upright),
    Mistake('you draw a rectangle. A camera seldom sees one as such: the corners should be the four centers.',
            _rotated),
    Mistake('your polygon is open: the line from its last corner to its first is missing.', _open, False),
    Mistake(THREE, _three_there_and_back, False),
)


def _what_is_missing(scene: Scene) -> str:
    """The sentence if no known mistake fits."""
    lost = [tag_id for tag_id, center in zip(scene.ids, scene.centers) if not _near(scene, center)]
    reach = cv2.contourArea(np.asarray(scene.area, np.float32))
    on_tags = [outlined(scene.changed, quad) or _inner(scene, quad) for quad in scene.corners]
    drawn = {pair: line_at(scene.changed, *scene.centers[list(pair)]).drawn
             for pair in combinations(range(4), 2)}
    if sum(drawn.values()) == 0 and all(on_tags):
        return 'you draw the tags, but no polygon through their four centers.'
    if scene.changed.sum() > 0.3 * reach:
        return _lost(lost) or 'your polygon does not go through the four centers.'
    if sum(drawn.values()) == 0 and not lost and scene.changed.sum() < 60 * len(scene.tags) * CIRCLE_PX:
        return ('there are only points at the centers, and no polygon. Is one drawn, as a list of polygons '
                '([points]), and on the image that you return? Are all four centers in it: is append in the '
                'loop, or behind it?')
    missing = [pair for pair in ((0, 1), (1, 2), (2, 3), (0, 3)) if not drawn[pair]]
    if 0 < len(missing) < 4 and sum(drawn.values()):
        first, second = (scene.ids[index] for index in missing[0])
        return 'no line goes from the center of tag %d to that of tag %d.' % (first, second)
    return _lost(lost) or 'your polygon does not go through the four centers.'


def _lost(ids: Sequence[int]) -> str:
    """The sentence for centers that a polygon does not reach; nothing if there are none."""
    if not ids:
        return ''
    why = ' Is only one center kept: is append in the loop, or behind it?' if len(ids) > 2 else ''
    return 'your polygon does not reach the center%s of %s.%s' % ('s' if len(ids) > 1 else '', tags(ids), why)


def _is_tiny(scene: Scene) -> bool:
    """Whether something is drawn at the top left of the frame, and elsewhere at most at the centers."""
    if not scene.changed[:TINY_PX, :TINY_PX].any():
        return False
    rest = scene.changed.copy()
    rest[:TINY_PX, :TINY_PX] = False
    for x, y in np.round(scene.centers).astype(int):
        half = int(scene.side / 2)
        rest[max(y - half, 0):y + half + 1, max(x - half, 0):x + half + 1] = False
    return not rest.any()


def _near(scene: Scene, point: Floats) -> bool:
    """Whether something is drawn at a point."""
    x, y = np.round(point).astype(int)
    return bool(scene.changed[max(y - CIRCLE_PX, 0):y + CIRCLE_PX + 1,
                              max(x - CIRCLE_PX, 0):x + CIRCLE_PX + 1].any())


def _inner(scene: Scene, quad: Floats) -> bool:
    """Whether most of a tag is drawn over."""
    mask = np.zeros(scene.changed.shape, np.uint8)
    cv2.fillPoly(mask, [np.round(quad).astype(np.int32)], (255,))
    return bool(scene.changed[mask > 0].mean() > 0.85)
