"""Poses: of tags, of the area on their wall, and of the camera before it."""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats, Pose
from aruco_ar.base.errors import InputError
from aruco_ar.base.recent import Recent
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.geometry.plane_pose import NEAR_M, approximate_poses, cross_matrices, refine
from aruco_ar.tags.tag import SIDE_M, Tag, square
from aruco_ar.tracking.area import Area
from aruco_ar.walls.wall import Wall

from .area_pose import AreaPose, area_pose
from .belief import Belief, mixture
from .lens import Lens
from .sight import Sight
from .wall_view import WallView

USUAL_S = 1 / 30         # between frames whose stamps do not tell
# How far off a corner that the Detector finds is, a standard deviation measured
# before the simulated wall: so much, and so much more for a tag whose shortest side
# is SMALL_PX, less the larger it is.
CORNER_PX, SMALL_TAG_PX, SMALL_PX, MAX_CORNER_PX = 0.03, 0.05, 20.0, 0.5
# Where a tag's corners fit no pose that well, they are off by more, which is
# remembered of about so many frames; so many are taken for granted at first.
MEMORY_FRAMES, GRANTED_FRAMES = 20, 2
FADE = 1 - 1 / MEMORY_FRAMES
HOPELESS = 1e30          # the cost of a pose that cannot be
MAX_COST = 1e4           # more than that no tag teaches about its corners: it is another thing


@dataclass(frozen=True, eq=False)
class TagPose:
    """Where a tag is: point in the optical frame = rotation @ point in the tag's own axes + translation.

    The tag's own axes: x right, y up, z out of it, from its center.
    ``corners``: (4, 2) pixels, as they were given. ``size``: its side, meters.
    ``rotation``: (3, 3), ``translation``: (3,), meters. ``covariance``: (6, 6),
    m² and rad², in the order of ROS: x, y, z, and small turns about the X, Y, Z
    axes of the optical frame. ``ambiguity``: the weight of another pose that
    explains the corners as well, 0 (none) to 0.5 (nobody knows).
    """

    id: int
    corners: Floats
    size: float
    rotation: Floats
    translation: Floats
    covariance: Floats
    ambiguity: float


@dataclass(frozen=True, eq=False)
class CameraPose:
    """Where the camera is: wall point = rotation @ point in the optical frame + translation.

    ``rotation``: (3, 3), ``translation``: (3,), meters, ``covariance``: (6, 6),
    m² and rad², as of a TagPose, about the wall's axes. ``ids``: of the tags
    that say so.
    """

    rotation: Floats
    translation: Floats
    covariance: Floats
    ids: tuple[int, ...]

    def carry(self, rotation: Floats, translation: Floats) -> CameraPose:
        """The pose of what is at ``rotation``, ``translation`` in the optical frame, such as the robot."""
        arm = self.rotation @ translation
        moves = np.eye(6)
        moves[:3, 3:] = -cross_matrices(arm)  # the farther away it is, the more a turn of the camera moves it
        return CameraPose(self.rotation @ rotation, self.translation + arm, moves @ self.covariance @ moves.T,
                          self.ids)


class PoseEstimator:
    """Finds the poses of tags, of the area, and of the camera through a sequence of frames.

    ``tag_size``: meters, the side of a tag, and ``sizes``: {id: meters}, of
    those that have another. ``wall``: a wall.Wall, which says where its tags
    are and what size they have; without one, tags that are seen in one plane
    again and again are learned as a wall, in the axes of the one of them with
    the lowest id. Raises InputError for a size that no tag has.
    """

    def __init__(self, tag_size: float = 0.18, sizes: Mapping[int, float] | None = None,
                 wall: Wall | None = None) -> None:
        self._tag_size = _size(tag_size, 'a tag')
        self._sizes = {tag_id: _size(size, 'tag %s' % (tag_id,)) for tag_id, size in dict(sizes or {}).items()}
        if wall is not None:
            self._sizes.update({tag.id: float(tag.side) for tag in wall.tags})
        self._given = wall
        self.reset()

    def reset(self) -> None:
        """Forget the learned wall and all that was seen."""
        self._stamp: float | None = None
        self._now = 0.0
        self._belief, self._wall = Belief(), WallView(self._given)
        # Of tags: their squared deviations, and of how many frames, lately.
        self._noise: Recent[int, tuple[float, float]] = Recent()

    def update(self, tags: Sequence[Tag], lens: Lens, stamp: float) -> list[TagPose]:
        """The poses of tags in a frame, a list of TagPose in their order.

        ``tags``: a list of Tag. ``lens``: the Lens that they were seen through.
        ``stamp``: the frame's time in seconds; where it goes back, all that
        was seen is forgotten. A tag whose corners are no square seen from
        before it is left out. Of an id that is seen more than once, no tag
        says where the wall is.
        """
        if self._stamp is not None and not stamp >= self._stamp:
            self.reset()
        self._now += USUAL_S if self._stamp in (None, stamp) else stamp - self._stamp
        self._stamp = stamp
        seen = self._sight(tags, lens) if tags else None
        if seen is None:
            self._wall.miss()
            return []
        often = Counter(seen.ids)
        single = np.array([number for number, tag_id in enumerate(seen.ids) if often[tag_id] == 1], int)
        alone = seen.some(single)
        believed, weight = np.argmax(seen.likely, axis=1), seen.likely.min(axis=1)
        if len(single):
            believed[single], weight[single] = self._belief.weigh(alone.ids, alone.poses, alone.costs,
                                                                  self._now)
            every = np.arange(len(single))
            alone.likely[every, believed[single]] = 1 - weight[single]
            alone.likely[every, 1 - believed[single]] = weight[single]
        self._wall.update(alone, self._now)
        together = self._wall.tag_poses
        poses = []
        for number, tag in enumerate(seen.tags):
            first = believed[number]
            one, other = (tuple(part[number, which] for part in seen.poses) for which in (first, 1 - first))
            of_two = weight[number]
            if often[tag.id] == 1 and tag.id in together:
                one, other, of_two = together[tag.id]
            poses.append(TagPose(tag.id, tag.corners, float(seen.sizes[number]), one[0], one[1],
                                 *mixture(one, other, of_two)))
        return poses

    def camera(self) -> CameraPose | None:
        """The CameraPose in the last update, or None if no tag of a wall was in sight that agrees with it."""
        view = self._wall.view
        if view is None:
            return None
        one, other = (_seen_from_the_wall(*pose) for pose in view.poses)
        return CameraPose(one[0], one[1], mixture(one, other, view.weight)[0], view.ids)

    def area(self, area: Area, lens: Lens) -> AreaPose | None:
        """The AreaPose of an Area on the wall in the last update, or None if that was not in sight.

        ``lens``: the Lens that it was seen through.
        """
        return None if self._wall.view is None else area_pose(self._wall.view, area, lens)

    def _sight(self, tags: Sequence[Tag], lens: Lens) -> Sight | None:
        """The Sight of those tags that can be real ones, or None."""
        quads = np.array([tag.corners for tag in tags], np.float64)
        real = np.isfinite(quads).all(axis=(1, 2))
        quads[~real] = 0
        rays = lens.corner_rays(quads)
        across, down = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
        good = real & np.isfinite(rays).all(axis=(1, 2)) & is_quadrilateral(quads)
        good &= across[:, 0] * down[:, 1] > across[:, 1] * down[:, 0]  # clockwise: not seen from behind
        sizes = np.array([self._sizes.get(tag.id, self._tag_size) for tag in tags])
        starts = [approximate_poses(points, ray) if fine else None
                  for points, ray, fine in zip(square(sizes), rays, good)]
        begun = [(number, start) for number, start in enumerate(starts) if start is not None]
        if not begun:
            return None
        keep = [number for number, _ in begun]
        rays, quads, sizes = rays[keep], quads[keep], sizes[keep]
        deviation = corner_deviation(quads)
        _, slopes = lens.project_rays(rays.reshape(-1, 2))
        weights = slopes.reshape(-1, 4, 2, 2) / deviation[:, None, None, None]
        rotation, translation, _, squares, covariance = refine(
            np.repeat(square(sizes), 2, axis=0), np.repeat(rays, 2, axis=0), np.repeat(weights, 2, axis=0),
            np.concatenate([rotations for _, (rotations, _) in begun]),
            np.concatenate([translations for _, (_, translations) in begun]))
        rotation, translation = rotation.reshape(-1, 2, 3, 3), translation.reshape(-1, 2, 3)
        costs = squares.sum(axis=1).reshape(-1, 2)
        # A tag shows its face.
        faces = (np.einsum('npi,npi->np', rotation[..., 2], translation) < 0) & (translation[..., 2] > NEAR_M)
        costs = np.where(faces & np.isfinite(costs), costs, HOPELESS)
        scale = self._scales([tags[number].id for number in keep], costs.min(axis=1))
        costs = costs / scale[:, None]
        likely = np.exp(-(costs - costs.min(axis=1, keepdims=True)) / 2)
        sight = Sight(
            tuple(tags[number] for number in keep), quads, sizes, rays,
            weights / np.sqrt(scale)[:, None, None, None], deviation * np.sqrt(scale),
            (rotation, translation, covariance.reshape(-1, 2, 6, 6) * scale[:, None, None, None]),
            costs, likely / likely.sum(axis=1, keepdims=True))
        return sight.some(np.flatnonzero(faces.any(axis=1)))

    def _scales(self, ids: Sequence[int], costs: Floats) -> Floats:
        """(n,): by how much the variance of tags' corners is greater than usual, to the costs of their poses.

        Eight numbers that six others are fitted to leave a cost of about 2.
        """
        scales = []
        for tag_id, cost in zip(ids, costs):
            total, frames = self._noise.get(tag_id, (0.0, 0.0))
            self._noise[tag_id] = total, frames = total * FADE + min(cost, MAX_COST), frames * FADE + 1
            scales.append(max(1.0, (2 * GRANTED_FRAMES + total) / (2 * GRANTED_FRAMES + 2 * frames)))
        return np.array(scales)


def corner_deviation(quads: Floats) -> Floats:
    """(n,) pixels: how far off the corners of tags, (n, 4, 2), found by the Detector, may be."""
    lengths = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=2)
    sides = (lengths + np.roll(lengths, 2, axis=1))[:, :2] / 2
    shortest = np.maximum(sides.min(axis=1), 1e-9)
    return np.minimum(CORNER_PX + SMALL_TAG_PX * (SMALL_PX / shortest)**3, MAX_CORNER_PX)


def _seen_from_the_wall(rotation: Floats, translation: Floats, covariance: Floats) -> Pose:
    """The camera's pose in wall coordinates from the wall's in the camera's, each with its covariance."""
    moves = np.zeros((6, 6))
    moves[:3, :3] = moves[3:, 3:] = -rotation.T
    moves[:3, 3:] = -rotation.T @ cross_matrices(translation)
    return rotation.T, -rotation.T @ translation, moves @ covariance @ moves.T


def _size(value: Any, name: str) -> float:
    """The side of a tag as a float; InputError if none has it."""
    try:
        size = float(value)
    except (TypeError, ValueError):
        size = np.nan
    if not SIDE_M[0] <= size <= SIDE_M[1]:
        raise InputError('The size of %s cannot be %s; give its side in meters, from %g to %g.'
                         % ((name, value) + SIDE_M))
    return size
