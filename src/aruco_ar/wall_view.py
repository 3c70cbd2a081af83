"""The wall as its tags show it together, and learning which tags are on it.

One pose of the wall must explain the corners of all its tags in sight; so they
say where the camera is much better than each of them alone.
"""
from dataclasses import dataclass, replace
from typing import Tuple

import numpy as np

from .belief import Belief
from .places import Places
from .solving import NEAR_M, crossed, guesses, refine
from .tags import Tag

SIGHTS = 3               # as often must tags be seen in one plane, to be believed
FORGET_S = 0.5           # so long, and as often, a tag is seen elsewhere before its place is forgotten
LEARN_PX = 2.0           # tags seen no farther from where they last taught their places teach nothing new
LEARN_FIRST = 5          # but so often they do
# A tag is where it should be if its corners are off by less than this, rms:
# so many standard deviations, and what even a good wall, lens and print leave.
OFF_DEVIATIONS, OFF_PX = 3.0, 0.2
# Tags are in one plane if the one is off that of the other by no more than is
# likely (squared deviations of 3 numbers, 1 of 1,000), or than paper bulges.
UNLIKELY, BULGE_M, BULGE_RAD = 16.0, 0.003, 0.02
POSSIBLE = 0.01          # a pose of less weight is none that a tag may have
JUMP_M = 0.2             # of two tags that contradict each other, one leaves the camera within this
GAP_S = 0.5              # of where it was at most so long ago
ALL = None               # what stands for all tags among those that are not where they belong


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
    (2,), those of all by each pose. ``weight``: of the second pose.
    """

    ids: Tuple[int, ...]
    rotation: np.ndarray
    translation: np.ndarray
    own: np.ndarray
    covariance: np.ndarray
    off: np.ndarray
    cost: np.ndarray
    weight: float = 0.0

    @property
    def poses(self):
        """Both as (rotation, translation, covariance (6, 6))."""
        return list(zip(self.rotation, self.translation, self.covariance[:, :6, :6]))


class WallView:
    """Follows one wall through a sequence of frames."""

    def __init__(self, wall=None):
        """``wall``: a wall.Wall, or None to learn one."""
        self._wall = wall
        self.places = Places(wall)
        self._belief = Belief()
        self._sights = {}        # of a tag on the wall's plane, or of two tags on one plane
        self._elsewhere = {}     # a known tag not where it belongs: since when, and how often seen so
        self._taught = {}        # where tags were in the frame when they last taught their places
        self._teachings = 0
        self._last = None        # when and where the camera was last known to be
        self.view = None

    def update(self, sight, now):
        """Find the wall in a frame; ``view`` then is a View or None."""
        self.view = None
        known = [number for number, tag_id in enumerate(sight.ids) if tag_id in self.places]
        trusted = [number for number in known if sight.ids[number] not in self._elsewhere]
        agreed, view = self._agreed(sight, trusted, now)
        if view is not None:
            self.view = self._believed(view, now)
            self._check(sight, known, agreed, now)
            self._last = now, _camera(self.view)
            if len(agreed) > 1:
                self._learn(sight, agreed, self.view)
            self._find_more(sight, self.view)
        elif len(known) > 1:
            self._doubt(ALL, now)
            if self._is_gone(ALL, now):
                self.__init__(self._wall)
        if not len(self.places) and len(sight.ids) > 1:
            self._begin(sight)

    def tag_poses(self):
        """{id: (pose, other pose, its weight)} of the tags that agree, by all of them together.

        A pose is (rotation, translation, covariance (6, 6)).
        """
        if self.view is None:
            return {}
        rotation, center, spread = self.places.poses(self.view.ids)
        found = {tag_id: [] for tag_id in self.view.ids}
        for which in (0, 1):
            turn = self.view.rotation[which]
            arms = center @ turn.T
            moves = np.zeros((len(arms), 6, self.view.covariance.shape[1]))
            moves[:, :, :6] = np.eye(6)
            moves[:, :3, 3:6] = -crossed(arms)
            moves[:, :3, 6:], moves[:, 3:, 6:] = turn @ spread[:, :3], turn @ spread[:, 3:]
            covariance = moves @ self.view.covariance[which] @ moves.swapaxes(1, 2)
            for number, tag_id in enumerate(self.view.ids):
                found[tag_id].append((turn @ rotation[number], arms[number] + self.view.translation[which],
                                      covariance[number]))
        return {tag_id: (*poses, self.view.weight) for tag_id, poses in found.items()}

    def _solve(self, sight, some):
        """The View that best explains those tags, the better pose first; or None."""
        ids = [sight.ids[number] for number in some]
        points, spread = self.places.points(ids)
        if len(some) == 1:
            rotation, center, _ = self.places.poses(ids)
            first = sight.poses[0][some[0]] @ rotation[0].T
            guess = first, sight.poses[1][some[0]] - first @ center[0]
        else:
            guess = guesses(points.reshape(-1, 3), sight.rays[some].reshape(-1, 2))
        if guess is None:
            return None
        weights = sight.weights[some].reshape(-1, 2, 2)
        rotation, translation, own, squares, covariance = refine(
            points.reshape(-1, 3), sight.rays[some].reshape(-1, 2), weights, *guess,
            spread=spread.reshape(4 * len(some), 3, spread.shape[-1]))
        off = squares.reshape(2, len(some), 4).sum(axis=2)
        scale = max(1.0, off.sum(axis=1).min() / (8 * len(some) - 6)) if len(some) > 1 else 1.0
        cost = (off.sum(axis=1) + (own * own).sum(axis=1)) / scale
        order = np.argsort(cost)
        return View(tuple(ids), rotation[order], translation[order], own[order], covariance[order] * scale,
                    off[order[0]], cost[order])

    def _agreed(self, sight, some, now):
        """Those of some tags that agree where the wall is, more than half of them, and the View by them."""
        view, rest = self._solve(sight, some) if some else None, list(some)
        while view is not None:
            if self._fits(sight, rest, view.off).all():
                return rest, view
            without = [[other for other in rest if other != number] for number in rest]
            views = [self._solve(sight, others) for others in without] if len(rest) > 1 else []
            views = [(found, others) for found, others in zip(views, without) if found is not None]
            if len(rest) == 2:
                return self._nearest(views, now)
            if not views or 2 * (len(rest) - 1) <= len(some):
                break
            view, rest = min(views, key=lambda pair: pair[0].cost[0])
        return [], None

    def _nearest(self, views, now):
        """Of tags that contradict each other, the one that leaves the camera where it was."""
        if self._last is None or now - self._last[0] > GAP_S:
            return [], None
        leaps = [min(np.linalg.norm(_camera(view, which) - self._last[1]) for which in (0, 1)) for view, _ in views]
        if not leaps or min(leaps) > JUMP_M:
            return [], None
        view, rest = views[int(np.argmin(leaps))]
        return rest, view

    def _fits(self, sight, some, off):
        """(n,) bool: whether tags, off by squared deviations (n,), are where they should be."""
        return np.sqrt(off / 8) * sight.deviation[some] < OFF_DEVIATIONS * sight.deviation[some] + OFF_PX

    def _believed(self, view, now):
        """The View with the pose first that all frames together speak for."""
        poses = view.rotation[None], view.translation[None], view.covariance[None, :, :6, :6]
        believed, weight = self._belief.weigh(['wall'], poses, view.cost[None], now)
        order = [int(believed[0]), 1 - int(believed[0])]
        return replace(view, rotation=view.rotation[order], translation=view.translation[order],
                       own=view.own[order], covariance=view.covariance[order], weight=float(weight[0]))

    def _check(self, sight, known, agreed, now):
        """See which known tags are not where they belong, and forget those that stay so."""
        rest = [number for number in known if number not in agreed]
        if not rest:
            back = []
        else:
            points, _ = self.places.points([sight.ids[number] for number in rest])
            seen = points @ self.view.rotation[0].T + self.view.translation[0]
            off = np.einsum('nkij,nkj->nki', sight.weights[rest],
                            sight.rays[rest] - seen[..., :2] / np.maximum(seen[..., 2:], NEAR_M))
            fits = self._fits(sight, rest, (off * off).sum(axis=(1, 2)))
            back = [number for number, fit in zip(rest, fits) if fit]
        for number in rest:
            if number not in back:
                self._doubt(sight.ids[number], now)
        for number in agreed + back:
            self._elsewhere.pop(sight.ids[number], None)
        self._elsewhere.pop(ALL, None)
        for tag_id in [tag_id for tag_id in self._elsewhere if self._is_gone(tag_id, now)]:
            self.places.forget(tag_id)
            del self._elsewhere[tag_id]

    def _doubt(self, tag_id, now):
        since, times = self._elsewhere.get(tag_id, (now, 0))
        self._elsewhere[tag_id] = since, times + 1

    def _is_gone(self, tag_id, now):
        since, times = self._elsewhere[tag_id]
        return now - since >= FORGET_S and times >= SIGHTS

    def _learn(self, sight, agreed, view):
        """Learn the places better, if the tags are seen from elsewhere than before."""
        quads = {sight.ids[number]: sight.quads[number] for number in agreed}
        moved = [np.abs(quad - self._taught.get(tag_id, np.inf)).max() for tag_id, quad in quads.items()]
        if view.own.shape[1] and (self._teachings < LEARN_FIRST or max(moved) > LEARN_PX):
            self.places.learn(view.own[0], view.covariance[0, 6:, 6:])
            self._taught.update(quads)
            self._teachings += 1
            self.view = replace(view, own=np.zeros_like(view.own))

    def _find_more(self, sight, view):
        """Look for further tags on the wall's plane."""
        for number, tag_id in enumerate(sight.ids):
            if tag_id in self.places:
                continue
            one = tuple(part[None, :1] for part in (view.rotation, view.translation, view.covariance[:, :6, :6]))
            other = tuple(part[number][None] for part in sight.poses)
            flat = _off_plane(one, other)[0, 0, 0] < UNLIKELY
            flat &= sight.likely[number] > POSSIBLE
            self._sights[tag_id] = self._sights.get(tag_id, 0) + 1 if flat.any() else 0
            if self._sights[tag_id] >= SIGHTS:
                self._add(sight, number, int(np.argmax(flat * sight.likely[number])), view.rotation[0],
                          view.translation[0])

    def _begin(self, sight):
        """Learn a wall of tags seen in one plane, if there are some."""
        order = np.argsort(sight.ids)
        poses = tuple(part[order] for part in sight.poses)
        likely = sight.likely[order] > POSSIBLE
        flat = _off_plane(poses, poses) < UNLIKELY                           # (n, n, 2, 2)
        flat &= likely[:, None, :, None] & likely[None, :, None, :]
        pairs = flat.any(axis=(2, 3))
        for first, second in zip(*np.triu_indices(len(order), 1)):
            key = sight.ids[order[first]], sight.ids[order[second]]
            self._sights[key] = self._sights.get(key, 0) + 1 if pairs[first, second] else 0
        for first, number in enumerate(order):
            others = [second for second in range(first + 1, len(order))
                      if self._sights[sight.ids[number], sight.ids[order[second]]] >= SIGHTS]
            if others:
                mine = int(np.argmax([np.where(flat[first, others, which].any(axis=1), 1, 0).sum()
                                      + sight.likely[number][which] for which in (0, 1)]))
                self.places.add(sight.ids[number], np.zeros(3), sight.sizes[number], exact=True)
                rotation, translation = sight.poses[0][number, mine], sight.poses[1][number, mine]
                for second in others:
                    which = int(np.argmax(flat[first, second, mine] + sight.likely[order[second]]))
                    self._add(sight, order[second], which, rotation, translation)
                self._sights.clear()
                return

    def _add(self, sight, number, which, rotation, translation):
        """Take a tag, with one of its poses, for one of the wall, which has that pose."""
        axes = rotation.T @ sight.poses[0][number, which]
        x, y, _ = rotation.T @ (sight.poses[1][number, which] - translation)
        turn = np.arctan2(axes[1, 0] - axes[0, 1], axes[0, 0] + axes[1, 1])
        self.places.add(sight.ids[number], np.array([x, y, turn]), sight.sizes[number])
        self._sights.pop(sight.ids[number], None)
        self._teachings = 0


def _camera(view, which=0):
    """(3,) meters: where the camera is in wall coordinates."""
    return -view.rotation[which].T @ view.translation[which]


def _off_plane(ones, others):
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
    one = np.concatenate([np.concatenate([-shift, lift], axis=-1), np.concatenate([none, -lean], axis=-1)], axis=-2)
    other = np.concatenate([np.concatenate([shift, 0 * lift], axis=-1), np.concatenate([none, lean], axis=-1)],
                           axis=-2)
    spread = one @ covariance @ one.swapaxes(-1, -2) + other @ other_covariance @ other.swapaxes(-1, -2)
    spread = spread + np.diag([BULGE_M, BULGE_RAD, BULGE_RAD]) ** 2
    return np.einsum('...i,...i->...', off, np.linalg.solve(spread, off[..., None])[..., 0])
