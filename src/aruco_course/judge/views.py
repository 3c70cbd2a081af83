"""The frames that exercises are judged by: rendered views of walls with tags, and where the tags truly are."""
from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Extrinsics, Floats, Image
from aruco_ar.geometry.ordering import order_coordinates
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.tags.tag import Tag
from aruco_ar.walls.wall import DICTIONARY, Wall, WallTag

from aruco_course.check import View

CAMERA = Camera()
WALL_M = 5.0, 2.2            # width and height of the walls
WALL_COLOR = (186, 203, 214)
SPAN_M = 0.9, 0.6            # distances of the centers of the four tags
MIDDLE_M = 0.0, 0.42         # of the four tags
SIDE_M = 0.2                 # of a tag
QUIET = 2                    # cells: with 1, OpenCV before 4.7 takes the paper's outline for that of some tags
NOISE = 1.0                  # gray levels


class Stand(NamedTuple):
    """Where the camera is: ``away`` and to the left of the middle of the wall, meters, and how it is turned.

    ``heading``: to the left, degrees. ``roll``: clockwise about its axis, degrees: the frame turns the other
    way.
    """

    away: float
    left: float = 0.0
    heading: float = 0.0
    roll: float = 0.0


def square_wall(ids: Sequence[int], turns: Sequence[float] = (0, 0, 0, 0), side: float = SIDE_M,
                more: Sequence[WallTag] = ()) -> Wall:
    """A Wall with four tags at the corners of a rectangle, and ``more`` tags.

    ``ids``: of the tags at the top left, top right, bottom right and bottom left; fewer than four leave the
    last places empty. ``turns``: of each tag, clockwise, degrees. ``side``: of the tags, meters.
    """
    right, up = SPAN_M[0] / 2, SPAN_M[1] / 2
    places = (-right, up), (right, up), (right, -up), (-right, -up)
    tags = [WallTag(tag_id, MIDDLE_M[0] + x, MIDDLE_M[1] + y, side, turn)
            for tag_id, (x, y), turn in zip(ids, places, turns)]
    return Wall(*WALL_M, WALL_COLOR, DICTIONARY, QUIET, (*tags, *more), tuple(ids) if len(ids) == 4 else ())


def look(wall: Wall, stand: Stand, noise: float = NOISE) -> View:
    """What the camera sees of a Wall from a Stand. The View's tags are those of the wall, in its order.

    ``noise``: standard deviation, gray levels. It is the same in each View. All tags should be in sight.
    """
    rotation, translation = _extrinsics(stand)
    frame = WallRenderer(wall, CAMERA).render(rotation, translation)
    if noise > 0:
        frame = cv2.add(frame, np.asarray(np.round(noise * _noise()), np.int16), dtype=cv2.CV_8U)
    frame.flags.writeable = False  # the Views are kept, so nobody shall draw on them
    corners = [project(tag.corners, rotation, translation, CAMERA)[0] for tag in wall.tags]
    return View(frame, tuple(Tag(tag.id, np.asarray(quad, np.float32))
                             for tag, quad in zip(wall.tags, corners)))


def _extrinsics(stand: Stand) -> Extrinsics:
    rotation, translation = wall_to_camera(Pose(-stand.away, stand.left, np.radians(stand.heading)))
    roll = cv2.Rodrigues(np.array([0, 0, -np.radians(stand.roll)]))[0]
    return roll @ rotation, roll @ translation


@lru_cache(maxsize=None)
def _noise() -> Floats:
    """(h, w, 3) float32 of standard deviation 1."""
    random = np.random.RandomState(5)
    return np.asarray(random.standard_normal((CAMERA.height, CAMERA.width, 3)), np.float32)


# Ids of the four tags, their turns, and the camera. The ids are in no order around the area, are not always
# 1 to 4, and the tags are not always upright, so that neither an order by id nor a tag's own corner is
# right by chance. The camera rolls a little to either side.
_SCENES: tuple[tuple[tuple[int, ...], tuple[float, ...], Stand], ...] = (
    ((1, 2, 3, 4), (0, 0, 0, 0), Stand(1.6)),
    ((7, 1, 10, 4), (0, 0, 0, 0), Stand(1.7, 0.3, -8, 4)),
    ((3, 1, 4, 2), (90, 0, 180, 270), Stand(1.6, -0.4, 14, -5)),
    ((23, 142, 8, 61), (0, 180, 90, 0), Stand(1.9, 0.6, -16, 3)),
    ((4, 2, 1, 3), (180, 90, 0, 90), Stand(1.7, -0.1, 2, -9)),
    ((240, 17, 96, 5), (270, 270, 0, 180), Stand(2.1, -0.7, 19, 7)),
    ((2, 3, 4, 1), (0, 0, 0, 0), Stand(1.8, 0.5, -17, -3)),
    ((50, 77, 12, 200), (45, 10, 0, 300), Stand(1.8, 0.1, -3, 10)),
    ((9, 33, 0, 121), (90, 90, 90, 90), Stand(2.3, 0.2, -6, -7)),
    ((88, 4, 3, 19), (0, 270, 180, 90), Stand(1.5, 0.1, -5, 2)),
)


@lru_cache(maxsize=None)
def area_views() -> tuple[View, ...]:
    """Ten Views with four tags each, in the order top left, top right, bottom right, bottom left."""
    return tuple(look(square_wall(ids, turns), stand) for ids, turns, stand in _SCENES)


def centers_of(view: View) -> Floats:
    """(n, 2) float64, pixels of the frame: the tags' centers, in the order of the View's tags."""
    return np.array([tag.center for tag in view.tags], np.float64).reshape(-1, 2)


def area_of(view: View) -> Floats:
    """(4, 2) float64, pixels of the frame: four tags' centers from the top left one, clockwise.

    Raises InputError if there are not four.
    """
    return order_coordinates(centers_of(view))


def course_detect(image: Image) -> tuple[list[Floats], list[int], list[Floats]]:
    """What the course's own lines find: the tags' corners, (4, 2) each, their ids, and rejected candidates."""
    gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250),
                                       cv2.aruco.DetectorParameters())
    corners, ids, rejected = detector.detectMarkers(gray)
    return ([np.asarray(quad[0]) for quad in corners], [] if ids is None else [int(i) for i in ids.ravel()],
            [np.asarray(quad[0]) for quad in rejected])
