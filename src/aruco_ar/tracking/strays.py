"""Tags that are not where they were: somebody has moved them, or it only seems so for a moment."""
from __future__ import annotations

from typing import Mapping

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

# A tag that is farther off than FAR, in its sides, was moved. One that is farther off than NEAR was moved if it
# stays there for STAYS_S. If all tags do, they were moved, too, however little.
FAR, NEAR, STAYS_S = 0.5, 0.2, 0.5


class Strays:
    """Tells which tags have left their places."""

    def __init__(self) -> None:
        self._since: dict[int, float] = {}  # since when tags have not been in their places

    def find(self, seen: Mapping[int, Tag], places: Mapping[int, Floats], now: float) -> set[int]:
        """The ids of the tags that were moved, while the wall's look shows where they should be.

        Other tags only seem to be elsewhere: the sheet is bent there, or something covers a part of the tag.
        ``seen``: {id: Tag}, the known tags in sight. ``places``: {id: (4, 2) pixels}, where those of them
        should be that are not there. ``now``: seconds.
        """
        self._since = {tag_id: self._since.get(tag_id, now) for tag_id in places}
        moved = set()
        for tag_id, place in places.items():
            sides = np.linalg.norm(np.mean(place - seen[tag_id].corners, axis=0)) / side_of(place[None])[0]
            stays = now - self._since[tag_id] >= STAYS_S
            if sides > FAR or (stays and (sides > NEAR or len(places) == len(seen))):
                moved.add(tag_id)
        return moved
