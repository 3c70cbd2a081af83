"""The motion of the area: a Kalman filter of its four corners and their speeds.

Points of the wall are given in the plane of the area: its corners are (0, 0),
(1, 0), (1, 1), (0, 1). The four corners in the frame determine the homography
from that plane to the frame. So the corners and their speeds are the whole
state. Every tag on the plane corrects it, wherever it is. Four tags determine
all corners. One tag determines the place and the size near itself; the slant
of the far side stays as predicted from the frame before.

The model of the motion, its numbers and the arithmetic are in motion.c.
"""
from __future__ import annotations

from copy import copy
from typing import Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.compiled import binding

# Where the parts are in the array that is the state: those of the structure Motion in unit5.h.
PLACE, SPEED, MIDDLE = slice(0, 8), slice(8, 16), slice(336, 338)


class AreaMotion:
    """The area's corners, their speeds, and how well both are known."""

    def __init__(self, corners: Floats, size: Sequence[int], points: Floats, pixels: Floats,
                 deviation: Floats, bias: Floats) -> None:
        """Start with an area just found.

        ``corners``: (4, 2) pixels. ``size``: width and height of the frame. The others are the measurement by
        which the area was found: see ``correct``.
        """
        self._state = np.zeros(binding.MOTION)
        self._state[PLACE] = np.ravel(corners)
        self._state[MIDDLE] = (size[0] - 1) / 2, (size[1] - 1) / 2
        binding.start_motion(self._state, points, deviation, bias)

    @property
    def corners(self) -> Floats:
        """(4, 2) float64, pixels."""
        return self._state[PLACE].reshape(4, 2).copy()

    @property
    def deviation(self) -> Floats:
        """(4,) pixels: the standard deviation of each corner's place.

        It includes the noise, which averages out over the frames, and the
        biases, which do not. Biases are large at a corner that is known only
        from a small tag far away.
        """
        return binding.find_deviation(self._state)

    @property
    def speed(self) -> float:
        """Pixels per second: the speed of the fastest corner."""
        speed = self._state[SPEED].tolist()
        return max(np.hypot(x, y) for x, y in zip(speed[::2], speed[1::2]))

    def predict(self, seconds: float, calm: bool = False) -> None:
        """Predict the corners after that time. ``calm``: nothing was seen lately, so the speed decays."""
        binding.predict_motion(self._state, seconds, calm)

    def after_jerk(self) -> AreaMotion:
        """A copy whose uncertainty allows for a jerk of the camera just now."""
        other = copy(self)
        other._state = self._state.copy()
        binding.jerk_motion(other._state)
        return other

    def corrected(self, points: Floats, pixels: Floats, deviation: Floats, bias: Floats) -> AreaMotion:
        """A copy that is corrected by a measurement; see ``correct``."""
        other = copy(self)
        other._state = self._state.copy()
        other.correct(points, pixels, deviation, bias)
        return other

    def project(self, points: Floats) -> Floats:
        """(..., 2) pixels: where points of the plane, (..., 2), are in the frame."""
        return binding.project(self._state, points)

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
        return binding.correct_motion(self._state, points, pixels, deviation, bias, limit)

    def unlikeliness(self, points: Floats, pixels: Floats, deviation: Floats) -> float:
        """How unlikely a measurement is (see ``correct``): about 1 if the model fits.

        It is the squared Mahalanobis distance, divided by how many numbers were measured. Biases in all frames
        so far are taken as a part of what was uncertain.
        """
        return binding.unlikeliness(self._state, points, pixels, deviation)
