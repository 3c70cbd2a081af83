"""Estimating the poses of tags, of the area on their wall, and of the camera in front of it."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Mapping, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats, Pose
from aruco_ar.base.errors import InputError
from aruco_ar.base.recent import Recent
from aruco_ar.compiled import binding
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.ordering import MIN_HEIGHT_PX
from aruco_ar.geometry.plane_pose import cross_matrices
from aruco_ar.tags.corner_rays import corner_rays
from aruco_ar.tags.tag import SIDE_M, Tag
from aruco_ar.tracking.area import Area
from aruco_ar.tracking.frame_clock import FrameClock
from aruco_ar.walls.wall import Wall

from .area_pose import AreaPose, area_pose
from .belief import Belief, mixed_covariance, mixture
from .observations import SeenTags
from .wall_estimator import WallEstimator

# If a tag's corners fit no pose well, their deviation is larger. It is estimated from about the last
# MEMORY_FRAMES frames. PRIOR_FRAMES frames with usual corners are assumed before the first one.
MEMORY_FRAMES, PRIOR_FRAMES = 20, 2
FADE = 1 - 1 / MEMORY_FRAMES
MAX_COST = 1e4  # that estimate limits costs to this: a higher cost means that the tag has another size


@dataclass(frozen=True, eq=False)
class TagPose:
    """The pose of a tag: point in the optical frame = rotation @ point in the tag's own axes + translation.

    The tag's own axes start at its center: x to the right, y up, z out of it.
    ``corners``: (4, 2) pixels, as given. ``size``: its side, meters.
    ``rotation``: (3, 3). ``translation``: (3,), meters. ``covariance``: (6, 6),
    m² and rad², in the order of ROS: x, y, z, and small turns about the X, Y, Z
    axes of the optical frame. ``ambiguity``: the probability of the other pose
    that explains the corners, 0 to 0.5.
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
    """The pose of the camera: wall point = rotation @ point in the optical frame + translation.

    ``rotation``: (3, 3). ``translation``: (3,), meters. ``covariance``: (6, 6),
    m² and rad², as in TagPose, but about the wall's axes. ``ids``: the ids of
    the tags that it was computed from.
    """

    rotation: Floats
    translation: Floats
    covariance: Floats
    ids: tuple[int, ...]

    def carry(self, rotation: Floats, translation: Floats) -> CameraPose:
        """The pose of something fixed to the camera, such as the robot, as a CameraPose.

        It is at ``rotation``, (3, 3), and ``translation``, (3,) meters, in the optical frame.
        """
        arm = self.rotation @ translation
        jacobian = np.eye(6)
        jacobian[:3, 3:] = -cross_matrices(arm)  # a turn of the camera moves what is far from it more
        return CameraPose(self.rotation @ rotation, self.translation + arm,
                          jacobian @ self.covariance @ jacobian.T, self.ids)


class PoseEstimator:
    """Estimates the poses of tags, of the area, and of the camera through a sequence of frames.

    ``tag_size``: meters, the side of a tag. ``sizes``: {id: meters}, of tags
    with other sides. ``wall``: a Wall with the places and sides of its tags.
    Without it, the estimator learns a wall from tags that are repeatedly seen
    in one plane. Its axes are those of the tag with the lowest id among them.
    Raises InputError for an impossible size.
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
        """Forget the learned wall and all earlier frames."""
        self._clock = FrameClock()
        self._belief, self._wall = Belief(), WallEstimator(self._given)
        # For each id, fading sums over frames: the squared errors, and the count.
        self._noise: Recent[int, tuple[float, float]] = Recent()

    def update(self, tags: Sequence[Tag], lens: Lens, stamp: float) -> list[TagPose]:
        """The poses of tags in a frame, a list of TagPose in the order of the tags.

        ``tags``: a list of Tag. ``lens``: the Lens that they are seen through.
        ``stamp``: the frame's time, seconds; if it goes back, the estimator is
        reset. A tag is left out if its corners cannot be a square seen from the
        front. Tags with the same id are not used for the pose of the wall.
        """
        if self._clock.goes_back(stamp):
            self.reset()
        self._clock.advance(stamp)
        seen = self._seen_tags(tags, lens) if tags else None
        if seen is None:
            self._wall.see_no_tags()
            return []
        single = [number for number, tag_id in enumerate(seen.ids) if seen.ids.count(tag_id) == 1]
        unique = seen.subset(single)
        believed, weight = np.argmax(seen.probabilities, axis=1), seen.probabilities.min(axis=1)
        if single:
            believed[single], weight[single] = self._belief.weigh(unique.ids, unique.poses, unique.costs,
                                                                  self._clock.now)
            every = np.arange(len(single))
            probabilities = np.empty((len(single), 2))
            probabilities[every, believed[single]] = 1 - weight[single]
            probabilities[every, 1 - believed[single]] = weight[single]
            unique = replace(unique, probabilities=probabilities)
        self._wall.update(unique, self._clock.now)
        one, other = seen.pairs(believed)
        for number in single:
            if seen.ids[number] in self._wall.tag_poses:
                first, second, weight[number] = self._wall.tag_poses[seen.ids[number]]
                for part, value in zip((*one, *other), (*first, *second)):
                    part[number] = value
        covariance, ambiguity = mixture(one, other, weight)
        return [TagPose(tag.id, tag.corners, *rest) for tag, *rest in zip(
            seen.tags, seen.sizes.tolist(), one[0], one[1], covariance, ambiguity.tolist())]

    def camera(self) -> CameraPose | None:
        """The CameraPose of the last update, or None if no tags in sight agreed on the wall's pose."""
        fit = self._wall.fit
        if fit is None:
            return None
        one, other = (_inverse_pose(*pose) for pose in fit.poses)
        return CameraPose(one[0], one[1], mixed_covariance(one, other, fit.weight), fit.ids)

    def area(self, area: Area, lens: Lens) -> AreaPose | None:
        """The AreaPose of an Area on the wall of the last update, or None if the wall's pose is unknown.

        ``lens``: the Lens that it is seen through.
        """
        return None if self._wall.fit is None else area_pose(self._wall.fit, area, lens)

    def _seen_tags(self, tags: Sequence[Tag], lens: Lens) -> SeenTags | None:
        """The SeenTags of the tags whose corners can be those of a square, or None if there are none."""
        quads = np.array([tag.corners for tag in tags], np.float64)
        quads[~np.isfinite(quads).all(axis=(1, 2))] = 0  # no quadrilateral
        rays = corner_rays(lens, quads)
        _, slopes = lens.project_rays(rays.reshape(-1, 2))
        sizes = np.array([self._sizes.get(tag.id, self._tag_size) for tag in tags])
        is_seen, deviation, weights, rotation, translation, covariance, costs = binding.find_tag_poses(
            quads, MIN_HEIGHT_PX, rays, slopes.reshape(-1, 4, 2, 2), sizes)
        keep = np.flatnonzero(is_seen)
        if not len(keep):
            return None
        scale = np.ones(len(tags))
        scale[keep] = self._scales([tags[number].id for number in keep], costs[keep].min(axis=1))
        costs /= scale[:, None]
        likelihood = np.exp(-(costs - costs.min(axis=1, keepdims=True)) / 2)
        root = np.sqrt(scale)
        return SeenTags(
            tuple(tags), quads, sizes, rays, weights / root[:, None, None, None], deviation * root,
            (rotation, translation, covariance * scale[:, None, None, None]),
            costs, likelihood / likelihood.sum(axis=1, keepdims=True)).subset(keep)

    def _scales(self, ids: Sequence[int], costs: Floats) -> Floats:
        """(n,): by which factor the variance of tags' corners is larger than usual, as the costs of poses show.

        The expected cost is 2, since six numbers are fitted to eight coordinates.
        """
        scales = []
        for tag_id, cost in zip(ids, costs):
            total, frames = self._noise.get(tag_id, (0.0, 0.0))
            self._noise[tag_id] = total, frames = total * FADE + min(cost, MAX_COST), frames * FADE + 1
            scales.append(max(1.0, (2 * PRIOR_FRAMES + total) / (2 * PRIOR_FRAMES + 2 * frames)))
        return np.array(scales)


def _inverse_pose(rotation: Floats, translation: Floats, covariance: Floats) -> Pose:
    """The pose of the camera in the wall's axes, from the pose of the wall in the camera's axes."""
    jacobian = np.zeros((6, 6))
    jacobian[:3, :3] = jacobian[3:, 3:] = -rotation.T
    jacobian[:3, 3:] = -rotation.T @ cross_matrices(translation)
    return rotation.T, -rotation.T @ translation, jacobian @ covariance @ jacobian.T


def _size(value: Any, name: str) -> float:
    """The side of a tag, meters, as a float. Raises InputError if no tag can have it."""
    try:
        size = float(value)
    except (TypeError, ValueError):
        size = np.nan
    if not SIDE_M[0] <= size <= SIDE_M[1]:
        raise InputError('The size of %s cannot be %s; give its side in meters, from %g to %g.'
                         % ((name, value) + SIDE_M))
    return size
