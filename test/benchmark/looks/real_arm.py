"""A real arm that writes: cut out of a published clip, in front of a sheet of paper on the simulated wall."""
import os
import tempfile
from dataclasses import replace

import cv2
import numpy as np
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import wall_to_camera
from aruco_ar.walls.wall import Poster
from rig.accuracy.drives import WALL

from .scenes import FRAMES_PER_S, PATH, Moment, Scene

CLIP, FRAME = 'pushed.mp4', 26  # an arm in a black sleeve lies on a light floor
# Pixels of that frame: around all of the arm, and within its sleeve and its hand.
AROUND = [(0, 325), (60, 345), (420, 515), (540, 545), (560, 595), (640, 622), (720, 625), (770, 620),
          (830, 610), (860, 660), (850, 700), (800, 760), (745, 795), (700, 780), (600, 720), (500, 715),
          (400, 700), (150, 650), (0, 632)]
SLEEVE = [(0, 360), (60, 390), (400, 540), (515, 570), (520, 690), (400, 680), (150, 620), (0, 610)]
HAND = [(530, 610), (620, 650), (680, 660), (760, 670), (820, 655), (835, 665), (790, 690), (815, 700),
        (800, 730), (745, 770), (700, 750), (630, 700), (540, 690)]
ROUNDS = 8                # of GrabCut
TIP = 848, 660            # the tip of the thumb
BRIGHTER = 1.25           # the clip is darker than the wall
SCALE, TURN = 0.5, 186.0  # of the arm in the frame; degrees, so that it comes from the right
SHEETS = ('flat sheet', 0.0), ('creased sheet', 0.3), ('crumpled sheet', 1.0)  # and how deep its creases are
SHEET_AT = 0, 0.6, 1.6, 1.2  # left and foot, width and height on the wall, meters
SHEET_PX = 800, 600
CREASES = ((150, 45.0), (60, 10.0), (20, 1.8))  # distances in pixels, and heights


def cut_out(frame):
    """(h, w, 4) float32 BGRA: the arm in that frame of the clip. GrabCut finds its outline."""
    marks = np.full(frame.shape[:2], cv2.GC_BGD, np.uint8)
    for outline, mark in (AROUND, cv2.GC_PR_BGD), (SLEEVE, cv2.GC_FGD), (HAND, cv2.GC_PR_FGD):
        cv2.fillPoly(marks, [np.array(outline)], mark)
    cv2.grabCut(frame, marks, None, np.zeros((1, 65)), np.zeros((1, 65)), ROUNDS, cv2.GC_INIT_WITH_MASK)
    inside = np.isin(marks, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(inside)
    arm = (labels == 1 + np.argmax(stats[1:, cv2.CC_STAT_AREA])).astype(np.uint8) * 255
    arm = cv2.erode(cv2.morphologyEx(arm, cv2.MORPH_CLOSE, np.ones((7, 7))), np.ones((3, 3)))
    return np.dstack([BRIGHTER * frame, cv2.GaussianBlur(arm, (0, 0), 1.2)]).astype(np.float32)


def crumpled(depth):
    """A white sheet, (h, w, 3) BGR uint8, with creases that are lit from the left."""
    width, height = SHEET_PX
    random, relief = np.random.RandomState(3), np.zeros((height, width))
    for away, deep in CREASES:
        coarse = random.normal(0, 1, (height // away + 3, width // away + 3))
        relief += deep * np.abs(cv2.resize(coarse, SHEET_PX, interpolation=cv2.INTER_CUBIC))
    slope = 0.35 * cv2.Sobel(relief, -1, 1, 0) / 8 + 0.25 * cv2.Sobel(relief, -1, 0, 1) / 8
    light = cv2.GaussianBlur(np.clip(1 + depth * slope, 0.6, 1.15), (0, 0), 1)
    return np.clip(light[..., None] * (200, 203, 205), 0, 255).astype(np.uint8)


class ArmScene(Scene):
    """The arm writes on a sheet from the first frame on, and casts a shadow. ``depth``: of the creases."""

    def __init__(self, arm, depth):
        super().__init__()
        self._arm, self._sheet = arm, crumpled(depth)

    def moments(self, picture, seconds):
        """Yield the Moments of that many seconds. Only the frame with the arm is rendered."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'sheet.png')
            cv2.imwrite(path, self._sheet)
            wall = replace(WALL, posters=(Poster(path, *SHEET_AT),))
            renderer, random = WallRenderer(wall, self.camera), np.random.RandomState(1)
        for number in range(int(seconds * FRAMES_PER_S)):
            stamp = number / FRAMES_PER_S
            view = wall_to_camera(PATH.at(stamp)[0])
            colors, cover = self._arm_at(stamp)
            shadow = cv2.GaussianBlur(np.roll(cover, (9, 8), (0, 1)), (0, 0), 6)
            noise = random.normal(0, self._noise, (self.camera.height, self.camera.width, 3))
            light = 1 - 0.4 * shadow[..., None]
            bare = self._seen(renderer.render(*view), light, (colors, cover[..., None]), noise)
            yield Moment(stamp, bare, None, None, project(WALL.area_corners, *view, self.camera)[0], cover)

    def _arm_at(self, seconds):
        """(h, w, 3) and (h, w): the colors of the arm, and how much of each pixel it covers."""
        angle = np.radians(TURN + 4 * np.sin(5 * seconds))
        turn = SCALE * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        tip = np.array([270 + 60 * (seconds % 1.6) + 3 * np.sin(9 * seconds), 170 + 4 * np.sin(13 * seconds)])
        layer = cv2.warpAffine(self._arm, np.column_stack([turn, tip - turn @ TIP]),
                               (self.camera.width, self.camera.height), flags=cv2.INTER_AREA)
        return layer[..., :3], layer[..., 3] / 255
