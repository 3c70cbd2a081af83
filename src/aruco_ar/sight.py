"""What one frame shows: the tags and both poses of each, and the wall and both poses of it."""
from dataclasses import dataclass
from typing import Tuple

import numpy as np

from .solving import crossed
from .tags import Tag

BULGE_M, BULGE_RAD = 0.003, 0.02  # by so much paper on a wall is off its plane


@dataclass(frozen=True, eq=False)
class Sight:
    """Tags seen in one frame, and both poses of each.

    ``quads``: (n, 4, 2) pixels; ``sizes``: (n,) meters; ``rays``: (n, 4, 2);
    ``weights``: (n, 4, 2, 2), see refine; ``deviation``: (n,) pixels, how far
    off corners may be; ``poses``: rotations (n, 2, 3, 3), translations
    (n, 2, 3), covariances (n, 2, 6, 6); ``costs``: (n, 2), their squared
    deviations from what is seen; ``likely``: (n, 2), their weights.
    """

    tags: Tuple[Tag, ...]
    quads: np.ndarray
    sizes: np.ndarray
    rays: np.ndarray
    weights: np.ndarray
    deviation: np.ndarray
    poses: Tuple[np.ndarray, np.ndarray, np.ndarray]
    costs: np.ndarray
    likely: np.ndarray

    @property
    def ids(self):
        """A tuple of the tags' ids."""
        return tuple(tag.id for tag in self.tags)

    def some(self, numbers):
        """The Sight of those tags alone."""
        return Sight(tuple(self.tags[number] for number in numbers), self.quads[numbers], self.sizes[numbers],
                     self.rays[numbers], self.weights[numbers], self.deviation[numbers],
                     tuple(part[numbers] for part in self.poses), self.costs[numbers], self.likely[numbers])


@dataclass(frozen=True, eq=False)
class View:
    """The wall in one frame: both poses of it, the more believed first, and the tags that say so.

    ``rotation``: (2, 3, 3), ``translation``: (2, 3), from wall to camera.
    ``covariance``: (2, 6 + q, 6 + q), of these and of the deviations ``own``,
    (2, q), of the places. ``off``: (n,), the tags' squared deviations; ``cost``:
    (2,), those of all by each pose; ``scale``: how many times as great they are as
    they should be, which the covariance takes into account. ``weight``: of the
    second pose.
    """

    ids: Tuple[int, ...]
    rotation: np.ndarray
    translation: np.ndarray
    own: np.ndarray
    covariance: np.ndarray
    off: np.ndarray
    cost: np.ndarray
    scale: float
    weight: float = 0.0

    @property
    def poses(self):
        """Both as (rotation, translation, covariance (6, 6))."""
        return list(zip(self.rotation, self.translation, self.covariance[:, :6, :6]))


def off_planes(ones, others):
    """(n, m, 2, 2): how far things are off the planes of others, as squared deviations, by each of their poses.

    ``ones``: rotations (n, k, 3, 3), translations (n, k, 3), covariances
    (n, k, 6, 6); ``others`` the same of m things.
    """
    rotation, translation, covariance = (part[:, None, :, None] for part in ones)
    other_rotation, other_translation, other_covariance = (part[None, :, None] for part in others)
    toward = rotation.swapaxes(-1, -2)
    between, normal = other_translation - translation, np.broadcast_to(
        other_rotation[..., 2], np.broadcast_shapes(other_rotation.shape, rotation.shape)[:-1])
    off = np.concatenate([(toward @ between[..., None])[..., 2:, 0], (toward @ normal[..., None])[..., :2, 0]],
                         axis=-1)
    # By the turns: of the one its plane turns about its center, of the other its normal.
    lift, lean = (toward @ crossed(between))[..., 2:, :], -(toward @ crossed(normal))[..., :2, :]
    shift, none = np.broadcast_to(toward[..., 2:, :], lift.shape), np.zeros(lean.shape)
    one = np.concatenate([np.concatenate([-shift, lift], axis=-1), np.concatenate([none, -lean], axis=-1)],
                         axis=-2)
    other = np.concatenate([np.concatenate([shift, 0 * lift], axis=-1), np.concatenate([none, lean], axis=-1)],
                           axis=-2)
    spread = one @ covariance @ one.swapaxes(-1, -2) + other @ other_covariance @ other.swapaxes(-1, -2)
    spread = spread + np.diag([BULGE_M, BULGE_RAD, BULGE_RAD]) ** 2
    return np.einsum('...i,...i->...', off, np.linalg.solve(spread, off[..., None])[..., 0])
