"""The wall as its tags show it together, and learning which tags are on it.

One pose of the wall must explain the corners of all its tags in sight; so they
say where the camera is much better than each of them alone.
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

from .belief import Belief, mixture
from .flatness import Flatness
from .sight import Sight, View, height_deviation, off_others, off_plane, poses_of_tags, squared

SIGHTS = 3               # as often must tags be seen in one plane, to be believed
FORGET_S = 0.5           # so long, and as often, a tag is seen elsewhere before its place is forgotten
LEARN_PX = 2.0           # tags seen no farther from where they last taught their places teach nothing new
LEARN_FIRST = 3          # but so often they do
# A tag is where it should be if its corners are off by less than this, rms:
# so many standard deviations, and what even a good wall, lens and print leave.
OFF_DEVIATIONS, OFF_PX = 3.0, 0.2
# Tags are in one plane if each is off that of the others by no more than this, in squared
# deviations of 3 numbers, of which 1 in 30 is more; and if that says something: of tags far
# away any may be in one plane, though one is on a box, and their leaning tells only when near.
LIKELY, SURE_M = 9.0, 0.0125
SURE_PART = 0.005        # of the distance: from farther away only so sure, but of two tags alone
TRIED = 6                # of tags that contradict each other, so many, the worst, are left out in turn
JUMP_M = 0.2             # of two tags that contradict each other, one leaves the camera within this
GAP_S = 0.5              # of where it was at most so long ago
UNLIKELY = 12.0          # learned tags must be off by more, of which 1 in 140 is, to be learned anew
MOST_IN_SIGHT = 24       # of more tags in a frame the others would tell nothing new, and take long to ask
MOST_LEARNED = 100       # of more tags that were learned, the one that was used longest ago is forgotten
ALL = -1                 # in place of an id: all tags, among those that are not where they belong


class WallView:
    """Follows one wall through a sequence of frames."""

    def __init__(self, wall: Wall | None = None) -> None:
        """``wall``: a wall.Wall, or None to learn one."""
        self._wall = wall
        self.reset()

    def reset(self) -> None:
        """Forget what was learned and seen.

        Of the last frame, ``view`` is a View or None, and ``tag_poses`` are {id: (pose, other pose, its
        weight)} of the tags that agree, by all of them together; a pose is (rotation, translation,
        covariance (6, 6)).
        """
        self.miss()
        self._places = Places(self._wall)
        self._belief = Belief()
        self._sights: Recent[Hashable, int] = Recent()  # how often in a row tags were seen in one plane
        self._flatness = Flatness()
        # Of a known tag not where it belongs: since when, and how often seen so.
        self._elsewhere: dict[int, tuple[float, int]] = {}
        # Where tags were in the frame when they last taught their places.
        self._taught: dict[int, Floats] = {}
        self._teachings = 0
        # The tags that no file tells of; the one that was used longest ago comes first.
        self._learned: dict[int, bool] = {}
        # When and where the camera was last known to be.
        self._last: tuple[float, Floats] | None = None

    def miss(self) -> None:
        """Take in a frame without tags."""
        self.view: View | None = None
        self.tag_poses: dict[int, tuple[Pose, Pose, float]] = {}

    def update(self, sight: Sight, now: float) -> None:
        """Find the wall in a frame, by the Sight of its tags."""
        self.miss()
        sight = self._foremost(sight)
        known = [number for number, tag_id in enumerate(sight.ids) if tag_id in self._places]
        trusted = [number for number in known if sight.ids[number] not in self._elsewhere]
        agreed, view = self._agreed(sight, trusted, now)
        if view is not None:
            self.view = view = self._believed(view, now)
            self.tag_poses = poses_of_tags(view, self._places)
            self._last = now, view.camera()
            for tag_id in [tag_id for tag_id in view.ids if tag_id in self._learned]:
                self._learned[tag_id] = self._learned.pop(tag_id)
            rest = self._astray(sight, [number for number in known if number not in agreed], view)
            if len(agreed) > 1:
                self._learn(sight, agreed, view)
            self._forget(sight, rest, now)
            if self._is_flat(sight, view):
                self._find_more(sight, view)
            else:
                self.reset()  # nobody knows which of the tags is the one off the plane
        elif len(known) > 1:
            self._doubt(ALL, now)
            if self._is_gone(ALL, now):
                self.reset()
        if not len(self._places) and len(sight.ids) > 1:
            self._begin(sight)

    def _foremost(self, sight: Sight) -> Sight:
        """The Sight of the known tags and the large ones, if there are too many."""
        if len(sight.ids) <= MOST_IN_SIGHT:
            return sight
        octaves = np.round(np.log2(side_of(sight.quads)))  # not the very sides: the choice should last
        numbers = sorted(range(len(sight.ids)), key=lambda number: (
            sight.ids[number] not in self._places, -octaves[number], sight.ids[number]))
        return sight.some(sorted(numbers[:MOST_IN_SIGHT]))

    def _solve(self, sight: Sight, some: list[int]) -> View | None:
        """The View that best explains those tags, the better pose first; or None."""
        ids = [sight.ids[number] for number in some]
        points, spread = self._places.points(ids)
        if len(some) == 1:
            rotation, center, _ = self._places.poses(ids)
            first = sight.poses[0][some[0]] @ rotation[0].T
            guess = first, sight.poses[1][some[0]] - first @ center[0]
        else:
            guess = approximate_poses(points.reshape(-1, 3), sight.rays[some].reshape(-1, 2))
        if guess is None:
            return None
        weights = sight.weights[some].reshape(-1, 2, 2)
        rotation, translation, own, squares, covariance = refine(
            points.reshape(-1, 3), sight.rays[some].reshape(-1, 2), weights, guess[0], guess[1],
            spread.reshape(4 * len(some), 3, spread.shape[-1]))
        off = squares.reshape(2, len(some), 4).sum(axis=2)
        scale = max(1.0, off.sum(axis=1).min() / (8 * len(some) - 6)) if len(some) > 1 else 1.0
        cost = off.sum(axis=1) + (own * own).sum(axis=1)
        order = np.argsort(cost)
        inflate = np.append(np.full(6, scale**0.5), np.ones(own.shape[1]))  # what is known of the places stays
        return View(tuple(ids), rotation[order], translation[order], own[order],
                    covariance[order] * np.outer(inflate, inflate),
                    off[order[0]], cost[order], scale)

    def _agreed(self, sight: Sight, some: list[int], now: float) -> tuple[list[int], View | None]:
        """Those of some tags that agree where the wall is, more than half of them, and the View by them."""
        view, rest = self._solve(sight, some) if some else None, list(some)
        while view is not None:
            usual = view.own[0] @ view.own[0] <= OFF_DEVIATIONS**2 * view.own.shape[1]
            if usual and self._fits(sight, rest, view.off).all():
                return rest, view
            worst = [rest[number] for number in np.argsort(-view.off)[:TRIED]]
            without = [[other for other in rest if other != number] for number in worst]
            views = [self._solve(sight, others) for others in without] if len(rest) > 1 else []
            views = [(found, others) for found, others in zip(views, without) if found is not None]
            if len(rest) == 2:
                return self._nearest(views, now)
            if not views or 2 * (len(rest) - 1) <= len(some):
                break
            view, rest = min(views, key=lambda pair: pair[0].cost[0])
        return [], None

    def _nearest(self, views: list[tuple[View, list[int]]], now: float) -> tuple[list[int], View | None]:
        """Of tags that contradict each other, the one that leaves the camera where it was."""
        if self._last is None or now - self._last[0] > GAP_S:
            return [], None
        leaps = [min(np.linalg.norm(view.camera(which) - self._last[1]) for which in (0, 1))
                 for view, _ in views]
        if not leaps or min(leaps) > JUMP_M:
            return [], None
        view, rest = views[int(np.argmin(leaps))]
        return rest, view

    def _fits(self, sight: Sight, some: list[int], off: Floats) -> Booleans:
        """(n,) bool: whether tags, off by squared deviations (n,), are where they should be."""
        return np.sqrt(off / 8) * sight.deviation[some] < OFF_DEVIATIONS * sight.deviation[some] + OFF_PX

    def _believed(self, view: View, now: float) -> View:
        """The View with the pose first that all frames together speak for."""
        poses = view.rotation[None], view.translation[None], view.covariance[None, :, :6, :6]
        believed, weight = self._belief.weigh(['wall'], poses, view.cost[None] / view.scale, now)
        order = [int(believed[0]), 1 - int(believed[0])]
        return replace(view, rotation=view.rotation[order], translation=view.translation[order],
                       own=view.own[order], covariance=view.covariance[order], weight=float(weight[0]))

    def _astray(self, sight: Sight, rest: list[int], view: View) -> list[int]:
        """Those of known tags that are not where they belong, going by a View that others gave."""
        if not rest:
            return []
        points, _ = self._places.points([sight.ids[number] for number in rest])
        seen = points @ view.rotation[0].T + view.translation[0]
        off = sight.rays[rest] - seen[..., :2] / np.maximum(seen[..., 2:], NEAR_M)
        off = sight.weights[rest] @ off[..., None]
        fits = self._fits(sight, rest, (off * off).sum(axis=(1, 2, 3)))
        return [number for number, fit in zip(rest, fits) if not fit]

    def _forget(self, sight: Sight, astray: list[int], now: float) -> None:
        """Trust the tags in sight again but for those astray, and forget these if they stay so."""
        for number, tag_id in enumerate(sight.ids):
            if number in astray:
                self._doubt(tag_id, now)
            else:
                self._elsewhere.pop(tag_id, None)
        self._elsewhere.pop(ALL, None)
        for tag_id in [tag_id for tag_id in self._elsewhere if self._is_gone(tag_id, now)]:
            self._drop(tag_id)

    def _drop(self, tag_id: int) -> None:
        self._places.forget(tag_id)
        for memory in (self._elsewhere, self._taught, self._learned):
            memory.pop(tag_id, None)

    def _doubt(self, tag_id: int, now: float) -> None:
        since, times = self._elsewhere.get(tag_id, (now, 0))
        self._elsewhere[tag_id] = since, times + 1

    def _is_gone(self, tag_id: int, now: float) -> bool:
        since, times = self._elsewhere[tag_id]
        return now - since >= FORGET_S and times >= SIGHTS

    def _learn(self, sight: Sight, agreed: list[int], view: View) -> None:
        """Learn the places better, if the tags are seen from elsewhere than before."""
        quads = {sight.ids[number]: sight.quads[number] for number in agreed}
        moved = [np.abs(quad - self._taught.get(tag_id, np.inf)).max() for tag_id, quad in quads.items()]
        if view.own.shape[1] > 1 and (self._teachings < LEARN_FIRST or max(moved) > LEARN_PX):
            self._places.learn(view.ids, view.own[0], view.covariance[0, 6:, 6:])
            self._taught.update(quads)
            self._teachings += 1

    def _is_flat(self, sight: Sight, view: View) -> bool:
        """Whether the tags that were learned are in one plane, by their own poses in the last frames."""
        if self._wall is not None or len(view.ids) < 2:
            return True
        some = sight.some([sight.ids.index(tag_id) for tag_id in view.ids])
        off, spread = self._flatness.update(view.ids, *off_others(some.believed(), view.rotation[0]))
        return bool((squared(off, spread) < UNLIKELY).all())

    def _find_more(self, sight: Sight, view: View) -> None:
        """Look for further tags on the wall's plane."""
        some = [number for number, tag_id in enumerate(sight.ids) if tag_id not in self._places]
        if not some:
            return
        (rotation, translation, _), _ = one, other = view.poses
        plane = rotation, translation, mixture(one, other, view.weight)[0]
        off, spread = off_plane(plane, sight.some(some).believed())
        flat = (squared(off, spread) < LIKELY) & (height_deviation(spread) < _sure_height(translation))
        for number, is_flat in zip(some, flat):
            tag_id = sight.ids[number]
            self._sights[tag_id] = self._sights.get(tag_id, 0) + 1 if is_flat else 0
            if self._sights[tag_id] >= SIGHTS:
                self._add(sight, number, rotation, translation)

    def _begin(self, sight: Sight) -> None:
        """Learn a wall of tags seen in one plane, if there are some."""
        rotation, translation, covariance = sight.believed()
        group = sorted(range(len(sight.ids)), key=lambda number: sight.ids[number])
        while len(group) > 1:
            some, axes = (rotation[group], translation[group], covariance[group]), rotation[group[0]]
            off = squared(*off_others(some, axes))
            height = height_deviation(off_others(some, axes, bulge=np.zeros((3, 3)))[1])
            if off.max() > LIKELY:
                del group[int(np.argmax(off))]  # without it, the others fit best
            elif height.max() > (_sure_height(some[1][0]) if len(group) > 2 else SURE_M):
                del group[int(np.argmax(height))]
            else:
                break
        key = tuple(sight.ids[number] for number in group)
        sights = self._sights.get(key, 0) + 1
        self._sights.clear()
        if len(group) == 1 or sights < SIGHTS:
            self._sights[key] = sights
        else:
            self._places.add(key[0], np.zeros(3), sight.sizes[group[0]], exact=True)
            self._learned[key[0]] = True
            for number in group[1:]:
                self._add(sight, number, rotation[group[0]], translation[group[0]])

    def _add(self, sight: Sight, number: int, rotation: Floats, translation: Floats) -> None:
        """Take a tag for one of the wall, which has that pose."""
        which = int(np.argmax(sight.likely[number]))
        axes = rotation.T @ sight.poses[0][number, which]
        x, y, _ = rotation.T @ (sight.poses[1][number, which] - translation)
        turn = np.arctan2(axes[1, 0] - axes[0, 1], axes[0, 0] + axes[1, 1])
        if len(self._learned) >= MOST_LEARNED:
            self._drop(next(iter(self._learned)))
        tag_id = sight.ids[number]
        self._places.add(tag_id, np.array([x, y, turn]), sight.sizes[number])
        self._learned[tag_id] = True
        self._sights.pop(tag_id, None)
        self._teachings = 0


def _sure_height(translation: Floats) -> float:
    """Meters: how surely heights over a plane must be known of tags at a place (3,) in the optical frame."""
    return max(SURE_M, SURE_PART * float(np.linalg.norm(translation)))
