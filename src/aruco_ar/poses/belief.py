"""Which of its two poses a flat thing has: what frame after frame says about it, taken together.

A square seen from somewhat left of it looks nearly as from as much right of
it, so two poses explain its corners almost equally well. How well each does is
evidence. And the camera, as seen from the thing, moves on from where it was
and does not leap to the other side: so frames add up. Where the camera passes
right before the thing both poses are the same, and from then on only what is
seen anew counts.
"""
from __future__ import annotations

from typing import Hashable, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats, Integers, Pose
from aruco_ar.base.recent import Recent
from aruco_ar.geometry.plane_pose import cross_matrices, rotation_vector

SPEED_M_S = 1.0      # of the camera past the thing: a standard deviation
MEMORY_S = 0.5       # evidence fades within about this time, since errors repeat from frame to frame,
EVIDENCE = 0.5       # and counts as so much of what independent errors would say
LEAP = 1e-4          # how likely it is that it was anywhere else
SURE = 0.9           # the other pose has to be as likely as that to become the one that is believed
GAP_S = 0.5          # after as long without a sight all begins anew
SAME = 0.1           # of the variance of a pose: one that is no farther off is the same
IMPOSSIBLE = -60.0   # natural logarithm of a likelihood of which nothing is left


class Belief:
    """What was believed about things, by their keys, when they were last in sight."""

    def __init__(self) -> None:
        self._before: Recent[Hashable, tuple[float, Floats, Floats, Floats, int]] = Recent()

    def weigh(self, keys: Sequence[Hashable], poses: Pose, costs: Floats,
              now: float) -> tuple[Integers, Floats]:
        """Which pose of each thing to believe, (n,) int, and the weight of the other, (n,), 0 to 0.5.

        ``poses``: both of each, rotations (n, 2, 3, 3), translations (n, 2, 3)
        and covariances (n, 2, 6, 6). ``costs``: (n, 2), their squared
        deviations from what is seen. ``now``: seconds.
        """
        rotation, translation, covariance = poses
        toward = rotation.swapaxes(-1, -2)
        place = -(toward @ translation[..., None])[..., 0]  # the camera's, in the thing's own axes
        moves = np.concatenate([toward, toward @ cross_matrices(translation)], axis=-1)
        spread = moves @ covariance @ moves.swapaxes(-1, -2)
        weight = np.maximum(-EVIDENCE / 2 * (costs - costs.min(axis=1, keepdims=True)), IMPOSSIBLE)
        believed = np.argmax(weight, axis=1)
        old = [number for number, key in enumerate(keys)
               if key in self._before and 0 <= now - self._before[key][0] <= GAP_S]
        if old:
            weight[old], believed[old] = self._carried([keys[number] for number in old], weight[old],
                                                       place[old], spread[old], now)
        weight -= np.logaddexp(weight[:, 0], weight[:, 1])[:, None]
        every = np.arange(len(keys))
        believed = np.where(weight[every, 1 - believed] > np.log(SURE), 1 - believed, believed)
        for number, key in enumerate(keys):
            self._before[key] = now, weight[number], place[number], spread[number], believed[number]
        return believed, np.minimum(np.exp(weight[every, 1 - believed]), 0.5)

    def _carried(self, keys: Sequence[Hashable], weight: Floats, place: Floats, spread: Floats,
                 now: float) -> tuple[Floats, Integers]:
        """The weights, with what was known before about those things; and what follows what was believed."""
        times, known, places, spreads, believed = (np.array(part) for part in
                                                   zip(*(self._before[key] for key in keys)))
        passed = now - times
        moved = place[:, None] - places[:, :, None]             # (n, before, now, 3)
        room = spread[:, None] + spreads[:, :, None] + \
            (np.eye(3) * SPEED_M_S**2) * (passed**2 + 1e-6)[:, None, None, None, None]
        far = np.einsum('...i,...i->...', moved, np.linalg.solve(room, moved[..., None])[..., 0])
        leads = -(far + np.linalg.slogdet(room)[1]) / 2
        leads = np.logaddexp(leads - leads.max(axis=(1, 2), keepdims=True), np.log(LEAP))
        known = known * np.exp(-passed / MEMORY_S)[:, None]
        follows = np.argmax(leads[np.arange(len(keys)), believed], axis=1)
        return weight + np.logaddexp(known[:, 0, None] + leads[:, 0], known[:, 1, None] + leads[:, 1]), follows


def mixture(one: Pose, other: Pose, weight: float) -> tuple[Floats, float]:
    """How far off the first of two poses may be, (6, 6), if with that weight the other one is right.

    Each is (rotation, translation, covariance). Returned with the weight, which
    is none if the two are the same as far as anybody can tell.
    """
    leap = np.concatenate([other[1] - one[1], rotation_vector(other[0] @ one[0].T)])
    if leap[3:] @ leap[3:] < SAME * np.trace(one[2][3:, 3:]):
        return one[2], 0.0
    return (1 - weight) * one[2] + weight * (other[2] + np.outer(leap, leap)), float(weight)
