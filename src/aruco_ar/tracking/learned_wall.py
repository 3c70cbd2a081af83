"""What was learned of a wall so far, to be remembered."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.walls.remembered import Look, RememberedWall

from .features import Views
from .texture import MIN_POINTS


@dataclass(frozen=True, eq=False)
class LearnedWall:
    """``ids``, ``places``, ``look``: see RememberedWall. ``views``: the frames that show its features."""

    ids: tuple[int, ...]
    places: Mapping[int, Floats]
    look: Look | None
    views: Views

    @property
    def shows_without_tags(self) -> bool:
        """Whether it can be found while none of its tags is there."""
        return self.look is not None and np.count_nonzero(~self.look.on_tags) >= MIN_POINTS

    def remembered(self, dictionary: str, border: float) -> RememberedWall:
        """The wall as it is remembered. This takes some tenths of a second. The arguments: see Detector."""
        return RememberedWall(dictionary, border, self.ids, self.places, self.look, self.views.features())
