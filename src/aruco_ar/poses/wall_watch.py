"""Checking that the tags in sight are where the wall's file says."""
from __future__ import annotations

from typing import Sequence

import numpy as np

from aruco_ar.walls.wall import Wall

from .estimator import CameraPose, TagPose

PATIENCE_S = 3.0     # a fault is reported only if it lasts for this time
NO_CAMERA_POSE = -1  # in place of a tag's id: the tags do not agree on the camera's pose
OFF_M, OFF_SHARE = 0.02, 0.02  # meters, and relative to the distance: a tag off by more is misplaced


class WallWatch:
    """Finds the tags that do not fit a Wall. ``name``: its file's name. Without a wall, all tags fit."""

    def __init__(self, wall: Wall | None, name: str) -> None:
        self._name = name
        self._places = {} if wall is None else {tag.id: np.array([tag.x, tag.y, 0.0]) for tag in wall.tags}
        self._since: dict[int, float] = {}  # the stamps since when tags have been misplaced

    def check(self, poses: Sequence[TagPose], camera: CameraPose | None, stamp: float) -> str | None:
        """A sentence that says what is wrong with the file, or None.

        ``poses``: a list of TagPose. ``camera``: the CameraPose, or None.
        ``stamp``: the frame's time, seconds.
        """
        known = [pose for pose in poses if pose.id in self._places]
        if not known:
            return None
        wrong = set()
        if camera is None:
            wrong.add(NO_CAMERA_POSE)
        else:
            for pose in known:
                place = camera.rotation @ pose.translation + camera.translation
                far = OFF_M + OFF_SHARE * np.linalg.norm(pose.translation)
                if np.linalg.norm(place - self._places[pose.id]) > far:
                    wrong.add(pose.id)
        self._since = {what: min(self._since.get(what, stamp), stamp) for what in wrong}
        lasting = [what for what in wrong if stamp - self._since[what] > PATIENCE_S]
        if NO_CAMERA_POSE in lasting:
            return 'The tags in sight do not fit the wall of "%s", so the camera\'s pose is unknown. Check ' \
                   'their places and sides in that file; all are in meters.' % self._name
        if lasting:
            ids = ', '.join(map(str, sorted(lasting)))
            return 'These tags are not where "%s" says: %s. Correct the file, or move the tags. ' \
                   "The camera's pose is computed from the other tags." % (self._name, ids)
        return None
