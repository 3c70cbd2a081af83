"""What one frame shows: the tags and both poses of each, and the wall and both poses of it."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aruco_ar.base.arrays import Floats, Integers, Pose
from aruco_ar.geometry.plane_pose import cross_matrices, rotation_matrices
from aruco_ar.tags.tag import Tag
from aruco_ar.walls.places import Places

from .belief import mixture

BULGE = np.diag([0.003**2, 0.02**2, 0.02**2])  # m, rad: by so much paper on a wall is off its plane


@dataclass(frozen=True, eq=False)
class Sight:
    """Tags seen in one frame, and both poses of each.

    ``quads``: (n, 4, 2) pixels; ``sizes``: (n,) meters; ``rays``: (n, 4, 2);
    ``weights``: (n, 4, 2, 2), see refine; ``deviation``: (n,) pixels, how far
    off corners may be; ``poses``: rotations (n, 2, 3, 3), translations
    (n, 2, 3), covariances (n, 2, 6, 6); ``costs``: (n, 2), their squared
    deviations from what is seen; ``likely``: (n, 2), their weights.
    """

    tags: tuple[Tag, ...]
    quads: Floats
    sizes: Floats
    rays: Floats
    weights: Floats
    deviation: Floats
    poses: Pose
    costs: Floats
    likely: Floats

    @property
    def ids(self) -> tuple[int, ...]:
        """A tuple of the tags' ids."""
        return tuple(tag.id for tag in self.tags)

    def believed(self) -> Pose:
        """Of each tag its more likely pose: rotations (n, 3, 3), translations (n, 3), covariances (n, 6, 6).

        These allow for the other pose as well.
        """
        found = []
        for rotation, translation, covariance, likely in zip(*self.poses, self.likely):
            first = int(np.argmax(likely))
            one, other = ((rotation[which], translation[which], covariance[which])
                          for which in (first, 1 - first))
            found.append((*one[:2], mixture(one, other, likely[1 - first])[0]))
        rotations, translations, covariances = (np.array(part) for part in zip(*found))
        return rotations, translations, covariances

    def some(self, numbers: Integers | list[int]) -> Sight:
        """The Sight of those tags alone."""
        rotation, translation, covariance = self.poses
        return Sight(tuple(self.tags[number] for number in numbers), self.quads[numbers], self.sizes[numbers],
                     self.rays[numbers], self.weights[numbers], self.deviation[numbers],
                     (rotation[numbers], translation[numbers], covariance[numbers]), self.costs[numbers],
                     self.likely[numbers])


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

    ids: tuple[int, ...]
    rotation: Floats
    translation: Floats
    own: Floats
    covariance: Floats
    off: Floats
    cost: Floats
    scale: float
    weight: float = 0.0

    @property
    def poses(self) -> list[Pose]:
        """Both as (rotation, translation, covariance (6, 6))."""
        return list(zip(self.rotation, self.translation, self.covariance[:, :6, :6]))

    def camera(self, which: int = 0) -> Floats:
        """(3,) meters: where the camera is in wall coordinates, by one of both."""
        return -self.rotation[which].T @ self.translation[which]


def poses_of_tags(view: View, places: Places) -> dict[int, tuple[Pose, Pose, float]]:
    """{id: (pose, other pose, its weight)} of the tags of a View, by all of them together."""
    rotation, center, spread = places.poses(view.ids)
    found: dict[int, list[Pose]] = {tag_id: [] for tag_id in view.ids}
    for which in (0, 1):
        turn = view.rotation[which]
        off = spread @ view.own[which]
        arms = (center + off[:, :3]) @ turn.T
        own_turn = rotation_matrices(off[:, 3:])
        moves = np.zeros((len(arms), 6, view.covariance.shape[1]))
        moves[:, :, :6] = np.eye(6)
        moves[:, :3, 3:6] = -cross_matrices(arms)
        moves[:, :3, 6:], moves[:, 3:, 6:] = turn @ spread[:, :3], turn @ spread[:, 3:]
        covariance = moves @ view.covariance[which] @ moves.swapaxes(1, 2)
        for number, tag_id in enumerate(view.ids):
            found[tag_id].append((turn @ own_turn[number] @ rotation[number],
                                  arms[number] + view.translation[which], covariance[number]))
    return {tag_id: (one, other, view.weight) for tag_id, (one, other) in found.items()}


def off_others(poses: Pose, axes: Floats, bulge: Floats = BULGE) -> tuple[Floats, Floats]:
    """How far each of n > 1 things is off the plane of the others, (n, 3), and the covariances, (n, 3, 3).

    Their height over it, meters, and two numbers of their normals, in ``axes``
    (3, 3) whose z is about their normal. ``poses``: rotations (n, 3, 3),
    translations (n, 3), covariances (n, 6, 6). ``bulge``: (3, 3), of each thing.
    """
    rotation, translation, covariance = poses
    arms, normals = (translation - translation.mean(axis=0)) @ axes, rotation[..., 2] @ axes
    seen = np.concatenate([arms[:, 2:], normals[:, :2]], axis=1)[..., None]
    moves = np.zeros((len(seen), 3, 6))
    moves[:, 0, :3], moves[:, 1:, 3:] = axes[:, 2], -axes[:, :2].T @ cross_matrices(rotation[..., 2])
    spread = moves @ covariance @ moves.swapaxes(1, 2) + bulge
    model = np.tile(np.eye(3), (len(seen), 1, 1))  # how a plane's height and normal show in those numbers
    model[:, 0, 1:] = -arms[:, :2]
    taught = model.swapaxes(1, 2) @ np.linalg.inv(spread)
    known, told = taught @ model, taught @ seen
    others = np.linalg.inv(known.sum(axis=0) - known)
    off = seen - model @ others @ (told.sum(axis=0) - told)
    return off[..., 0], spread + model @ others @ model.swapaxes(1, 2)


def off_plane(one: Pose, others: Pose) -> tuple[Floats, Floats]:
    """How far n things are off the plane of another one: see off_others; in its axes.

    ``one``: a rotation (3, 3), translation (3,), covariance (6, 6); ``others``: the same of n things.
    """
    rotation, translation, covariance = one
    other_rotation, other_translation, other_covariance = others
    toward, between, normals = rotation.T, other_translation - translation, other_rotation[..., 2]
    off = np.concatenate([(between @ rotation)[:, 2:], (normals @ rotation)[:, :2]], axis=1)
    # By the turns: of the one its plane turns about its center, of the other its normal.
    moves, other_moves = np.zeros((2, len(off), 3, 6))
    other_moves[:, 0, :3], other_moves[:, 1:, 3:] = toward[2], -toward[:2] @ cross_matrices(normals)
    moves[:] = -other_moves
    moves[:, 0, 3:] = toward[2] @ cross_matrices(between)
    return off, (moves @ covariance @ moves.swapaxes(1, 2)
                 + other_moves @ other_covariance @ other_moves.swapaxes(1, 2) + BULGE)


def squared(off: Floats, spread: Floats) -> Floats:
    """(n,): numbers (n, k) as squared deviations, by their covariances (n, k, k)."""
    return (off * np.linalg.solve(spread, off[..., None])[..., 0]).sum(axis=1)


def height_deviation(spread: Floats) -> Floats:
    """(n,) meters: how surely the height of things that are parallel to a plane is seen: see off_others."""
    return np.linalg.inv(spread)[:, 0, 0]**-0.5
