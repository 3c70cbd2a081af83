"""What is not blank on a blank wall: patches that are flat, or things that stand there."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers

from .blank import BlankWall
from .difference import largest_difference
from .parts import WHOLE, around, grown, grown_labels, mean_color, parts_of, shrunk

EVERY = 3    # patches are looked at in every third frame
TIMES = 3    # something may pass in front of a patch, but does not stay for so many looks
MOVED_PX = 5  # the wall may seem displaced by some pixels, see difference, so a thing moves by this at least
# In a window of this width around a patch, a pixel may be it, seen from another side, if its color is off
# the patch's by less than this, in gray levels.
NEAR_PX, NEAR_LEVELS = 21, 24.0
RIM_PX = 7           # pixels this near to a patch may be mixtures with it, or its shadow


class Patches:
    """The patches of a blank wall.

    What is flat stays where it is. A thing that is off the wall moves against it as the camera moves. So if the
    wall is seen where a part of a patch was, or the patch where the wall was, it is a thing.
    """

    def __init__(self, wall: BlankWall, look: Floats, usable: Booleans) -> None:
        """Take for patches what is not blank in a look, (h, w, 3) float32, where it is ``usable``, (h, w)."""
        self._wall, self._usable, self._frames = wall, usable, 0
        self._labels, count = parts_of(usable & ~wall.shows(look, WHOLE))
        self._times = np.zeros(count + 1, np.int32)  # for how many looks on end they seemed to be things
        self._colors = mean_color(look, self._labels > 0, NEAR_PX)

    def any(self) -> bool:
        """Whether there are any."""
        return bool(self._labels.any())

    def things(self, seen: Image, valid: Booleans, light: Floats, in_front: Integers) -> Booleans | None:
        """(h, w): the patches that a frame shows to be things, with their rims; None if it shows none.

        ``seen``: (h, w, 3) uint8, the frame. ``valid``: (h, w), where it shows the area. ``light``: (3,)
        float32, its light, as factors of the wall's. ``in_front``: (h, w), the labels of what is in front of
        the wall and the patches, see parts_of. What of it reaches over the rim of the area is something else.
        Things are no patches any more.
        """
        self._frames += 1
        is_patch = self._labels > 0
        if self._frames % EVERY or not is_patch.any():
            return None
        part = around(is_patch, NEAR_PX)
        near = grown_labels(self._labels[part], NEAR_PX)
        rim = np.concatenate([in_front[0], in_front[-1], in_front[:, 0], in_front[:, -1]])
        is_other = np.bincount(rim, minlength=in_front.max() + 1) > 0
        is_other[0] = False
        moved = self._moved(np.asarray(seen[part] / light, np.float32), part)
        moved &= shrunk(valid, RIM_PX)[part] & ~is_other[in_front[part]]
        labels = near[shrunk(moved, MOVED_PX)]
        self._times = np.where(np.bincount(labels, minlength=len(self._times)) > 0, self._times + 1, 0)
        self._times[0] = 0
        things = (self._times >= TIMES)[self._labels]
        if not things.any():
            return None
        self._labels[things] = 0
        return grown(things, RIM_PX) & (self._labels == 0)

    def _moved(self, unlit: Floats, part: tuple[slice, slice]) -> Booleans:
        """(h, w): where a part of a frame shows the wall in place of a patch, or a patch in place of it."""
        is_patch, shows = self._labels[part] > 0, self._wall.shows(unlit, part)
        like = largest_difference(unlit, self._colors[part]) < NEAR_LEVELS
        return np.where(is_patch, shows, ~shows & like & self._usable[part])
