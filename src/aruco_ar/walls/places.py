"""Where on a wall its tags are: known from its file, or learned.

A tag's place is (x, y, turn): its center, meters, and its turn counterclockwise,
radians, in wall coordinates. How places may be off is told together, by a
matrix whose columns are independent deviations. Of some tags q of them tell all,
three for each at most, and the last one is that of all sizes.
"""
from __future__ import annotations

from math import radians
from typing import Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.tags.tag import square

from .wall import Wall

NOTHING = 1e-12           # meters and radians: a deviation by less is none
ANYWHERE = 1.0, 1.0, 1.0  # m, m, rad: how far off the place of a new tag may be, which is only a guess

# So many frames' worth is learned about a place, and no more: the errors of the
# corners are not wholly independent from frame to frame.
LESSONS = 2
# All sides may be so much longer than they seem, or are said to be; no view tells,
# since then all else is so much farther. (Where a file says where tags are, that tells.)
SIZE_DEVIATION = 0.001


class Places:
    """The tags known on one wall."""

    def __init__(self, wall: Wall | None = None) -> None:
        """Those of a wall.Wall, or none."""
        tags = () if wall is None else wall.tags
        self._index = {tag.id: number for number, tag in enumerate(tags)}
        self._places = np.array([[tag.x, tag.y, -radians(tag.turn)] for tag in tags]).reshape(-1, 3)
        self._sizes = np.array([tag.side for tag in tags])
        self._deviation = np.zeros((3 * len(tags), 0))
        self._size_deviation = SIZE_DEVIATION if wall is None else 0.0

    def __contains__(self, tag_id: int) -> bool:
        return tag_id in self._index

    def __len__(self) -> int:
        return len(self._index)

    def poses(self, ids: Sequence[int]) -> tuple[Floats, Floats, Floats]:
        """Of those tags: rotations (n, 3, 3), centers (n, 3), and how these may be off, (n, 6, q)."""
        number = [self._index[tag_id] for tag_id in ids]
        # Contiguous: of numbers that lie apart NumPy may compute other last digits, by where they are.
        x, y, turn = np.ascontiguousarray(self._places[number].T)
        rotation = np.zeros((len(number), 3, 3))
        rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(turn)
        rotation[:, 1, 0] = np.sin(turn)
        rotation[:, 0, 1] = -rotation[:, 1, 0]
        rotation[:, 2, 2] = 1
        center = np.stack([x, y, np.zeros(len(number))], axis=1)
        deviation = self._rows(ids) @ self._base(ids)
        off = np.zeros((len(number), 6, deviation.shape[1] + 1))
        off[:, [0, 1, 5], :-1] = deviation.reshape(len(number), 3, -1)
        off[:, :3, -1] = self._size_deviation * center
        return rotation, center, off

    def points(self, ids: Sequence[int]) -> tuple[Floats, Floats]:
        """Their corners, (n, 4, 3) wall meters, and how these may be off, (n, 4, 3, q): see refine."""
        rotation, center, off = self.poses(ids)
        arms = square(self._sizes[[self._index[tag_id] for tag_id in ids]]) @ rotation.transpose(0, 2, 1)
        spread = np.repeat(off[:, None, :3], 4, axis=1)
        spread[:, :, 0] -= arms[:, :, 1, None] * off[:, None, 5]
        spread[:, :, 1] += arms[:, :, 0, None] * off[:, None, 5]
        spread[..., -1] += self._size_deviation * arms
        return arms + center[:, None], spread

    def add(self, tag_id: int, place: Floats, size: float, exact: bool = False) -> None:
        """A tag that was seen at a place, (3,), which is exactly or only about its own."""
        before = self._deviation.shape
        self._index[tag_id] = len(self._index)
        self._places = np.vstack([self._places, place])
        self._sizes = np.append(self._sizes, size)
        self._deviation = np.pad(self._deviation, ((0, 3), (0, 0 if exact else 3)))
        if not exact:
            self._deviation[before[0]:, before[1]:] = np.diag(ANYWHERE)

    def _rows(self, ids: Sequence[int]) -> Floats:
        """How the places of those tags may be off."""
        rows = self._deviation.reshape(len(self._index), 3, -1)[[self._index[tag_id] for tag_id in ids]]
        return rows.reshape(3 * len(ids), -1)

    def _base(self, ids: Sequence[int]) -> Floats:
        """The q - 1 deviations that tell all about those tags, as columns of length 1 in terms of all."""
        if self._deviation.shape[1] <= 3 * len(ids):
            return np.eye(self._deviation.shape[1])
        return np.linalg.qr(self._rows(ids).T)[0]

    def learn(self, ids: Sequence[int], own: Floats, covariance: Floats) -> None:
        """Take in by how many deviations, (q,), those tags turned out to be off, and how surely, (q, q)."""
        base = self._base(ids)
        told = self._deviation @ base
        self._places = self._places + (told @ own[:-1]).reshape(-1, 3)
        # Before, all were 1. What a lesson does not tell is known no less after it: with the first tag
        # out of sight all others may have moved together, and no view tells.
        variance, axes = np.linalg.eigh(covariance[:-1, :-1])
        less = (axes * np.sqrt(np.clip(variance * (1 + 1 / LESSONS), 0, 1))) @ axes.T - np.eye(len(axes))
        self._deviation = self._deviation + told @ less @ base.T

    def forget(self, tag_id: int) -> None:
        """Forget a tag; what was learned about the others stays."""
        number = self._index.pop(tag_id)
        self._index = {other: place - (place > number) for other, place in self._index.items()}
        self._places = np.delete(self._places, number, axis=0)
        self._sizes = np.delete(self._sizes, number)
        rest = np.delete(self._deviation, slice(3 * number, 3 * number + 3), axis=0)
        axes, lengths, _ = np.linalg.svd(rest, full_matrices=False)
        self._deviation = (axes * lengths)[:, lengths > NOTHING]
