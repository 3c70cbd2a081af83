"""What was learned of a wall so far, to be remembered."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.geometry.homography import homography_from, transform
from aruco_ar.walls.remembered import Look, RememberedWall

from .features import Views
from .template import PAPER_SIDES
from .texture import MIN_POINTS
from .wall_search import MIN_FEATURES

RESERVE = 3  # a frame shows only some of the features of a wall


@dataclass(frozen=True, eq=False)
class LearnedWall:
    """``ids``, ``places``, ``look``: see RememberedWall. ``views``: the frames that show its features."""

    ids: tuple[int, ...]
    places: Mapping[int, Floats]
    look: Look | None
    views: Views

    def remembered(self, dictionary: str, border: float) -> RememberedWall:
        """The wall as it is remembered. This takes some tenths of a second. The arguments: see Detector."""
        return RememberedWall(dictionary, border, self.ids, self.places, self.look, self.views.features())


def shows_without_tags(wall: RememberedWall) -> bool:
    """Whether a wall shows enough besides its tags and their papers to be found while none of them is there."""
    is_on_paper = np.zeros(len(wall.features.places), bool)
    for place in wall.places.values():
        off = np.abs(transform(homography_from(place), np.asarray(wall.features.places, np.float64)) - 0.5)
        is_on_paper |= (off < PAPER_SIDES / 2).all(axis=1)
    return (wall.look is not None and np.count_nonzero(~wall.look.on_tags) >= MIN_POINTS
            and np.count_nonzero(~is_on_paper) >= RESERVE * MIN_FEATURES)
