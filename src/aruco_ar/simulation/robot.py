"""The simulated ROSbot: its motion, and the place of its camera.

Odometry coordinates are meters: x forward, y to the left, z up. The wall is in
the plane x = 0. A robot in front of it has a negative x, and a heading of 0 if
it faces the wall.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin, tan
from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Extrinsics, Floats
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import within, yaml_entries
from aruco_ar.geometry.lens import Lens

CAMERA_FORWARD_M = 0.08  # distance of the camera in front of the middle between the wheels
CAMERA_HEIGHT_M = 0.35

# Wall axes (right, up, out) as columns in odometry axes.
WALL_IN_ODOMETRY = np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]], np.float64)

# How a hand sways and trembles: turns about the camera's axes, rad; shifts along them, m; frequencies, Hz.
SWAY = np.array([0.010, 0.014, 0.008]), np.array([0.006, 0.008, 0.004]), np.array([0.7, 0.5, 0.3])
TREMOR = np.array([0.0012, 0.0012, 0.0008]), np.array([0.0004, 0.0004, 0.0002]), np.array([8.3, 7.1, 9.7])

MAX_LINEAR = 1.0    # top speed of a ROSbot, in m/s
MAX_ANGULAR = 7.33  # its fastest turn, in rad/s


class Pose(NamedTuple):
    """The robot's pose: x and y in meters, and its heading in radians, positive to the left."""

    x: float
    y: float
    heading: float


def drive(pose: Pose, linear: float, angular: float, seconds: float) -> Pose:
    """The Pose after driving at a constant speed, m/s and rad/s, exactly along an arc."""
    heading = pose.heading + angular * seconds
    if abs(angular) < 1e-9:
        return Pose(pose.x + linear * seconds * cos(pose.heading),
                    pose.y + linear * seconds * sin(pose.heading), heading)
    radius = linear / angular
    return Pose(pose.x + radius * (sin(heading) - sin(pose.heading)),
                pose.y - radius * (cos(heading) - cos(pose.heading)), heading)


@dataclass(frozen=True)
class Path:
    """A scripted drive from a start: legs of (seconds, linear m/s, angular rad/s), repeated forever."""

    start: Pose
    legs: tuple[tuple[float, float, float], ...]

    @property
    def seconds(self) -> float:
        """How long one round takes."""
        return sum(leg[0] for leg in self.legs)

    def at(self, seconds: float) -> tuple[Pose, float, float]:
        """(Pose, linear m/s, angular rad/s) that long after the start. Each round begins at the start again."""
        pose, left = self.start, seconds % self.seconds
        for duration, linear, angular in self.legs:
            if left < duration:
                return drive(pose, linear, angular, left), linear, angular
            pose, left = drive(pose, linear, angular, duration), left - duration
        return pose, 0.0, 0.0


def load_path(path: str) -> Path:
    """Read a Path from its YAML file (config/drive.yaml shows all there is).

    Raises InputError naming the file and what is wrong.
    """
    with yaml_entries(path) as data:
        start = Pose(*(within(data['start'][key], -100, 100) for key in ('x', 'y', 'heading')))
        legs = tuple((within(leg['seconds'], 0.001, 3600),
                      within(leg.get('linear', 0), -MAX_LINEAR, MAX_LINEAR),
                      within(leg.get('angular', 0), -MAX_ANGULAR, MAX_ANGULAR))
                     for leg in data['legs'])
    if not legs:
        raise InputError('The path "%s" has no legs; give at least one.' % path)
    return Path(start, legs)


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with the distortion of a lens.

    ``fov``: horizontal, radians, without the distortion. ``distortion``: k1, k2, p1, p2, k3 of OpenCV's
    plumb_bob, or k1, k2, k3, k4 of its fisheye model.
    """

    width: int = 640
    height: int = 480
    fov: float = 1.047
    distortion: list[float] = field(default_factory=lambda: [0.0] * 5)
    fisheye: bool = False

    @property
    def lens(self) -> Lens:
        """Its Lens."""
        return Lens(self.width, self.height, self.matrix, np.array(self.distortion, np.float64), self.fisheye)

    @property
    def matrix(self) -> Floats:
        """(3, 3) float64, K; the middle of the top left pixel is (0, 0)."""
        focal = self.width / 2 / tan(self.fov / 2)
        return np.array([[focal, 0, (self.width - 1) / 2], [0, focal, (self.height - 1) / 2],
                         [0, 0, 1]])


def wall_to_camera(pose: Pose) -> Extrinsics:
    """The view (R, t) of a camera on a robot with that pose: point in the optical frame = R @ wall point + t.

    R is (3, 3), t is (3,), meters. The optical frame has x to the right, y down, z forward.
    """
    c, s = cos(pose.heading), sin(pose.heading)
    axes = np.array([[s, -c, 0], [0, 0, -1], [c, s, 0]])
    place = np.array([pose.x + CAMERA_FORWARD_M * c, pose.y + CAMERA_FORWARD_M * s, CAMERA_HEIGHT_M])
    return axes @ WALL_IN_ODOMETRY, -axes @ place


def hand_held(view: Extrinsics, seconds: float, strength: float = 1.0) -> Extrinsics:
    """A view, (R, t), moved as a hand moves a camera at that time. ``strength``: how much, usually 1."""
    turn, shift = np.zeros(3), np.zeros(3)
    for turns, shifts, rate in SWAY, TREMOR:
        turn += strength * turns * np.sin(2 * np.pi * rate * seconds)
        shift += strength * shifts * np.sin(2 * np.pi * rate[::-1] * seconds + 1)
    by_hand = cv2.Rodrigues(turn)[0]
    return by_hand @ view[0], by_hand @ view[1] + shift


def view_between(first: Extrinsics, last: Extrinsics, part: float) -> Extrinsics:
    """The view, (R, t), between a first and a last one. ``part``: 0 for the first, 1 for the last."""
    turn = cv2.Rodrigues(last[0] @ first[0].T)[0]
    return cv2.Rodrigues(part * turn)[0] @ first[0], first[1] + part * (last[1] - first[1])
