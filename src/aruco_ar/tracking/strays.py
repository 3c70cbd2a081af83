"""Tags that are not where they were: somebody has moved them, or it only seems so for a moment."""
from __future__ import annotations

from typing import Iterable, Mapping

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

FAR = 0.5      # a tag that is farther off than this, in its sides, was moved
STAYS_S = 0.4  # if a tag is off for this long, it does not only seem so


class Strays:
    """Tells which tags have left their places, while the wall's look shows where these are.

    Others only seem to be elsewhere: the sheet is bent there, or something covers a part of the tag.
    """

    def __init__(self) -> None:
        self._since: dict[int, float] = {}

    def note(self, ids: Iterable[int], now: float) -> bool:
        """Note the ids of tags that are off in a frame. Returns whether one stays so. ``now``: seconds."""
        self._since = {tag_id: self._since.get(tag_id, now) for tag_id in ids}
        return any(now - since >= STAYS_S for since in self._since.values())

    @staticmethod
    def moved(seen: Mapping[int, Tag], places: Mapping[int, Floats]) -> set[int]:
        """The ids of tags that are far off.

        ``seen``: {id: Tag}. ``places``: {id: (4, 2) pixels}, where some of these should be.
        """
        off = {tag_id: np.linalg.norm(np.mean(place - seen[tag_id].corners, axis=0))
               for tag_id, place in places.items()}
        return {tag_id for tag_id, place in places.items() if off[tag_id] > FAR * side_of(place[None])[0]}
