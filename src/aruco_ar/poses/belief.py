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
from aruco_ar.compiled import binding

NEW = np.full(binding.BELIEF_SIZE, np.nan)  # the memory of an object that was never seen


class Belief:
    """The evidence for the poses of objects, by their keys, up to when they were last in sight.

    The computation is in beliefs.c.
    """

    def __init__(self) -> None:
        self._memories: Recent[Hashable, Floats] = Recent()

    def weigh(self, keys: Sequence[Hashable], poses: Pose, costs: Floats,
              now: float) -> tuple[Integers, Floats]:
        """Which pose of each object to believe, (n,) int, and the weight of the other one, (n,), 0 to 0.5.

        ``poses``: both of each object, rotations (n, 2, 3, 3), translations
        (n, 2, 3) and covariances (n, 2, 6, 6). ``costs``: (n, 2), the squared
        errors of each pose. ``now``: seconds.
        """
        memories = np.array([self._memories.get(key, NEW) for key in keys]).reshape(-1, len(NEW))
        believed, weights = binding.weigh_poses(*poses, costs, now, memories)
        for key, memory in zip(keys, memories):
            self._memories[key] = memory
        return believed, weights


def mixture(one: Pose, other: Pose, weight: Floats) -> tuple[Floats, Floats]:
    """The covariance of n poses, (n, 6, 6), which allows for the other poses, and the weights of those, (n,).

    ``one``, ``other``: poses, rotations (n, 3, 3), translations (n, 3) and
    covariances (n, 6, 6). ``weight``: (n,), the weights of the other poses. A
    returned weight is 0 if the two poses cannot be told apart.
    """
    return binding.mix_poses(one, other, weight)


def mixed_covariance(one: Pose, other: Pose, weight: float) -> Floats:
    """The covariance, (6, 6), of one pose, which allows for another one with that weight: see mixture."""
    first, second = ((rotation[None], translation[None], covariance[None])
                     for rotation, translation, covariance in (one, other))
    return mixture(first, second, np.array([weight]))[0][0]
