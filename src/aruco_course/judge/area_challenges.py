"""The challenges of exercises with an area: views without four proper tags, and hard ones."""
from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import combinations
from typing import Callable, Sequence

import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Numbers
from aruco_ar.geometry.ordering import is_quadrilateral, order_coordinates
from aruco_ar.walls.wall import WallTag

from aruco_course.check import Challenge, Fault, Judge, Shown, View

from .areas import NEAR_TAG, changed, fill, grown
from .challenges import five_views, no_tag_views, noisy_views, three_views, twice_views
from .drawing import drawing_of, place_of
from .views import SIDE_M, Stand, look, square_wall

IDS = 7, 1, 10, 4
TOUCHED = 0.0005  # share of the frame that may be changed though there is no area
LIGHT = 0.2       # a dark frame has so many times the light
GRAINS = 10.0, 20.0, 28.0  # standard deviation of the noise of dark frames, gray levels

# Changes a View, for example by giving it a picture.
Prepare = Callable[[View], View]


def area_challenges(judge: Judge, judge_none: Judge, judge_turned: Judge,
                    prepare: Prepare = lambda view: view) -> tuple[Challenge, ...]:
    """The Challenges of an exercise. ``judge``: that of Views with an area; ``judge_none``: without one.

    ``judge_turned``: with an area that is turned by about 45 degrees. ``prepare``: makes
    the exercise's own View of each.
    """
    def views(make: Callable[[], Sequence[View]]) -> Callable[[], Sequence[View]]:
        return lambda: [prepare(view) for view in make()]

    def either(shown: Sequence[Shown]) -> Fault | None:
        """Frames in which it is as right to see no area."""
        for one in shown:
            fault = judge_none([one])
            if fault is not None and all(judge([choice]) for choice in choices(one)):
                return replace(fault, what='The frame should stay as it is, or the area be that of four of the '
                                           'tags. It is neither.')
        return None

    return (
        Challenge('no tag in sight', "Without tags, ids is None. The course's loop, for i in range(len(ids)), "
                  'ends with a TypeError there, and the node shows nothing any '
                  'more.', views(no_tag_views), judge_none),
        Challenge('three tags', 'With three tags the course does not put the centers in order, and then uses '
                  'the order that it does not have.', views(three_views), judge_none),
        Challenge('five tags', 'Among five centers, one may have the least x + y and the greatest y - x. The '
                  'course then takes it twice, and its area is a triangle.', views(_five_tags), either),
        Challenge('one id twice', 'Two tags may have the same id, such as two prints of one page. Code that '
                  'keeps the centers by id, in a dict, loses one of them, and then has no fourth.',
                  views(twice_views), either),
        Challenge('a camera that rolls', 'If the wall is turned by about 45 degrees, one center may have the '
                  'least x + y and the greatest y - x. The course then takes it '
                  'twice. The angle of each center around their middle, np.arctan2, gives an order that always '
                  'goes around.', views(_rolled), judge_turned),
        Challenge('a noisy frame', 'In the dark, pixels are noisy. The course finds fewer tags then, and its '
                  'code only works with four.', views(_dark), either),
    )


def untouched(shown: Sequence[Shown]) -> Fault | None:
    """The first Fault in images of Views without an area, which stay as they are."""
    for one in shown:
        drawing = drawing_of(one)
        different = changed(drawing.image, drawing.frame)
        if drawing.fault is not None:
            return drawing.fault
        if np.mean(different) > TOUCHED and not _only_on_tags(different, one, drawing.place):
            return Fault('There is no area, since there are not four different tags. So the image stays as it '
                         'is.',
                         place_of(one), one, drawing.frame, different)
    return None


def _only_on_tags(different: Booleans, shown: Shown, place: Callable[[Numbers], Floats]) -> bool:
    """Whether only the tags themselves are marked, which is free."""
    near = fill(different.shape, *(grown(place(tag.corners), NEAR_TAG) for tag in shown.view.tags))
    return bool(np.mean(different & np.asarray(near == 0)) <= TOUCHED)


def choices(shown: Shown) -> list[Shown]:
    """The same output, with each four of the View's tags that span an area, if there are more."""
    tags = shown.view.tags
    chosen = []
    for four in combinations(tags, 4):
        if is_quadrilateral(order_coordinates([tag.center for tag in four])):
            view = View(shown.view.frame, four, shown.view.picture)
            chosen.append(Shown(shown.number, view, shown.images))
    return chosen


@lru_cache(maxsize=None)
def _five_tags() -> tuple[View, ...]:
    return (look(square_wall(IDS, more=[WallTag(23, -0.85, 0.42, SIDE_M)]), Stand(2.2)), *five_views())


@lru_cache(maxsize=None)
def _rolled() -> tuple[View, ...]:
    return (look(square_wall(IDS), Stand(1.9, 0.5, -15, 45)), look(square_wall(IDS), Stand(1.9, -0.5, 15, -46)))


@lru_cache(maxsize=None)
def _dark() -> tuple[View, ...]:
    random = np.random.RandomState(3)
    views = []
    for view, grain in zip((*noisy_views(), look(square_wall(IDS), Stand(2.4, 0.3, -8, 4))), GRAINS):
        frame = LIGHT * view.frame + random.normal(0, grain, view.frame.shape)
        views.append(replace(view, frame=np.asarray(np.clip(frame, 0, 255), np.uint8)))
    return tuple(views)
