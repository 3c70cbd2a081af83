"""How far tags are off the plane of the other tags, judged by the last frames together.

A tag on a box a few centimeters in front of the wall looks like a tag on the
wall. Only a near view or many frames show the difference. So the weighted mean
of the last frames is taken. It is assumed to be no more certain than a single frame: the
errors of corners repeat from frame to frame, and paper bulges in all of them.
"""
from __future__ import annotations

from typing import Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.base.recent import Recent
from aruco_ar.compiled import binding

NEW = np.zeros(binding.FLATNESS_SIZE)  # the memory of a tag that was never seen


class Flatness:
    """How far tags are off the plane of the others, by their ids. The computation is in flat_walls.c."""

    def __init__(self) -> None:
        self._memories: Recent[int, Floats] = Recent()

    def update(self, ids: Sequence[int], off: Floats, spread: Floats) -> Floats:
        """Add n tags of a frame. Returns (n,): how far each is off by now, in squared standard deviations.

        ``off``: (n, 3), as from off_others, and ``spread``: (n, 3, 3), their covariances in this frame.
        """
        memories = np.array([self._memories.get(tag_id, NEW) for tag_id in ids]).reshape(-1, len(NEW))
        squared = binding.add_off(off, spread, memories)
        for tag_id, memory in zip(ids, memories):
            self._memories[tag_id] = memory
        return squared
