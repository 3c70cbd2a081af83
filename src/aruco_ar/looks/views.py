"""What stands off a wall moves against it as the camera moves: it is told from frames in different views."""
from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers

from .blank import BlankWall
from .difference import difference_from_window, largest_difference
from .parts import WHOLE, components, grown, grown_labels, mean_color, opened, outline_of, shrunk

# The slope of a view is how far beside the middle of the area the camera is, divided by its distance from the
# wall. What is h high moves against the wall by h times the change of the slope. With a larger slope than
# MAX_SLOPE, a view is blurred.
NEW_SLOPE, MAX_SLOPE = 0.08, 1.7
MOST, LEAST = 12, 3   # number of views that are kept, and that are needed
MOST_CHANGED = 0.25   # a frame that differs from the look on more of the wall shows another light, or a person
# A place shows another color than the wall if no pixel in a window around it has it. A lens without a
# calibration displaces a pattern by some pixels.
BLANK_PX, PATTERN_PX = 5, 9
# Least difference between the colors of the wall and of a thing: gray levels, and a share of the brightness.
OTHER_LEVELS, OTHER_SHARE = 14.0, 0.08
SAME_LEVELS = 24.0    # the shades of a thing differ by less than this, in gray levels
LEVELS = 16           # number of levels of each channel in a histogram
FEW = 1e-4            # colors that are a smaller share of the pixels than this say nothing
BARE_TIMES = 1.6      # a color is the wall's if another one is that of a thing so many times as likely
# From this likelihood on, a color is that of a thing. On a pattern, some of the wall's own colors seem likely.
BLANK_LIKELY, PATTERN_LIKELY = 0.5, 0.6
THING_PX = 5          # narrower things are the rims of a pattern
NEAR_PX = 21          # width of the window in which a thing has about one color
# A thing is seen to have moved by at least so many pixels as near to it as half of TOUCH_PX, and as this share
# of its outline.
TOUCH_PX, MOVED_PX, MOVED_SHARE = 7, 12, 0.1


class _View(NamedTuple):
    """A frame in one view.

    ``unlit``: (h, w, 3) uint8, in the light of the look. ``bins``: (h, w) int32, see _bins. ``usable``: (h, w),
    where the frame shows the area. ``changed``: (h, w), where it differs from the look; it is kept up to date.
    """

    slope: tuple[float, ...]
    unlit: Image
    bins: Integers
    usable: Booleans
    changed: Booleans


class Views:
    """Frames of a wall from clearly different sides, and what they tell about things that stand on it.

    The wall has the same color from all sides. Where a place has not, one of its colors is that of a thing. It
    is the one that is rare on the rest of the wall. So the other one is the wall behind the thing. Where the
    thing stands, it hides the wall in all views. There its color tells it, and that it moves at its rim.

    ``standing``: (h, w), where the look is not that of the wall, but of things that stand there.
    """

    def __init__(self, usable: Booleans, wall: BlankWall | None) -> None:
        """``usable``: (h, w), where things can be. ``wall``: None if it is not blank."""
        self._usable, self._wall = usable, wall
        self._views: list[_View] = []
        self._likely: Floats = np.zeros(LEVELS**3, np.float32)  # see _likelihood
        self._bared = np.zeros(usable.shape, bool)              # where the wall was found behind a thing
        self._bared_from = np.zeros((*usable.shape, 3), np.float32)  # and the color of that thing
        self.standing: Booleans = np.zeros(usable.shape, bool)

    def is_new(self, slope: Floats) -> bool:
        """Whether a view with this slope, (2,), differs from all others, and is not too slanted."""
        x, y = slope.tolist()
        return hypot(x, y) < MAX_SLOPE and all(
            hypot(x - view.slope[0], y - view.slope[1]) >= NEW_SLOPE for view in self._views)

    def add(self, slope: Floats, unlit: Floats, look: Floats, valid: Booleans) -> Booleans:
        """Take in a frame in a new view. Returns where the look is now that of the wall behind a thing, (h, w).

        ``unlit``: (h, w, 3) float32, the frame in the light of the look. ``look``: (h, w, 3) float32; changed.
        ``valid``: (h, w), where the frame shows the area.
        """
        usable = valid & self._usable
        changed = usable & opened(_differs(unlit, look, PATTERN_PX if self._wall is None else BLANK_PX))
        nowhere = np.zeros(usable.shape, bool)
        if np.count_nonzero(changed) > MOST_CHANGED * np.count_nonzero(usable):
            return nowhere
        self._views = [*self._views[1 - MOST:], _View(
            tuple(slope.tolist()), np.clip(unlit, 0, 255).astype(np.uint8), _bins(unlit), usable, changed)]
        if len(self._views) < LEAST:
            return nowhere
        bins: Integers = np.stack([view.bins for view in self._views])
        seen: Booleans = np.stack([view.usable for view in self._views])
        changed = self._changed()
        moves = changed.any(axis=0) & (seen & ~changed).any(axis=0)
        bare = self._bare(look, _likelihood(bins, seen & moves, seen & ~changed.any(axis=0)))
        # Now it is known which color is the wall's at most places, so the colors of things are known better.
        changed = self._changed()
        inner = np.stack([shrunk(each, 3) for each in changed])
        self._likely = _likelihood(bins, inner, seen & ~changed & ~self.standing)
        bare |= self._bare(look, self._likely)
        self._find_standing(look)
        return bare

    def look_changed(self, where: Booleans, part: tuple[slice, slice], look: Floats) -> None:
        """Take in that the look, (h, w, 3) float32, has changed at some pixels of a part."""
        for view in self._views:
            off = np.abs(view.unlit[part][where] - look[part][where]).max(axis=1)
            view.changed[part][where] = off > SAME_LEVELS
        self.standing[part][where] = False

    def like_things(self, unlit: Floats) -> Booleans:
        """(h, w): where a frame, (h, w, 3) float32, in the light of the look, has colors of things."""
        return np.asarray(self._likely[_bins(unlit)] > self._least_likely)

    def in_front(self, unlit: Floats, look: Floats, valid: Booleans) -> Booleans:
        """(h, w): where things that stand there are in front of the wall in a frame: see add."""
        other = valid & self._usable & (largest_difference(unlit, look) > SAME_LEVELS)
        labels, count = components((other & self.like_things(unlit)) | self.standing)
        is_thing = np.bincount(labels[self.standing], minlength=count + 1) > 0
        is_thing[0] = False
        return is_thing[labels] & valid

    @property
    def _least_likely(self) -> float:
        return PATTERN_LIKELY if self._wall is None else BLANK_LIKELY

    def _changed(self) -> Booleans:
        """(n, h, w): where each view differs from the look."""
        return np.stack([view.changed for view in self._views])

    def _bare(self, look: Floats, likely: Floats) -> Booleans:
        """Make the look that of the wall where things were taken for it. Returns where, (h, w).

        ``likely``: see _likelihood. At least two views must show the wall's color.
        """
        changed = self._changed()
        where = np.nonzero(grown(changed.any(axis=0), BLANK_PX) & self._usable)
        changed = changed[:, where[0], where[1]]
        seen = np.stack([view.usable[where] for view in self._views])
        colors = np.stack([view.unlit[where] for view in self._views]).astype(np.float32)
        odds = likely[np.stack([view.bins[where] for view in self._views])]
        known, pixels = look[where], np.arange(len(where[0]))
        most = likely[_bins(known)] / BARE_TIMES
        of_others = np.where(changed, odds, np.inf)
        color = colors[of_others.argmin(axis=0), pixels]
        same = changed & (np.abs(colors - color).max(axis=2) < SAME_LEVELS)
        bare = np.zeros(look.shape[:2], bool)
        bare[where] = (same.sum(axis=0) >= 2) & (of_others.min(axis=0) < most)
        bare = opened(bare)
        if not bare.any():
            return bare
        # Right beside that, a smaller displacement than else is enough.
        off = np.abs(colors - known).max(axis=2)
        of_others = np.where((off > SAME_LEVELS) & seen, odds, np.inf)
        beside = (grown(bare, BLANK_PX) & ~bare)[where] & (of_others.min(axis=0) < most)
        color[beside] = colors[of_others.argmin(axis=0), pixels][beside]
        bare[where] |= beside
        behind = look.copy()
        behind[where] = color
        if self._wall is not None:  # its color is known
            bare &= self._wall.shows(behind, WHOLE) & ~self._wall.shows(look, WHOLE)
        self._bared_from[bare], look[bare] = look[bare], behind[bare]
        self._bared |= bare
        self.look_changed(bare, WHOLE, look)
        return bare

    def _find_standing(self, look: Floats) -> None:
        """Find out where the look is that of things: it has their colors, and they move at its rim."""
        like = self.like_things(look) & self._usable
        like &= grown(shrunk(like, THING_PX), THING_PX)
        colors = mean_color(look, like, NEAR_PX)
        moved = self._bared & (largest_difference(self._bared_from, colors) < SAME_LEVELS)
        for view in self._views:
            off = largest_difference(np.asarray(view.unlit, np.float32), colors)
            moved |= view.changed & ~like & (off < SAME_LEVELS) & (self._likely[view.bins] > self._least_likely)
        labels, count = components(grown(like, 3))
        moved_px = np.bincount(grown_labels(labels, TOUCH_PX)[moved], minlength=count + 1)
        outline_px = np.bincount(labels[outline_of(labels > 0)], minlength=count + 1)
        self.standing = like & ((moved_px >= MOVED_PX) & (moved_px > MOVED_SHARE * outline_px))[labels]


def without(look: Floats, things: Booleans) -> Floats:
    """(h, w, 3) float32: a look with the mean color of the wall around where things, (h, w), stand."""
    if not things.any():
        return look
    hidden = grown(things, THING_PX)
    return np.where(hidden[..., None], mean_color(look, ~hidden, 2 * NEAR_PX), look)


def _differs(image: Floats, look: Floats, px: int) -> Booleans:
    """(h, w): where a frame has a color that the look has nowhere in a window of that width. Both (h, w, 3)."""
    return np.asarray(difference_from_window(image, look, px) > OTHER_LEVELS + OTHER_SHARE * look.mean(axis=2))


def _bins(colors: Image | Floats) -> Integers:
    """(...,) int32: the bins of colors, (..., 3), in a histogram."""
    coarse = np.clip(colors, 0, 255).astype(np.uint8).astype(np.int32) // (256 // LEVELS)
    return np.asarray((coarse[..., 0] * LEVELS + coarse[..., 1]) * LEVELS + coarse[..., 2])


def _likelihood(bins: Integers, of_things: Booleans, of_wall: Booleans) -> Floats:
    """(LEVELS**3,) float32: how likely the colors of each bin are those of things, 0 to 1.

    This is Bayes' theorem, where things and wall are as likely at first. ``bins``, ``of_things``, ``of_wall``:
    (n, h, w), and where in these views things and wall are seen.
    """
    things, wall = (_shares(bins[where]) for where in (of_things, of_wall))
    return np.asarray(things / (things + wall + FEW), np.float32)


def _shares(bins: Integers) -> Floats:
    """(LEVELS**3,) float64: which share of the pixels has the color of each bin, or nearly so."""
    shares = np.bincount(bins, minlength=LEVELS**3).reshape((LEVELS,) * 3) / max(len(bins), 1)
    for axis in range(3):
        shares = np.moveaxis(shares, axis, 0)
        wide = np.concatenate([shares[:1], shares, shares[-1:]])
        shares = np.moveaxis((wide[:-2] + 2 * wide[1:-1] + wide[2:]) / 4, 0, axis)
    return np.asarray(shares.ravel(), np.float64)
