"""What a good solution survives: frames that are unlike those that an exercise is judged by."""
from __future__ import annotations

from functools import lru_cache
from typing import Sequence

from aruco_ar.walls.wall import WallTag

from aruco_course.check import Fault, Shown, View

from .polygon_judge import cycles, judge_order
from .polygons import outlined
from .scene import Scene
from .views import NOISE, Stand, look, square_wall

NOISY = 20.0   # gray levels: tags are still found, but the frame is full of specks


@lru_cache(maxsize=None)
def no_tag_views() -> tuple[View, ...]:
    """Two Views of a wall without tags."""
    return tuple(look(square_wall(()), Stand(1.8, left, -8 * left)) for left in (0.2, -0.4))


@lru_cache(maxsize=None)
def three_views() -> tuple[View, ...]:
    """Two Views with three tags."""
    return (look(square_wall((1, 2, 3)), Stand(1.7, 0.2, -5, 3)),
            look(square_wall((14, 70, 33), (90, 0, 180)), Stand(1.9, -0.4, 10, -5)))


@lru_cache(maxsize=None)
def five_views() -> tuple[View, ...]:
    """Two Views with four tags, and a fifth one, the View's last, between them."""
    return (look(square_wall((1, 2, 3, 4), more=[WallTag(5, 0.05, 0.45, 0.18)]), Stand(1.7, 0.2, -5, 3)),
            look(square_wall((20, 7, 133, 54), more=[WallTag(9, -0.08, 0.38, 0.18, 90)]),
                 Stand(1.8, -0.4, 12, -5)))


@lru_cache(maxsize=None)
def twice_views() -> tuple[View, ...]:
    """Two Views with four tags, of which two have the same id."""
    return (look(square_wall((1, 2, 1, 4)), Stand(1.7, 0.2, -5, 3)),
            look(square_wall((60, 60, 12, 7), (0, 90, 0, 0)), Stand(1.9, -0.4, 10, -5)))


@lru_cache(maxsize=None)
def rolled_views() -> tuple[View, ...]:
    """Four Views of a camera that rolls until the area stands on a corner, and farther."""
    scenes = (((1, 2, 3, 4), (0, 0, 0, 0), 30.0), ((8, 2, 90, 41), (0, 0, 90, 0), 45.0),
              ((1, 2, 3, 4), (0, 0, 0, 0), 56.0), ((3, 1, 77, 6), (0, 0, 0, 0), -45.0))
    return tuple(look(square_wall(ids, turns), Stand(2.0, 0.0, 0.0, roll)) for ids, turns, roll in scenes)


@lru_cache(maxsize=None)
def noisy_views() -> tuple[View, ...]:
    """Two Views with much noise."""
    return (look(square_wall((1, 2, 3, 4)), Stand(1.6, 0.2, -5, 3), NOISE * NOISY),
            look(square_wall((20, 7, 133, 54)), Stand(1.7, -0.3, 10, -5), NOISE * NOISY))


def judge_no_polygon(shown: Sequence[Shown]) -> Fault | None:
    """Without four tags, there is no polygon, whatever else is drawn at the tags or written."""
    for one in shown:
        scene = Scene(one)
        if scene.drawing.fault:
            return scene.drawing.fault
        if len(scene.tags) == 3 and scene.shows(scene.centers):
            return scene.fault('a triangle is drawn. Without four tags there is no area.', scene.blank(),
                               scene.changed)
    return None


def judge_five(shown: Sequence[Shown]) -> Fault | None:
    """With a fifth tag, the frame stays as it is, or the polygon goes through the four that are outside."""
    for one in shown:
        scene = Scene(one)
        if scene.drawing.fault:
            return scene.drawing.fault
        outer = scene.centers[:4]
        if scene.empty or any(scene.shows(polygon) for polygon in cycles(outer)):
            continue
        if all(outlined(scene.changed, corners) for corners in scene.corners):
            continue
        return scene.polygon_fault('with five tags, what is drawn is no polygon through the four that are '
                                   'farthest outside. You may also leave such a frame as it is.', outer)
    return None


def judge_twice(shown: Sequence[Shown]) -> Fault | None:
    """Nothing shows which of two tags with one id is meant: it is as right to leave the frame as it is."""
    return judge_order([one for one in shown if not Scene(one).empty])
