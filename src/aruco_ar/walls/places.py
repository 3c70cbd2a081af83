"""The places of tags on a wall: known from the wall's file, or learned.

A tag's place is (x, y, turn) in wall coordinates: its center, meters, and its
turn counterclockwise, radians. The uncertainty of all places is one matrix,
whose columns are independent deviations. For a few tags, q numbers describe
their uncertainty: at most three for each tag, and a last one for the common
deviation of all sizes.
"""
from __future__ import annotations

from math import radians
from typing import Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.base.recent import Recent
from aruco_ar.tags.tag import square

from .wall import Wall

NEGLIGIBLE = 1e-12              # meters and radians: smaller deviations are dropped
GUESS_DEVIATION = 1.0, 1.0, 1.0  # standard deviations of a new tag's place, which is only a guess: m, m, rad

# The errors of corners are not independent from frame to frame. So all frames together
# make a place at most as certain as this many frames with independent errors would.
INDEPENDENT_FRAMES = 2
# The relative deviation of all sizes together. Views cannot reduce it: if all tags are
# larger, everything is also farther away. It is 0 if a file gives the places of the tags.
SIZE_DEVIATION = 0.001
GROUPS = 16  # the groups of tags that one frame asks for are not many


class Places:
    """The tags known on one wall."""

    def __init__(self, wall: Wall | None = None) -> None:
        """The tags of a Wall, or none at first."""
        tags = () if wall is None else wall.tags
        self._index = {tag.id: number for number, tag in enumerate(tags)}
        self._places = np.array([[tag.x, tag.y, -radians(tag.turn)] for tag in tags]).reshape(-1, 3)
        self._sizes = np.array([tag.side for tag in tags])
        self._deviation = np.zeros((3 * len(tags), 0))
        self._size_deviation = SIZE_DEVIATION if wall is None else 0.0
        # For each group of ids, what ``poses`` returned. Emptied when anything changes.
        self._poses: Recent[tuple[int, ...], tuple[Floats, Floats, Floats]] = Recent(GROUPS)

    def __contains__(self, tag_id: int) -> bool:
        return tag_id in self._index

    def __len__(self) -> int:
        return len(self._index)

    def poses(self, ids: Sequence[int]) -> tuple[Floats, Floats, Floats]:
        """The poses of those tags on the wall: rotations (n, 3, 3), centers (n, 3), deviations (n, 6, q)."""
        key = tuple(ids)
        if key not in self._poses:
            self._poses[key] = self._poses_of(ids)
        return self._poses[key]

    def _poses_of(self, ids: Sequence[int]) -> tuple[Floats, Floats, Floats]:
        number = [self._index[tag_id] for tag_id in ids]
        places = self._places[number]
        turn = places[:, 2].copy()  # with a strided array, NumPy's sine may differ in the last digit
        rotation = np.zeros((len(number), 3, 3))
        rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(turn)
        rotation[:, 1, 0] = np.sin(turn)
        rotation[:, 0, 1] = -rotation[:, 1, 0]
        rotation[:, 2, 2] = 1
        center = places * np.array([1.0, 1.0, 0.0])
        deviation = self._rows(ids) @ self._base(ids)
        off = np.zeros((len(number), 6, deviation.shape[1] + 1))
        off[:, [0, 1, 5], :-1] = deviation.reshape(len(number), 3, -1)
        off[:, :3, -1] = self._size_deviation * center
        return rotation, center, off

    def points(self, ids: Sequence[int]) -> tuple[Floats, Floats]:
        """The corners of those tags, (n, 4, 3) wall meters, and their deviations, (n, 4, 3, q): see refine."""
        rotation, center, off = self.poses(ids)
        arms = square(self._sizes[[self._index[tag_id] for tag_id in ids]]) @ rotation.transpose(0, 2, 1)
        spread = np.repeat(off[:, None, :3], 4, axis=1)
        spread[:, :, 0] -= arms[:, :, 1, None] * off[:, None, 5]
        spread[:, :, 1] += arms[:, :, 0, None] * off[:, None, 5]
        spread[..., -1] += self._size_deviation * arms
        return arms + center[:, None], spread

    def add(self, tag_id: int, place: Floats, size: float, exact: bool = False) -> None:
        """Add a tag at a place, (3,), that is a guess or, if ``exact``, fixed. ``size``: meters, its side."""
        self._poses.clear()
        before = self._deviation.shape
        self._index[tag_id] = len(self._index)
        self._places = np.vstack([self._places, place])
        self._sizes = np.append(self._sizes, size)
        self._deviation = np.pad(self._deviation, ((0, 3), (0, 0 if exact else 3)))
        if not exact:
            self._deviation[before[0]:, before[1]:] = np.diag(GUESS_DEVIATION)

    def _rows(self, ids: Sequence[int]) -> Floats:
        """The deviations of the places of those tags, (3n, all columns)."""
        rows = self._deviation.reshape(len(self._index), 3, -1)[[self._index[tag_id] for tag_id in ids]]
        return rows.reshape(3 * len(ids), -1)

    def _base(self, ids: Sequence[int]) -> Floats:
        """The q - 1 combinations of all deviations that concern those tags, as orthonormal columns."""
        if self._deviation.shape[1] <= 3 * len(ids):
            return np.eye(self._deviation.shape[1])
        return np.linalg.qr(self._rows(ids).T)[0]

    def learn(self, ids: Sequence[int], own: Floats, covariance: Floats) -> None:
        """Update the places of those tags by their estimated deviations.

        ``own``: (q,), in units of the deviations that ``poses`` returned. ``covariance``: (q, q), of ``own``.
        """
        self._poses.clear()
        base = self._base(ids)
        concerned = self._deviation @ base
        self._places = self._places + (concerned @ own[:-1]).reshape(-1, 3)
        # Each deviation had a variance of 1 before. It never grows, and it stays if this view shows nothing of
        # it. For example, all tags but the first may be off together while the first is out of sight.
        variance, axes = np.linalg.eigh(covariance[:-1, :-1])
        factors = np.sqrt(np.maximum(0, np.minimum(variance * (1 + 1 / INDEPENDENT_FRAMES), 1)))
        change = (axes * factors) @ axes.T - np.eye(len(axes))
        self._deviation = self._deviation + concerned @ change @ base.T

    def forget(self, tag_id: int) -> None:
        """Forget a tag, but keep what was learned about the others."""
        self._poses.clear()
        number = self._index.pop(tag_id)
        self._index = {other: place - (place > number) for other, place in self._index.items()}
        self._places = np.delete(self._places, number, axis=0)
        self._sizes = np.delete(self._sizes, number)
        rest = np.delete(self._deviation, slice(3 * number, 3 * number + 3), axis=0)
        axes, lengths, _ = np.linalg.svd(rest, full_matrices=False)
        self._deviation = (axes * lengths)[:, lengths > NEGLIGIBLE]
