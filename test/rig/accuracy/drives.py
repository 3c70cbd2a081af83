"""Simulated drives past the wall, with the true area in every frame."""
import os
from collections import namedtuple
from dataclasses import replace

import numpy as np
from aruco_ar.simulation.render import WallRenderer, project_rows
from aruco_ar.simulation.robot import Camera, Path, Pose, hand_held, wall_to_camera
from aruco_ar.walls.wall import Poster, load_wall

from rig import PACKAGE

WALL = load_wall(os.path.join(PACKAGE, 'config', 'wall.yaml'))
# The same with a painting, and tags with narrow margins on it.
PAINTING = replace(WALL, quiet=0.4,
                   posters=(Poster(os.path.join(PACKAGE, 'images', 'earth.jpg'), 0, 0.55, 1.5, 1.0),))
FRAMES_PER_S = 30
CYCLE = 120  # frames: tags are in sight during the first half, and covered during the second, for 2 s


def _there_and_back(start, *legs):
    """The Path along these legs, (seconds, m/s, rad/s) each, and back the same way."""
    return Path(start, legs + tuple((seconds, -linear, -angular) for seconds, linear, angular in legs[::-1]))


# All tags stay in view on these paths, unless they are covered.
STILL = Path(Pose(-2.2, 0.1, -0.05), ((1000, 0, 0),))
SLOW = _there_and_back(Pose(-2.2, 0.25, -0.05), (3, 0.1, -0.06), (3, 0.1, 0.06))
LIVELY = _there_and_back(Pose(-2.5, 0.2, -0.1), (2, 0.3, 0.1), (1, 0.2, -0.3), (1, 0, 0.3), (1, -0.3, 0.1))
# LIVELY from farther away, for frames of 16:9, which show less above and below.
WIDE = _there_and_back(Pose(-3.1, 0.2, -0.1), (2, 0.3, 0.1), (1, 0.2, -0.3), (1, 0, 0.3), (1, -0.3, 0.1))
FAST = _there_and_back(Pose(-2.8, 0, -0.25), (1, 0.5, 0.5), (1, 0.5, -0.5))

# ``stamp``: seconds. ``corners``: (4, 2) pixels, the area's true corners.
# ``counts``: whether the measurement includes this frame.
Frame = namedtuple('Frame', 'stamp image corners counts')


def drive(path, count, covered=lambda number: (), counts=lambda number: True, size=(640, 480), wall=WALL,
          hand=0.0, shutter=0.0, exposure=lambda number: 1.0, distortion=(0,) * 5, fisheye=False, **look):
    """Yield the Frames of a drive along a path.

    ``covered``, ``counts``, ``exposure``: functions of the frame's number; the
    first returns the ids of the covered tags. ``hand``: how unsteady the camera
    is, see hand_held. ``shutter``: the milliseconds in which the rows of a frame
    are read. ``distortion``, ``fisheye``: see Camera. ``look``: see WallRenderer.
    """
    camera = Camera(*size, distortion=list(distortion), fisheye=fisheye)
    renderer = WallRenderer(wall, camera, **look)

    def view_at(seconds):
        return hand_held(wall_to_camera(path.at(seconds)[0]), seconds, hand)
    for number in range(count):
        seconds = number / FRAMES_PER_S
        first, last = view_at(seconds), view_at(seconds + shutter / 1000)
        image = renderer.render(*first, covered=covered(number), exposure=exposure(number),
                                last=last if shutter else None)
        yield Frame(seconds, image, project_rows(wall.area_corners, first, last, camera)[0], counts(number))


def in_turn(groups):
    """``covered`` and ``counts`` for a drive that covers one group of tags after the other, for 2 s each."""
    def is_covered(number):
        return number % CYCLE >= CYCLE // 2

    def covered(number):
        return groups[number // CYCLE % len(groups)] if is_covered(number) else ()
    return covered, is_covered


def at_random(count, seed, share=0.3, longest=20):
    """``covered`` for a drive that covers each tag independently, at random times.

    A tag is covered for 1 to ``longest`` frames at a time, and for that share of all frames.
    """
    random = np.random.RandomState(seed)
    hidden = np.zeros((count, len(WALL.area)), bool)
    visible = (1 + longest) / 2 * (1 - share) / share  # mean number of frames in between
    for tag in range(len(WALL.area)):
        number = random.geometric(1 / visible)
        while number < count:
            length = random.randint(1, longest + 1)
            hidden[number:number + length, tag] = True
            number += length + random.geometric(1 / visible)
    return lambda number: [WALL.area[tag] for tag in np.flatnonzero(hidden[number])]
