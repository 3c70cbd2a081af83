"""What stands on a blank wall from the first frame on is in front once the wall is seen behind it."""
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import Area, area_mask
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Pose, wall_to_camera
from test_looks import FRAMES_PER_S, STRAIGHT, assert_in_front, hand, is_painted, painted, stage

pytestmark = pytest.mark.long
WHITE, RED, GRAY = (225, 228, 230), (40, 40, 170), (112, 116, 118)
WIDTH_M, HEIGHT_M = 0.3, 0.26


def box_of(depth):
    """(8, 3): the corners of a box that stands in the middle of the area, 0 if there were none."""
    return np.array([[x, y, z] for x in (-WIDTH_M / 2, WIDTH_M / 2) for y in (-HEIGHT_M / 2, HEIGHT_M / 2)
                     for z in (0, depth)])


def stone_of(depth):
    """(n, 3): points of an ellipsoid that lies there."""
    across, up = np.meshgrid(np.arange(0, 2 * np.pi, 0.1), np.arange(-1.6, 1.6, 0.1))
    return np.stack([WIDTH_M / 2 * np.cos(across) * np.cos(up), HEIGHT_M / 2 * np.sin(across) * np.cos(up),
                     depth / 2 * (1 + np.sin(up))], axis=-1).reshape(-1, 3)


class Round:
    """Frames from a camera that goes round something on a white wall. ``points``: of it; ``color``: BGR."""

    def __init__(self, wall, points, color):
        wall = replace(wall, color=WHITE)
        self._renderer, self._corners = WallRenderer(wall, STRAIGHT, noise=2.0), wall.area_corners
        self._points, self._color = points + self._corners.mean(axis=0), color

    def frame(self, number):
        """(the frame, (h, w) bool: where the thing is, the same: the inside of the area)."""
        aside = 0.1 + 0.7 * np.sin(2 * np.pi * number / (8 * FRAMES_PER_S))
        view = wall_to_camera(Pose(-1.9, aside, -aside / 2))
        frame = self._renderer.render(*view)
        outline = cv2.convexHull(np.float32(project(self._points, *view, STRAIGHT)[0]))
        cover = np.zeros(frame.shape[:2], np.uint8)
        cv2.fillConvexPoly(cover, np.int32(np.round(16 * outline)), (255,), cv2.LINE_8, 4)
        soft = cv2.GaussianBlur(cover, (0, 0), 0.7)[..., None] / 255
        frame = np.uint8(np.round(frame * (1 - soft) + np.array(self._color) * soft))
        area = Area(np.float32(project(self._corners, *view, STRAIGHT)[0]))
        return frame, cover > 0, cv2.erode(area_mask(frame, area)[..., 0], np.ones((5, 5))) == 255


@pytest.mark.parametrize('points, color', [(box_of(0.15), RED), (box_of(0.15), GRAY), (stone_of(0.2), GRAY)])
def test_a_thing_that_stands_there_comes_in_front_when_the_camera_goes_round_it(wall, points, color):
    camera, keeps = Round(wall, points, color), stage(foreground='keep')
    for number in range(5 * FRAMES_PER_S):
        frame, thing, inside = camera.frame(number)
        image = painted(keeps, frame, number)
        if number > 2 * FRAMES_PER_S:
            assert_in_front(image, frame, thing, inside)


def test_a_flat_patch_is_wall_though_the_camera_goes_round_and_a_hand_passes(wall):
    camera, keeps = Round(wall, box_of(0.0), RED), stage(foreground='keep')
    for number in range(6 * FRAMES_PER_S):
        frame, _, inside = camera.frame(number)
        if 3 * FRAMES_PER_S < number < 5 * FRAMES_PER_S:
            hand(frame, number)
        image = painted(keeps, frame, number)
        if not 3 * FRAMES_PER_S < number < 5 * FRAMES_PER_S:
            assert is_painted(image, inside) > 0.99
