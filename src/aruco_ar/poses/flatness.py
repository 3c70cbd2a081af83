"""How far tags are off the plane of others: what frame after frame says about it, taken together.

A tag on a box a few centimeters before the wall can be told from one on it only
from near, or by many frames. The mean of the last ones counts, each as much as
it says. It is taken to be no surer than one of them is, since the errors of
corners repeat from frame to frame, and a sheet of paper bulges in all of them.
"""
from __future__ import annotations

from typing import Iterable

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.base.recent import Recent

MEMORY_FRAMES = 15  # about so many frames, the last ones, count
FADE = 1 - 1 / MEMORY_FRAMES


class Flatness:
    """What is known of tags, by their ids."""

    def __init__(self) -> None:
        # Sums over frames: how surely, (3, 3), that times how far off, (3,), and of how many.
        self._known: Recent[int, tuple[Floats, Floats, float]] = Recent()

    def update(self, ids: Iterable[int], offs: Floats, spreads: Floats) -> tuple[Floats, Floats]:
        """Take in how far off n tags are in a frame, (n, 3) and covariances (n, 3, 3); the same of the mean."""
        means, covariances = [], []
        for tag_id, off, certain in zip(ids, offs, np.linalg.inv(spreads)):
            sure, told, frames = self._known.get(tag_id, (0.0, 0.0, 0.0))
            sure, told, frames = self._known[tag_id] = (
                FADE * sure + certain, FADE * told + certain @ off, FADE * frames + 1)
            covariance = np.linalg.inv(sure)
            means.append(covariance @ told)
            covariances.append(covariance * frames)
        return np.array(means), np.array(covariances)
