"""The tags seen in one frame and the wall fitted to them, both with their two possible poses."""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aruco_ar.base.arrays import Floats, Integers, Pose
from aruco_ar.compiled import binding
from aruco_ar.geometry.plane_pose import cross_matrices
from aruco_ar.tags.tag import Tag
from aruco_ar.walls.places import Places

from .belief import mixture

BULGE = np.diag([0.003**2, 0.02**2, 0.02**2])  # m², rad²: the covariance of paper off its wall


@dataclass(frozen=True, eq=False)
class SeenTags:
    """Tags seen in one frame, and both poses of each.

    ``quads``: (n, 4, 2) pixels. ``sizes``: (n,) meters. ``rays``: (n, 4, 2).
    ``weights``: (n, 4, 2, 2), see refine. ``deviation``: (n,) pixels, the
    standard deviation of corners. ``poses``: rotations (n, 2, 3, 3),
    translations (n, 2, 3), covariances (n, 2, 6, 6). ``costs``: (n, 2), the
    squared errors of the poses. ``probabilities``: (n, 2), of the poses.
    """

    tags: tuple[Tag, ...]
    quads: Floats
    sizes: Floats
    rays: Floats
    weights: Floats
    deviation: Floats
    poses: Pose
    costs: Floats
    probabilities: Floats

    @cached_property
    def ids(self) -> tuple[int, ...]:
        """The tags' ids."""
        return tuple(tag.id for tag in self.tags)

    def believed(self) -> Pose:
        """The more probable pose of each tag: rotations (n, 3, 3), translations (n, 3), covariances (n, 6, 6).

        The covariances allow for the other pose.
        """
        one, other = self.pairs(np.argmax(self.probabilities, axis=1))
        return one[0], one[1], mixture(one, other, self.probabilities.min(axis=1))[0]

    def pairs(self, first: Integers) -> tuple[Pose, Pose]:
        """Of each tag the pose with the index ``first``, (n,), 0 or 1, and the other one."""
        every = np.arange(len(self.tags))
        one, other = (tuple(part[every, which] for part in self.poses) for which in (first, 1 - first))
        return one, other

    def subset(self, numbers: Integers | list[int]) -> SeenTags:
        """The tags with those indices alone, which are in ascending order, each once."""
        if len(numbers) == len(self.tags):
            return self
        rotation, translation, covariance = self.poses
        return SeenTags(tuple(self.tags[number] for number in numbers), self.quads[numbers],
                        self.sizes[numbers], self.rays[numbers], self.weights[numbers],
                        self.deviation[numbers],
                        (rotation[numbers], translation[numbers], covariance[numbers]),
                        self.costs[numbers], self.probabilities[numbers])


@dataclass(frozen=True, eq=False)
class WallFit:
    """A wall fitted to the tags of one frame: its two poses, the believed one first.

    ``ids``: the tags' ids. ``rotation``: (2, 3, 3), ``translation``: (2, 3),
    from wall to camera. ``amounts``: (2, q), how far the tags' places deviate,
    see refine. ``covariance``: (2, 6 + q, 6 + q), of pose and amounts.
    ``errors``: (n,), the squared errors of the tags. ``cost``: (2,), the total
    cost of each pose. ``scale``: the cost relative to the expected one; the
    covariance takes it into account. ``weight``: that of the second pose.
    """

    ids: tuple[int, ...]
    rotation: Floats
    translation: Floats
    amounts: Floats
    covariance: Floats
    errors: Floats
    cost: Floats
    scale: float
    weight: float = 0.0

    @property
    def poses(self) -> list[Pose]:
        """Both poses, each as (rotation, translation, covariance (6, 6))."""
        return list(zip(self.rotation, self.translation, self.covariance[:, :6, :6]))

    def camera(self, which: int = 0) -> Floats:
        """(3,) meters: the camera's place in wall coordinates, by the first or the second pose."""
        return -self.rotation[which].T @ self.translation[which]


def poses_of_tags(fit: WallFit, places: Places) -> dict[int, tuple[Pose, Pose, float]]:
    """{id: (pose, other pose, the other one's weight)} of the tags of a WallFit, from all tags together."""
    wall = fit.rotation, fit.translation, fit.covariance
    found = binding.place_tags(wall, fit.amounts, *places.poses(fit.ids))
    return {tag_id: ((rotation[0], translation[0], covariance[0]), (rotation[1], translation[1], covariance[1]),
                     fit.weight)
            for tag_id, rotation, translation, covariance in zip(fit.ids, *found)}


def off_others(poses: Pose, axes: Floats, bulge: Floats = BULGE) -> tuple[Floats, Floats]:
    """How far each of n > 1 tags is off the plane of the others, (n, 3), and the covariances, (n, 3, 3).

    The three numbers are the height over the plane, meters, and two components
    of the normal, in ``axes``, (3, 3), whose z is near their normal. ``poses``:
    rotations (n, 3, 3), translations (n, 3), covariances (n, 6, 6). ``bulge``:
    (3, 3), the covariance of each tag's paper relative to its wall.
    """
    return binding.off_others(poses, axes, bulge)


def off_plane(one: Pose, others: Pose) -> tuple[Floats, Floats]:
    """How far n tags are off a plane, in its axes; returns the same as off_others.

    ``one``: the plane's rotation (3, 3), translation (3,), covariance (6, 6). ``others``: the same of n tags.
    """
    rotation, translation, covariance = one
    other_rotation, other_translation, other_covariance = others
    toward, between, normals = rotation.T, other_translation - translation, other_rotation[..., 2]
    off = np.concatenate([(between @ rotation)[:, 2:], (normals @ rotation)[:, :2]], axis=1)
    # The derivatives by both poses. The plane turns about its origin, and a tag's normal turns with the tag.
    jacobian, other_jacobian = np.zeros((2, len(off), 3, 6))
    other_jacobian[:, 0, :3], other_jacobian[:, 1:, 3:] = toward[2], -toward[:2] @ cross_matrices(normals)
    jacobian[:] = -other_jacobian
    jacobian[:, 0, 3:] = toward[2] @ cross_matrices(between)
    return off, (jacobian @ covariance @ jacobian.swapaxes(1, 2)
                 + other_jacobian @ other_covariance @ other_jacobian.swapaxes(1, 2) + BULGE)


def squared(off: Floats, spread: Floats) -> Floats:
    """(n,): the squared Mahalanobis lengths of vectors, (n, k), with covariances (n, k, k)."""
    return (off * np.linalg.solve(spread, off[..., None])[..., 0]).sum(axis=1)


def height_deviation(spread: Floats) -> Floats:
    """(n,) meters: the standard deviation of a tag's height over a plane, if it is parallel to the plane.

    ``spread``: (n, 3, 3), as from off_others.
    """
    return np.linalg.inv(spread)[:, 0, 0]**-0.5
