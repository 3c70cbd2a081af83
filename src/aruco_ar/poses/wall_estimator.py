"""Estimating the pose of a wall from all its tags together, and learning which tags are on it.

One pose of the wall must explain the corners of all its tags in sight. So
together they determine the camera's pose much better than each of them alone.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Hashable

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Pose
from aruco_ar.base.recent import Recent
from aruco_ar.geometry.plane_pose import NEAR_M, approximate_poses, refine
from aruco_ar.tags.edges import side_of
from aruco_ar.walls.places import Places
from aruco_ar.walls.wall import Wall

from .belief import Belief, mixed_covariance
from .flatness import Flatness
from .observations import SeenTags, WallFit, height_deviation, off_others, off_plane, poses_of_tags, squared

MIN_SIGHTINGS = 3        # tags must be seen in one plane this many times to be learned
FORGET_S = 0.5           # a tag seen elsewhere for this time, and MIN_SIGHTINGS times, loses its place
# Places are learned only if a tag has moved this far in the frame since the last time. Views that are nearer to
# each other have much the same errors, and so make the places seem more certain than they are.
LEARN_PX = 10.0
LEARN_ALWAYS = 3         # places are learned this many times at first, even if no tag has moved
# A tag is in its place if the root mean square error of its corners is less than OFF_DEVIATIONS standard
# deviations plus OFF_PX. Even a good wall, lens and print leave an error of OFF_PX.
OFF_DEVIATIONS, OFF_PX = 3.0, 0.2
# Tags are in one plane if each is off the plane of the others by at most COPLANAR, in squared standard
# deviations of 3 numbers. 1 in 30 is off by more. Their heights must also be known as exactly as HEIGHT_M:
# from far away, any tags seem to be in one plane, even if one is on a box.
COPLANAR, HEIGHT_M = 9.0, 0.0125
# Far away, this share of the distance is the limit instead of HEIGHT_M, except for two tags alone.
HEIGHT_SHARE = 0.005
MAX_LEFT_OUT = 6         # if tags contradict each other, this many of them, the worst, are left out in turn
# Of two contradicting tags, one is believed if it puts the camera within JUMP_M of its place at most GAP_S
# earlier.
JUMP_M = 0.2
GAP_S = 0.5
NOT_FLAT = 12.0          # if a learned tag is off by more (1 in 140 is), the wall is learned anew
MAX_SEEN = 24            # more tags in a frame would add little, and take long
MAX_LEARNED = 100        # beyond this number, the learned tag that was used longest ago is forgotten
ALL_TAGS = -1            # in place of an id: all tags together are not in their places


class WallEstimator:
    """Estimates the pose of one wall through a sequence of frames."""

    def __init__(self, wall: Wall | None = None) -> None:
        """``wall``: a Wall, or None to learn one."""
        self._wall = wall
        self.reset()

    def reset(self) -> None:
        """Forget what was learned, and all earlier frames."""
        self.see_no_tags()
        self._places = Places(self._wall)
        self._belief = Belief()
        # How many times in a row a tag, or a group of tags, was seen in one plane.
        self._sightings: Recent[Hashable, int] = Recent()
        self._flatness = Flatness()
        # The known tags that are not in their places: since when, and how often they were seen elsewhere.
        self._elsewhere: dict[int, tuple[float, int]] = {}
        # Where tags were in the frame, pixels, when their places were last learned.
        self._learned_at: dict[int, Floats] = {}
        self._lessons = 0
        # The tags that are not from a file. The one that was not used for the longest time comes first.
        self._learned: dict[int, bool] = {}
        # The time when the camera's place was last known, and that place.
        self._last: tuple[float, Floats] | None = None

    def see_no_tags(self) -> None:
        """Set the results of the last frame to those of a frame without tags.

        ``fit`` is a WallFit or None. ``tag_poses`` is {id: (pose, other pose, the other one's weight)}, of the
        tags that agree, by all of them together. A pose is (rotation, translation, covariance (6, 6)).
        """
        self.fit: WallFit | None = None
        self.tag_poses: dict[int, tuple[Pose, Pose, float]] = {}

    def update(self, seen: SeenTags, now: float) -> None:
        """Estimate the wall's pose in a frame by its tags. ``now``: seconds."""
        self.see_no_tags()
        seen = self._most_useful(seen)
        known = [number for number, tag_id in enumerate(seen.ids) if tag_id in self._places]
        trusted = [number for number in known if seen.ids[number] not in self._elsewhere]
        agreed, fit = self._agreeing(seen, trusted, now)
        if fit is not None:
            self.fit = fit = self._most_probable(fit, now)
            self.tag_poses = poses_of_tags(fit, self._places)
            self._last = now, fit.camera()
            for tag_id in [tag_id for tag_id in fit.ids if tag_id in self._learned]:
                self._learned[tag_id] = self._learned.pop(tag_id)
            rest = self._out_of_place(seen, [number for number in known if number not in agreed], fit)
            if len(agreed) > 1:
                self._learn_places(seen, agreed, fit)
            self._update_elsewhere(seen, rest, now)
            if self._is_flat(seen, fit):
                self._learn_more(seen, fit)
            else:
                self.reset()  # nothing shows which of the tags is off the plane
        elif len(known) > 1:
            self._count_elsewhere(ALL_TAGS, now)
            if self._is_gone(ALL_TAGS, now):
                self.reset()
        if not len(self._places) and len(seen.ids) > 1:
            self._learn_wall(seen)

    def _most_useful(self, seen: SeenTags) -> SeenTags:
        """The known tags and the large ones, if there are too many tags."""
        if len(seen.ids) <= MAX_SEEN:
            return seen
        octaves = np.round(np.log2(side_of(seen.quads)))  # rounded, so that the choice lasts
        numbers = sorted(range(len(seen.ids)), key=lambda number: (
            seen.ids[number] not in self._places, -octaves[number], seen.ids[number]))
        return seen.subset(sorted(numbers[:MAX_SEEN]))

    def _solve(self, seen: SeenTags, some: list[int]) -> WallFit | None:
        """The WallFit for the tags with those indices, the better pose first, or None."""
        ids = [seen.ids[number] for number in some]
        points, spread = self._places.points(ids)
        if len(some) == 1:
            rotation, center, _ = self._places.poses(ids)
            first = seen.poses[0][some[0]] @ rotation[0].T
            rotations, translations = first[None], (seen.poses[1][some[0]] - first @ center[0])[None]
        else:
            rotations, translations, is_posed = approximate_poses(
                points.reshape(1, -1, 3), seen.rays[some].reshape(1, -1, 2))
            if not is_posed[0]:
                return None
        rotation, translation, amounts, squares, covariance = (part[0] for part in refine(
            points.reshape(1, -1, 3), seen.rays[some].reshape(1, -1, 2),
            seen.weights[some].reshape(1, -1, 2, 2), rotations, translations,
            spread.reshape(4 * len(some), 3, spread.shape[-1])))
        errors = squares.reshape(2, len(some), 4).sum(axis=2)
        scale = max(1.0, errors.sum(axis=1).min() / (8 * len(some) - 6)) if len(some) > 1 else 1.0
        cost = errors.sum(axis=1) + (amounts * amounts).sum(axis=1)
        order = np.argsort(cost)
        covariance[:, :6] *= scale**0.5
        covariance[:, :, :6] *= scale**0.5  # the amounts keep theirs
        return WallFit(tuple(ids), rotation[order], translation[order], amounts[order], covariance[order],
                       errors[order[0]], cost[order], scale)

    def _agreeing(self, seen: SeenTags, some: list[int], now: float) -> tuple[list[int], WallFit | None]:
        """The indices of the tags that agree on the wall's pose, and the WallFit by them.

        More than half of the tags must agree. Otherwise the result is an empty list and None.
        """
        fit, rest = self._solve(seen, some) if some else None, list(some)
        while fit is not None:
            usual = fit.amounts[0] @ fit.amounts[0] <= OFF_DEVIATIONS**2 * fit.amounts.shape[1]
            if usual and self._fits(seen, rest, fit.errors).all():
                return rest, fit
            worst = [rest[number] for number in np.argsort(-fit.errors)[:MAX_LEFT_OUT]]
            without = [[other for other in rest if other != number] for number in worst]
            candidates = [self._solve(seen, others) for others in without] if len(rest) > 1 else []
            candidates = [(found, others) for found, others in zip(candidates, without) if found is not None]
            if len(rest) == 2:
                return self._nearest_to_last(candidates, now)
            if not candidates or 2 * (len(rest) - 1) <= len(some):
                break
            fit, rest = min(candidates, key=lambda pair: pair[0].cost[0])
        return [], None

    def _nearest_to_last(self, candidates: list[tuple[WallFit, list[int]]],
                         now: float) -> tuple[list[int], WallFit | None]:
        """Of two tags that contradict each other, the one by which the camera is nearest to its last place."""
        if self._last is None or now - self._last[0] > GAP_S:
            return [], None
        leaps = [min(np.linalg.norm(fit.camera(which) - self._last[1]) for which in (0, 1))
                 for fit, _ in candidates]
        if not leaps or min(leaps) > JUMP_M:
            return [], None
        fit, rest = candidates[int(np.argmin(leaps))]
        return rest, fit

    def _fits(self, seen: SeenTags, some: list[int], errors: Floats) -> Booleans:
        """(n,) bool: whether tags are in their places. ``errors``: (n,), their squared errors."""
        return np.sqrt(errors / 8) * seen.deviation[some] < OFF_DEVIATIONS * seen.deviation[some] + OFF_PX

    def _most_probable(self, fit: WallFit, now: float) -> WallFit:
        """The WallFit, with that pose first which is more probable by all frames together."""
        poses = fit.rotation[None], fit.translation[None], fit.covariance[None, :, :6, :6]
        believed, weight = self._belief.weigh(['wall'], poses, fit.cost[None] / fit.scale, now)
        order = [int(believed[0]), 1 - int(believed[0])]
        return replace(fit, rotation=fit.rotation[order], translation=fit.translation[order],
                       amounts=fit.amounts[order], covariance=fit.covariance[order], weight=float(weight[0]))

    def _out_of_place(self, seen: SeenTags, rest: list[int], fit: WallFit) -> list[int]:
        """The indices of those known tags that are not in their places, by a WallFit of other tags."""
        if not rest:
            return []
        points, _ = self._places.points([seen.ids[number] for number in rest])
        in_camera = points @ fit.rotation[0].T + fit.translation[0]
        off = seen.rays[rest] - in_camera[..., :2] / np.maximum(in_camera[..., 2:], NEAR_M)
        off = seen.weights[rest] @ off[..., None]
        fits = self._fits(seen, rest, (off * off).sum(axis=(1, 2, 3)))
        return [number for number, is_fitting in zip(rest, fits) if not is_fitting]

    def _update_elsewhere(self, seen: SeenTags, displaced: list[int], now: float) -> None:
        """Note which tags are displaced, and forget those that have been so for some time."""
        for number, tag_id in enumerate(seen.ids):
            if number in displaced:
                self._count_elsewhere(tag_id, now)
            else:
                self._elsewhere.pop(tag_id, None)
        self._elsewhere.pop(ALL_TAGS, None)
        for tag_id in [tag_id for tag_id in self._elsewhere if self._is_gone(tag_id, now)]:
            self._forget(tag_id)

    def _forget(self, tag_id: int) -> None:
        self._places.forget(tag_id)
        for memory in (self._elsewhere, self._learned_at, self._learned):
            memory.pop(tag_id, None)

    def _count_elsewhere(self, tag_id: int, now: float) -> None:
        since, times = self._elsewhere.get(tag_id, (now, 0))
        self._elsewhere[tag_id] = since, times + 1

    def _is_gone(self, tag_id: int, now: float) -> bool:
        since, times = self._elsewhere[tag_id]
        return now - since >= FORGET_S and times >= MIN_SIGHTINGS

    def _learn_places(self, seen: SeenTags, agreed: list[int], fit: WallFit) -> None:
        """Improve the places of the tags that agree, if the camera sees them from a new viewpoint."""
        quads = {seen.ids[number]: seen.quads[number] for number in agreed}
        moved = [np.abs(quad - self._learned_at.get(tag_id, np.inf)).max() for tag_id, quad in quads.items()]
        if fit.amounts.shape[1] > 1 and (self._lessons < LEARN_ALWAYS or max(moved) > LEARN_PX):
            self._places.learn(fit.ids, fit.amounts[0], fit.covariance[0, 6:, 6:])
            self._learned_at.update(quads)
            self._lessons += 1

    def _is_flat(self, seen: SeenTags, fit: WallFit) -> bool:
        """Whether the learned tags are in one plane, by their individual poses in the last frames."""
        if self._wall is not None or len(fit.ids) < 2:
            return True
        some = seen.subset([seen.ids.index(tag_id) for tag_id in fit.ids])
        off = self._flatness.update(fit.ids, *off_others(some.believed(), fit.rotation[0]))
        return bool((off < NOT_FLAT).all())

    def _learn_more(self, seen: SeenTags, fit: WallFit) -> None:
        """Learn further tags that are in the wall's plane."""
        some = [number for number, tag_id in enumerate(seen.ids) if tag_id not in self._places]
        if not some:
            return
        (rotation, translation, _), _ = one, other = fit.poses
        plane = rotation, translation, mixed_covariance(one, other, fit.weight)
        off, spread = off_plane(plane, seen.subset(some).believed())
        flat = (squared(off, spread) < COPLANAR) & (height_deviation(spread) < _height_limit(translation))
        for number, is_flat in zip(some, flat):
            tag_id = seen.ids[number]
            self._sightings[tag_id] = self._sightings.get(tag_id, 0) + 1 if is_flat else 0
            if self._sightings[tag_id] >= MIN_SIGHTINGS:
                self._add(seen, number, rotation, translation)

    def _learn_wall(self, seen: SeenTags) -> None:
        """Learn a wall from tags that are seen in one plane, if there are some."""
        rotation, translation, covariance = seen.believed()
        group = sorted(range(len(seen.ids)), key=lambda number: seen.ids[number])
        while len(group) > 1:
            some, axes = (rotation[group], translation[group], covariance[group]), rotation[group[0]]
            off = squared(*off_others(some, axes))
            height = height_deviation(off_others(some, axes, bulge=np.zeros((3, 3)))[1])
            if off.max() > COPLANAR:
                del group[int(np.argmax(off))]  # it fits the others worst
            elif height.max() > (_height_limit(some[1][0]) if len(group) > 2 else HEIGHT_M):
                del group[int(np.argmax(height))]
            else:
                break
        key = tuple(seen.ids[number] for number in group)
        sights = self._sightings.get(key, 0) + 1
        self._sightings.clear()
        if len(group) == 1 or sights < MIN_SIGHTINGS:
            self._sightings[key] = sights
        else:
            self._places.add(key[0], np.zeros(3), seen.sizes[group[0]], exact=True)
            self._learned[key[0]] = True
            for number in group[1:]:
                self._add(seen, number, rotation[group[0]], translation[group[0]])

    def _add(self, seen: SeenTags, number: int, rotation: Floats, translation: Floats) -> None:
        """Add a tag to the wall. ``rotation``, ``translation``: the wall's pose in this frame."""
        which = int(np.argmax(seen.probabilities[number]))
        axes = rotation.T @ seen.poses[0][number, which]
        x, y, _ = rotation.T @ (seen.poses[1][number, which] - translation)
        turn = np.arctan2(axes[1, 0] - axes[0, 1], axes[0, 0] + axes[1, 1])
        if len(self._learned) >= MAX_LEARNED:
            self._forget(next(iter(self._learned)))
        tag_id = seen.ids[number]
        self._places.add(tag_id, np.array([x, y, turn]), seen.sizes[number])
        self._learned[tag_id] = True
        self._sightings.pop(tag_id, None)
        self._lessons = 0


def _height_limit(translation: Floats) -> float:
    """Meters: how exact the height over a plane must be for tags at a place, (3,), to be learned."""
    return max(HEIGHT_M, HEIGHT_SHARE * float(np.linalg.norm(translation)))
