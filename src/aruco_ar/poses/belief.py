"""Which of two possible poses a flat object has, judged by all frames together.

A square looks nearly the same from the left as from the right. So two poses
explain its corners almost equally well. How well each pose explains them is
evidence. Evidence from several frames adds up, since the camera moves steadily
and does not leap from one side of the object to the other. When the camera is
right in front of the object, both poses are the same. From there on, only new
evidence counts.
"""
from __future__ import annotations

from typing import Hashable, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats, Integers, Pose
from aruco_ar.base.recent import Recent
from aruco_ar.geometry.plane_pose import cross_matrices, rotation_vector

SPEED_M_S = 1.0      # the standard deviation of the camera's speed relative to the object
# The errors of corners repeat from frame to frame. So evidence decays with this time constant, and counts only
# this part of what it would count if the errors were independent.
MEMORY_S = 0.5
EVIDENCE = 0.5
LEAP = 1e-4          # the probability that the camera has moved in any other way
SWITCH = 0.9         # the other pose must be at least this probable to become the believed one
GAP_S = 0.5          # if an object was out of sight for longer, its earlier evidence is not used
SAME = 0.1           # two poses are the same if they differ by less than this share of a pose's variance
MIN_LOG_WEIGHT = -60.0  # the natural logarithm of the smallest weight


class Belief:
    """The evidence for the poses of objects, by their keys, up to when they were last in sight."""

    def __init__(self) -> None:
        # For each key: the time; for both poses the logarithm of the weight, the camera's place, and the
        # covariance of that place; and which pose was believed.
        self._before: Recent[Hashable, tuple[float, Floats, Floats, Floats, int]] = Recent()

    def weigh(self, keys: Sequence[Hashable], poses: Pose, costs: Floats,
              now: float) -> tuple[Integers, Floats]:
        """Which pose of each object to believe, (n,) int, and the weight of the other one, (n,), 0 to 0.5.

        ``poses``: both of each object, rotations (n, 2, 3, 3), translations
        (n, 2, 3) and covariances (n, 2, 6, 6). ``costs``: (n, 2), the squared
        errors of each pose. ``now``: seconds.
        """
        rotation, translation, covariance = poses
        inverse = rotation.swapaxes(-1, -2)
        place = -(inverse @ translation[..., None])[..., 0]  # the camera's place in the object's own axes
        jacobian = np.concatenate([inverse, inverse @ cross_matrices(translation)], axis=-1)
        spread = jacobian @ covariance @ jacobian.swapaxes(-1, -2)
        weight = np.maximum(-EVIDENCE / 2 * (costs - costs.min(axis=1, keepdims=True)), MIN_LOG_WEIGHT)
        believed = np.argmax(weight, axis=1)
        old = [number for number, key in enumerate(keys)
               if key in self._before and 0 <= now - self._before[key][0] <= GAP_S]
        if old:
            weight[old], believed[old] = self._with_history([keys[number] for number in old], weight[old],
                                                       place[old], spread[old], now)
        weight -= np.logaddexp(weight[:, 0], weight[:, 1])[:, None]
        every = np.arange(len(keys))
        believed = np.where(weight[every, 1 - believed] > np.log(SWITCH), 1 - believed, believed)
        for number, key in enumerate(keys):
            self._before[key] = now, weight[number], place[number], spread[number], believed[number]
        return believed, np.minimum(np.exp(weight[every, 1 - believed]), 0.5)

    def _with_history(self, keys: Sequence[Hashable], weight: Floats, place: Floats, spread: Floats,
                      now: float) -> tuple[Floats, Integers]:
        """The weights with the earlier evidence, (n, 2), and which pose continues the believed one, (n,).

        ``weight``: (n, 2), the logarithms of the weights by this frame alone. ``place``: (n, 2, 3), where the
        camera is in each object's axes. ``spread``: (n, 2, 3, 3), the covariance of that place.
        """
        times, known, places, spreads, believed = (np.array(part) for part in
                                                   zip(*(self._before[key] for key in keys)))
        passed = now - times
        moved = place[:, None] - places[:, :, None]             # (n, before, now, 3)
        covariance = spread[:, None] + spreads[:, :, None] + \
            (np.eye(3) * SPEED_M_S**2) * (passed**2 + 1e-6)[:, None, None, None, None]
        scaled = np.linalg.solve(covariance, moved[..., None])[..., 0]
        squared_distance = np.einsum('...i,...i->...', moved, scaled)
        log_likelihood = -(squared_distance + np.linalg.slogdet(covariance)[1]) / 2
        log_likelihood -= log_likelihood.max(axis=(1, 2), keepdims=True)
        log_likelihood = np.logaddexp(log_likelihood, np.log(LEAP))
        known = known * np.exp(-passed / MEMORY_S)[:, None]
        successor = np.argmax(log_likelihood[np.arange(len(keys)), believed], axis=1)
        history = np.logaddexp(known[:, 0, None] + log_likelihood[:, 0],
                               known[:, 1, None] + log_likelihood[:, 1])
        return weight + history, successor


def mixture(one: Pose, other: Pose, weight: Floats | float) -> tuple[Floats, Floats]:
    """The covariance of poses, (..., 6, 6), which allows for the other poses, and the weights of those, (...).

    ``one``, ``other``: poses (rotation, translation, covariance), each with any
    axes in front. ``weight``: (...), the weights of the other poses. A returned
    weight is 0 if the two poses cannot be told apart.
    """
    turn = rotation_vector(other[0] @ one[0].swapaxes(-1, -2))
    leap = np.concatenate([other[1] - one[1], turn], axis=-1)
    alike = (turn * turn).sum(axis=-1) < SAME * np.einsum('...ii->...', one[2][..., 3:, 3:])
    weight = np.where(alike, 0.0, weight)
    share = weight[..., None, None]
    return (1 - share) * one[2] + share * (other[2] + leap[..., None] * leap[..., None, :]), weight
