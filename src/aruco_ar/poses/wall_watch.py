"""Whether the tags in sight are where the wall's file says."""
from __future__ import annotations

from typing import Sequence

import numpy as np

from aruco_ar.walls.wall import Wall

from .estimator import CameraPose, TagPose

PATIENCE_S = 3.0     # a wrong file is wrong for longer
NOWHERE = -1         # in place of the id of what is wrong: the tags do not agree where the camera is
OFF_M, OFF_PART = 0.02, 0.02  # meters, and of the distance: a tag farther from its place is elsewhere


class WallWatch:
    """Finds what does not fit a wall.Wall, which the file of that name describes; None fits everything."""

    def __init__(self, wall: Wall | None, name: str) -> None:
        self._name = name
        self._places = {} if wall is None else {tag.id: np.array([tag.x, tag.y, 0.0]) for tag in wall.tags}
        self._since: dict[int, float] = {}  # what has been wrong since when

    def look(self, poses: Sequence[TagPose], camera: CameraPose | None, stamp: float) -> str | None:
        """What is wrong with the file, a sentence, or None.

        ``poses``: a list of TagPose. ``camera``: the CameraPose, or None.
        ``stamp``: the frame's time, seconds.
        """
        known = [pose for pose in poses if pose.id in self._places]
        if not known:
            return None
        wrong = set()
        if camera is None:
            wrong.add(NOWHERE)
        else:
            for pose in known:
                place = camera.rotation @ pose.translation + camera.translation
                far = OFF_M + OFF_PART * np.linalg.norm(pose.translation)
                if np.linalg.norm(place - self._places[pose.id]) > far:
                    wrong.add(pose.id)
        self._since = {what: min(self._since.get(what, stamp), stamp) for what in wrong}
        lasting = [what for what in wrong if stamp - self._since[what] > PATIENCE_S]
        if NOWHERE in lasting:
            return 'The tags in sight do not fit the wall of "%s", so the camera\'s pose is not known. Are ' \
                   'their places and sides there right, in meters?' % self._name
        if lasting:
            return 'Tag %s is not where "%s" says; the others tell where the camera is.' % (
                ', '.join(map(str, sorted(lasting))), self._name)
        return None
