"""The motion of the area: a Kalman filter of its four corners and their speeds.

Points of the wall are given in the plane of the area: its corners are (0, 0),
(1, 0), (1, 1), (0, 1). The four corners in the frame determine the homography
from that plane to the frame. So the corners and their speeds are the whole
state. Every tag on the plane corrects it, wherever it is. Four tags determine
all corners. One tag determines the place and the size near itself; the slant
of the far side stays as predicted from the frame before.
"""
from __future__ import annotations

from copy import copy
from typing import NamedTuple, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.geometry.homography import homography_to, transform

# How much the speeds change within a second, as standard deviations. The model is a
# rigid camera that faces a plane, moved by a robot or a hand.
TURN_CHANGE = 0.1      # rad/s: pan, tilt, roll
SHIFT_CHANGE = 0.05    # distances to the wall per second: sideways, up, forward
SPEED_FACTOR = 1.0     # this times the current speed is added to both, since fast motion also changes fast
# Since slant and lens are unknown, the corners also move a little in other ways.
OTHER_CHANGE = 0.005   # widths of the frame per second
FIRST_SPEED = 1.5      # assumed speed of an area just found, in rad/s and distances to the wall per second
FOCAL = 0.87           # assumed focal length, in widths of the frame
CURVE = 0.3            # the corners accelerate by this times speed squared / radius, as on a curve
CALM_S = 1.0           # without a tag in sight, the assumed speed decays with this time constant
JERK_TURN, JERK_SHIFT = 0.05, 0.03  # a sudden turn and shift of the camera, in rad and distances to the wall
CONVERGED_PX = 0.5     # after a correction by more than this, the measurement is linearized again
MAX_ITERATIONS = 3     # number of such linearizations in a correction, at most


class Comparison(NamedTuple):
    """What a measurement of n points, compared with the prediction, tells about the corners.

    This is the information form of the filter: it inverts an (8, 8) matrix, not a (2n, 2n) one.
    ``information``: (8, 8), how well the measurement alone determines them. ``weighted``: (8, 2n), the
    derivatives by which it does, divided by the measurement's variances. ``shrink``: (8, 8),
    inv(1 + information @ covariance). ``toward``: (8,), the correction of the corners, which is still to be
    multiplied by the covariance. ``unlikeliness``: see AreaMotion.unlikeliness.
    """

    information: Floats
    weighted: Floats
    shrink: Floats
    toward: Floats
    unlikeliness: float


class AreaMotion:
    """The area's corners, their speeds, and how well both are known."""

    def __init__(self, corners: Floats, size: Sequence[int], points: Floats, pixels: Floats,
                 deviation: Floats, bias: Floats) -> None:
        """Start with an area just found.

        ``corners``: (4, 2) pixels. ``size``: width and height of the frame. The others are the measurement by
        which the area was found: see ``correct``.
        """
        self._middle, self._focal = (np.array(size) - 1) / 2, FOCAL * size[0]
        self._place = np.array(corners, np.float64).ravel()
        self._speed = np.zeros(8)
        _, slope = self._linearize(points)
        weighted = (slope / np.repeat(deviation, 2)[:, None]**2).T
        self._covariance = np.zeros((16, 16))
        self._covariance[:8, :8] = np.linalg.inv(weighted @ slope + np.eye(8) / self._focal**2)
        # (8, 8) pixels: the corners' errors due to the biases, which are the same in every frame. Each column
        # is for one coordinate of one of a tag's four corners. All tags are off alike in it.
        self._biased = _bias_effect(self._covariance[:8, :8] @ weighted, bias)
        self._covariance[8:, 8:] = self._speed_change(FIRST_SPEED)

    @property
    def corners(self) -> Floats:
        """(4, 2) float64, pixels."""
        return self._place.reshape(4, 2).copy()

    @property
    def deviation(self) -> Floats:
        """(4,) pixels: the standard deviation of each corner's place.

        It includes the noise, which averages out over the frames, and the
        biases, which do not. Biases are large at a corner that is known only
        from a small tag far away.
        """
        noise = self._covariance.diagonal()[:8]
        bias = (self._biased * self._biased).sum(axis=1)
        return np.sqrt(np.maximum((noise + bias).reshape(4, 2).sum(axis=1), 0))

    @property
    def speed(self) -> float:
        """Pixels per second: the speed of the fastest corner."""
        return _longest(self._speed.reshape(4, 2))

    def predict(self, seconds: float, calm: bool = False) -> None:
        """Predict the corners after that time. ``calm``: nothing was seen lately, so the speed decays."""
        if calm:
            self._speed = self._speed * np.exp(-seconds / CALM_S)
        self._place = self._place + seconds * self._speed
        p, change = self._covariance, self._speed_change() * seconds
        turn = UNIT * (self._acceleration() * seconds)**2
        cross_term = seconds * p[8:, :8]
        p[:8, :8] += cross_term + cross_term.T + seconds**2 * (p[8:, 8:] + change / 3 + turn / 4)
        p[8:, :8] += seconds * (p[8:, 8:] + change / 2 + turn / 2)
        p[:8, 8:] = p[8:, :8].T
        p[8:, 8:] += change + turn

    def after_jerk(self) -> AreaMotion:
        """A copy whose uncertainty allows for a jerk of the camera just now."""
        jerk = self._moves(self._place.reshape(4, 2)) @ CAMERA_MOVES * np.repeat([JERK_TURN, JERK_SHIFT], 3)
        other = copy(self)
        other._covariance = self._covariance.copy()
        other._covariance[:8, :8] += jerk @ jerk.T
        other._covariance[8:, 8:] += self._speed_change(FIRST_SPEED)
        return other

    def project(self, points: Floats) -> Floats:
        """(..., 2) pixels: where points of the plane, (..., 2), are in the frame."""
        return transform(homography_to(self._place.reshape(4, 2)), points)

    def correct(self, points: Floats, pixels: Floats, deviation: Floats, bias: Floats,
                limit: float = np.inf) -> bool:
        """Correct the corners and speeds by a measurement.

        ``points``: (n, 2) of the plane, four for each tag. ``pixels``: (n, 2),
        where they are seen. ``deviation``: (n,) pixels, the standard deviation
        of the part of the error that is new in each frame. ``bias``: (n,)
        pixels, that of the part that is equal in all frames. Returns False
        and changes nothing if the measurement is more unlikely than ``limit``
        (see unlikeliness).
        """
        before, p = self._place, self._covariance
        compared = self._compare(points, pixels, deviation, before, p)
        if compared.unlikeliness > limit:
            p = self._covariance_with_bias()  # a bias in all frames so far may explain the difference
            compared = self._compare(points, pixels, deviation, before, p)
            if compared.unlikeliness > limit:
                return False
        for iteration in range(MAX_ITERATIONS):
            if iteration:
                compared = self._compare(points, pixels, deviation, before, p)
            change = p[:, :8] @ compared.toward
            step = before + change[:8] - self._place
            self._place = before + change[:8]
            if np.abs(step).max() < CONVERGED_PX:
                break
        self._speed = self._speed + change[8:]
        gain = p[:8, :8] @ compared.shrink
        self._biased = (self._biased - gain @ (compared.information @ self._biased)
                        + gain @ _bias_effect(compared.weighted, bias))
        p = p - p[:, :8] @ (compared.shrink @ compared.information) @ p[:8]
        self._covariance = (p + p.T) / 2
        return True

    def unlikeliness(self, points: Floats, pixels: Floats, deviation: Floats) -> float:
        """How unlikely a measurement is (see ``correct``): about 1 if the model fits.

        It is the squared Mahalanobis distance, divided by how many numbers were measured.
        """
        covariance = self._covariance_with_bias()
        return self._compare(points, pixels, deviation, self._place, covariance).unlikeliness

    def _covariance_with_bias(self) -> Floats:
        """The covariance, (16, 16), including the biases."""
        p = self._covariance.copy()
        p[:8, :8] += self._biased @ self._biased.T
        return p

    def _compare(self, points: Floats, pixels: Floats, deviation: Floats,
                 before: Floats, covariance: Floats) -> Comparison:
        """Compare a measurement with the prediction: the corners ``before``, (8,), and the covariance."""
        seen, slope = self._linearize(points)
        weight = np.repeat(deviation ** -2.0, 2)
        weighted, p = slope.T * weight, covariance[:8, :8]
        information = weighted @ slope
        shrink = np.linalg.inv(np.eye(8) + information @ p)
        off = (pixels - seen).ravel() + slope @ (self._place - before)
        gradient: Floats = weighted @ off
        toward = shrink @ gradient
        unlikeliness = (off @ (weight * off) - gradient @ p @ toward) / len(off)
        return Comparison(information, weighted, shrink, toward, unlikeliness)

    def _linearize(self, points: Floats) -> tuple[Floats, Floats]:
        """The pixels of points of the plane, (n, 2) each, and their derivatives by the corners, (2n, 8)."""
        seen = self.project(points)
        moves = self._moves(np.vstack([self._place.reshape(4, 2), seen]))
        return seen, moves[8:] @ np.linalg.inv(moves[:8])

    def _moves(self, pixels: Floats) -> Floats:
        """(2n, 8): how pixels, (n, 2), move under each of the eight infinitesimal homographies.

        Two of these are shifts, four are linear, and two change the perspective.
        """
        x, y = ((pixels - self._middle) / self._focal).T
        moves = np.zeros((len(pixels), 2, 8))
        moves[:, 0, 0] = moves[:, 1, 1] = self._focal
        moves[:, 0, 2] = moves[:, 1, 3] = self._focal * x
        moves[:, 0, 4] = moves[:, 1, 5] = self._focal * y
        moves[:, 0, 6], moves[:, 1, 7] = moves[:, 0, 2] * x, moves[:, 1, 5] * y
        moves[:, 1, 6] = moves[:, 0, 7] = moves[:, 0, 2] * y
        return moves.reshape(-1, 8)

    def _acceleration(self) -> float:
        """Pixels per second squared: the standard deviation of the corners' acceleration, from frame to frame.

        The prediction is a straight line, but a corner moves on a curve if the camera rolls or goes round. This
        hardly matters at 30 frames a second, but much at 4.
        """
        place = self._place.reshape(4, 2)
        radius = _longest(place - place.sum(axis=0) / 4)
        return CURVE * self.speed**2 / max(radius, 1)

    def _speed_change(self, speed: float = 0.0) -> Floats:
        """(8, 8): the covariance of the change of the corners' speeds within a second.

        ``speed``: rad/s and distances to the wall per second, the least speed that the camera may have.
        """
        speed = max(speed, SPEED_FACTOR * np.sqrt(self._speed @ self._speed / 4) / self._focal)
        moves = self._moves(self._place.reshape(4, 2)) @ CAMERA_MOVES
        change = moves * ([TURN_CHANGE + speed] * 3 + [SHIFT_CHANGE + speed] * 3)
        return change @ change.T + UNIT * (OTHER_CHANGE * self._focal / FOCAL)**2


def _longest(vectors: Floats) -> float:
    """The length of the longest of vectors, (n, 2)."""
    return float(np.sqrt((vectors * vectors).sum(axis=1).max()))


def _bias_effect(effect: Floats, bias: Floats) -> Floats:
    """(8, 8): the effect of biases that all tags have in common.

    ``effect``: (8, 2n), the effect of each coordinate of n points, four for each tag. ``bias``: (n,) pixels,
    that of each point.
    """
    return (effect * np.repeat(bias, 2)).reshape(8, -1, 8).sum(axis=1)


# The motions of a camera in terms of those eight: pan, tilt, roll; sideways, up, forward.
CAMERA_MOVES = np.array([[1, 0, 0, 1, 0, 0], [0, 1, 0, 0, 1, 0],
                         [0, 0, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0],
                         [0, 0, -1, 0, 0, 0], [0, 0, 0, 0, 0, 1],
                         [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0]], np.float64)
UNIT = np.eye(8)
