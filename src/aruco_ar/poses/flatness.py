"""How far tags are off the plane of the other tags, judged by the last frames together.

A tag on a box a few centimeters in front of the wall looks like a tag on the
wall. Only a near view or many frames show the difference. So the weighted mean
of the last frames is taken. It is assumed to be no more certain than a single frame: the
errors of corners repeat from frame to frame, and paper bulges in all of them.
"""
from __future__ import annotations

from typing import Iterable

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.base.recent import Recent

MEMORY_FRAMES = 15  # about this many of the last frames count
FADE = 1 - 1 / MEMORY_FRAMES


class Flatness:
    """The mean distances of tags from the plane of the others, by their ids."""

    def __init__(self) -> None:
        # Fading sums over frames: information (3, 3), information times distance (3,), and the count.
        self._sums: Recent[int, tuple[Floats, Floats, float]] = Recent()

    def update(self, ids: Iterable[int], offs: Floats, spreads: Floats) -> tuple[Floats, Floats]:
        """Add n tags of a frame. Returns their means, (n, 3), with covariances, (n, 3, 3).

        ``offs``: (n, 3), as from off_others, and ``spreads``: (n, 3, 3), their covariances in this frame.
        """
        means, covariances = [], []
        for tag_id, off, added in zip(ids, offs, np.linalg.inv(spreads)):
            information, weighted, frames = self._sums.get(tag_id, (0.0, 0.0, 0.0))
            information, weighted, frames = self._sums[tag_id] = (
                FADE * information + added, FADE * weighted + added @ off, FADE * frames + 1)
            covariance = np.linalg.inv(information)
            means.append(covariance @ weighted)
            covariances.append(covariance * frames)
        return np.array(means), np.array(covariances)
