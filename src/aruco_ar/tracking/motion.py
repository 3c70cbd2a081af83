"""Where the area is and how it moves: a Kalman filter over its four corners.

Points of the wall are given in the plane of the area: its corners are (0, 0),
(1, 0), (1, 1), (0, 1). Four corners in the frame fix the homography from that
plane to the frame, so they and their speeds are all there is to know. A tag
anywhere on the plane corrects them as far as what it shows depends on them:
four tags fix all; one fixes the place and the size near itself, and leaves the
slant of the far side to what was known a frame ago.
"""
from __future__ import annotations

from copy import copy
from typing import Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.geometry.homography import homography_to, transform

# How much speeds change within a second: what robots and hands do. The frame
# moves as a rigid camera that faces a plane would move it; what moves fast also
# changes its speed fast ...
TURN = 0.1        # rad/s: pan, tilt, roll
TRAVEL = 0.05     # distances to the wall per second: to the side, up, forward
SWIFT = 1.0       # times the speed that it has, on top
# ... and a little otherwise, since neither slant nor lens is known.
OTHER = 0.005     # widths of the frame per second
FIRST = 1.5       # rad/s and distances per second, the speed that an area just found may have
FOCAL = 0.87      # widths of the frame, the focal length assumed for that
CALM_S = 1.0      # with no tag in sight, the motion dies away within about this time
SHAKEN = 0.05, 0.03  # rad and distances to the wall: how far a shaken camera may have turned and moved
CLOSE_PX = 0.5    # a correction by more than this is worth another step


class AreaMotion:
    """The area's corners, their speeds, and how well both are known."""

    def __init__(self, corners: Floats, size: Sequence[int], points: Floats, pixels: Floats,
                 deviation: Floats, bias: Floats) -> None:
        """An area just found at corners, in a frame of that size, by what was seen (see correct)."""
        self._middle, self._focal = (np.array(size) - 1) / 2, FOCAL * size[0]
        self._place = np.array(corners, np.float64).ravel()
        self._speed = np.zeros(8)
        _, slope = self._linearize(points)
        weighted = (slope / np.repeat(deviation, 2)[:, None]**2).T
        self._covariance = np.zeros((16, 16))
        self._covariance[:8, :8] = np.linalg.inv(weighted @ slope + np.eye(8) / self._focal**2)
        # Pixels, (8, 8): by how much the corners are off for what is off in the same way in every frame, the
        # four corners of a tag each in its own way, but all tags alike.
        self._biased = _summed(self._covariance[:8, :8] @ weighted, bias)
        self._covariance[8:, 8:] = self._agility(FIRST)

    @property
    def corners(self) -> Floats:
        """(4, 2) float64, pixels."""
        return self._place.reshape(4, 2).copy()

    @property
    def deviation(self) -> Floats:
        """(4,) pixels: the standard deviation of each corner's place.

        Errors that are new in each frame and that fade with their number, and
        those that stay, which one small tag far from a corner makes large ones.
        """
        fading = self._covariance.diagonal()[:8]
        staying = (self._biased * self._biased).sum(axis=1)
        return np.sqrt(np.maximum((fading + staying).reshape(4, 2).sum(axis=1), 0))

    @property
    def speed(self) -> float:
        """Pixels per second of the fastest corner."""
        return np.linalg.norm(self._speed.reshape(4, 2), axis=1).max()

    def predict(self, seconds: float, calm: bool = False) -> None:
        """Move on by that time. ``calm``: nothing was seen lately, so let the motion die away."""
        if calm:
            self._speed = self._speed * np.exp(-seconds / CALM_S)
        self._place = self._place + seconds * self._speed
        p, change = self._covariance, self._agility() * seconds
        drift = seconds * p[8:, :8]
        p[:8, :8] += drift + drift.T + seconds**2 * p[8:, 8:] + change * (seconds**2 / 3)
        p[8:, :8] += seconds * p[8:, 8:] + change * (seconds / 2)
        p[:8, 8:] = p[8:, :8].T
        p[8:, 8:] += change

    def shaken(self) -> AreaMotion:
        """The AreaMotion after what may have been a jerk of the camera, which leaves the plane as it was."""
        jerk = self._moves(self._place.reshape(4, 2)) @ CAMERA_MOVES * np.repeat(SHAKEN, 3)
        other = copy(self)
        other._covariance = self._covariance.copy()
        other._covariance[:8, :8] += jerk @ jerk.T
        other._covariance[8:, 8:] += self._agility(FIRST)
        return other

    def see(self, points: Floats) -> Floats:
        """(..., 2) pixels: where points of the plane, (..., 2), are."""
        return transform(homography_to(self._place.reshape(4, 2)), points)

    def correct(self, points: Floats, pixels: Floats, deviation: Floats, bias: Floats,
                limit: float = np.inf) -> bool:
        """Take in that points of the plane, (n, 2), four of each tag, are seen at pixels, (n, 2).

        ``deviation``: (n,) pixels, how far off that may be, otherwise in each
        frame; ``bias``: the same in every frame. False, and nothing is taken
        in, if it is more unlikely than ``limit`` (see unlikeliness).
        """
        before, p = self._place, self._covariance
        weighed = self._weigh(points, pixels, deviation, before, p)
        if weighed[4] > limit:
            p = self._with_staying()  # what is seen now may show that the corners were off in every frame
            weighed = self._weigh(points, pixels, deviation, before, p)
            if weighed[4] > limit:
                return False
        for attempt in range(3):
            if attempt:
                weighed = self._weigh(points, pixels, deviation, before, p)
            known, weighted, shrink, toward, _ = weighed
            change = p[:, :8] @ toward
            step = before + change[:8] - self._place
            self._place = before + change[:8]
            if np.abs(step).max() < CLOSE_PX:
                break
        self._speed = self._speed + change[8:]
        gain = p[:8, :8] @ shrink
        self._biased = self._biased - gain @ (known @ self._biased) + gain @ _summed(weighted, bias)
        p = p - p[:, :8] @ (shrink @ known) @ p[:8]
        self._covariance = (p + p.T) / 2
        return True

    def unlikeliness(self, points: Floats, pixels: Floats, deviation: Floats) -> float:
        """How unlikely it is to see what ``correct`` takes: about 1 if all is well.

        It is the squared Mahalanobis distance for each number measured.
        """
        return self._weigh(points, pixels, deviation, self._place, self._with_staying())[4]

    def _with_staying(self) -> Floats:
        """The covariance, (16, 16), with the errors that stay."""
        p = self._covariance.copy()
        p[:8, :8] += self._biased @ self._biased.T
        return p

    def _weigh(self, points: Floats, pixels: Floats, deviation: Floats,
               before: Floats, covariance: Floats) -> tuple[Floats, Floats, Floats, Floats, float]:
        """A measurement against what was believed before it, the corners ``before`` and their covariance.

        What it tells about the corners, as an inverse covariance (8, 8), and
        each number by itself (8, 2n); what
        is left of that beside what was believed (8, 8); the change of the
        corners that both ask for, still to be multiplied by the covariance,
        (8,); and how unlikely it is. Eight corners' numbers are inverted in
        place of the many measured: the information form of the filter.
        """
        seen, slope = self._linearize(points)
        weight = np.repeat(deviation ** -2.0, 2)
        weighted, p = slope.T * weight, covariance[:8, :8]
        known = weighted @ slope
        shrink = np.linalg.inv(np.eye(8) + known @ p)
        off = (pixels - seen).ravel() + slope @ (self._place - before)
        asked: Floats = weighted @ off
        toward = shrink @ asked
        return known, weighted, shrink, toward, (off @ (weight * off) - asked @ p @ toward) / len(off)

    def _linearize(self, points: Floats) -> tuple[Floats, Floats]:
        """Where points of the plane, (n, 2), are seen, and how that changes with the corners, (2n, 8)."""
        seen = self.see(points)
        moves = self._moves(np.vstack([self._place.reshape(4, 2), seen]))
        return seen, moves[8:] @ np.linalg.inv(moves[:8])

    def _moves(self, pixels: Floats) -> Floats:
        """(2n, 8): how (n, 2) pixels move under each of the eight infinitesimal homographies.

        Two shifts, four that are linear, and two of perspective.
        """
        x, y = ((pixels - self._middle) / self._focal).T
        moves = np.zeros((len(pixels), 2, 8))
        moves[:, 0, 0] = moves[:, 1, 1] = self._focal
        moves[:, 0, 2] = moves[:, 1, 3] = self._focal * x
        moves[:, 0, 4] = moves[:, 1, 5] = self._focal * y
        moves[:, 0, 6], moves[:, 1, 7] = moves[:, 0, 2] * x, moves[:, 1, 5] * y
        moves[:, 1, 6] = moves[:, 0, 7] = moves[:, 0, 2] * y
        return moves.reshape(-1, 8)

    def _agility(self, swift: float = 0.0) -> Floats:
        """(8, 8): how much the speeds of the corners may change within a second, as a covariance."""
        swift = max(swift, SWIFT * np.sqrt(self._speed @ self._speed / 4) / self._focal)
        moves = self._moves(self._place.reshape(4, 2)) @ CAMERA_MOVES
        agility = moves * ([TURN + swift] * 3 + [TRAVEL + swift] * 3)
        return agility @ agility.T + np.eye(8) * (OTHER * self._focal / FOCAL)**2


def _summed(effect: Floats, bias: Floats) -> Floats:
    """(8, 8): the effect, (8, 2n), of n points, four of each tag, being off by (n,) pixels, all tags alike."""
    return (effect * np.repeat(bias, 2)).reshape(8, -1, 8).sum(axis=1)


# A camera's motion in those eight: pan, tilt, roll; to the side, up, forward.
CAMERA_MOVES = np.array([[1, 0, 0, 1, 0, 0], [0, 1, 0, 0, 1, 0],
                         [0, 0, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0],
                         [0, 0, -1, 0, 0, 0], [0, 0, 0, 0, 0, 1],
                         [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0]], np.float64)
