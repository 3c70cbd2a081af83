"""What stands off a wall moves against it as the camera moves: it is told from frames in different views."""
from __future__ import annotations

from math import hypot

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers

from .blank import BlankWall
from .difference import difference_from_window, largest_difference, mean_channel
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
LEVEL_BITS = 4        # a histogram has 2 to this power levels of each channel
BINS = 8**LEVEL_BITS  # and so many bins
FEW = 1e-4            # colors that are a smaller share of the pixels than this say nothing
BARE_TIMES = 1.6      # a color is the wall's if another one is that of a thing so many times as likely
# From this likelihood on, a color is that of a thing. On a pattern, some of the wall's own colors seem likely.
BLANK_LIKELY, PATTERN_LIKELY = 0.5, 0.6
THING_PX = 5          # narrower things are the rims of a pattern
NEAR_PX = 21          # width of the window in which a thing has about one color
# A thing is seen to have moved by at least so many pixels as near to it as half of TOUCH_PX, and as this share
# of its outline.
TOUCH_PX, MOVED_PX, MOVED_SHARE = 7, 12, 0.1


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
        # The views, of which there are n. Pixels are counted row by row: there are h * w of them.
        self._slopes: list[tuple[float, ...]] = []
        self._unlit: Image = np.zeros((0, usable.size, 3), np.uint8)  # in the light of the look
        self._bins: Integers = np.zeros((0, usable.size), np.uint16)  # see _bins
        self._counts: Integers = np.zeros((0, BINS), np.int64)        # of these bins, where they show the area
        self._seen: Booleans = np.zeros((0, usable.size), bool)       # where they show the area
        self._changed: Booleans = np.zeros((0, usable.size), bool)    # where they differ from the look
        self._likely: Floats = np.zeros(BINS, np.float32)  # see _likelihood
        self._bared = np.zeros(usable.shape, bool)              # where the wall was found behind a thing
        self._bared_from = np.zeros((*usable.shape, 3), np.float32)  # and the color of that thing
        self.standing: Booleans = np.zeros(usable.shape, bool)

    def is_new(self, slope: Floats) -> bool:
        """Whether a view with this slope, (2,), differs from all others, and is not too slanted."""
        x, y = slope.tolist()
        return hypot(x, y) < MAX_SLOPE and all(
            hypot(x - other[0], y - other[1]) >= NEW_SLOPE for other in self._slopes)

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
        self._slopes = [*self._slopes[1 - MOST:], tuple(slope.tolist())]
        colors = _bytes(unlit).reshape(-1, 3)
        bins = _bins(colors)
        self._unlit, self._bins, self._counts, self._seen, self._changed = (
            np.concatenate([views[1 - MOST:], view[None]]) for views, view in (
                (self._unlit, colors), (self._bins, bins), (self._counts, _counts(bins[usable.ravel()])),
                (self._seen, usable.ravel()), (self._changed, changed.ravel())))
        if len(self._slopes) < LEAST:
            return nowhere
        counts = self._counts.sum(axis=0)  # what is changed is counted off it, since that is little
        any_changed = self._changed.any(axis=0)
        moves = any_changed & (self._seen & ~self._changed).any(axis=0)
        bare = self._bare(look, _likelihood(_counts(self._bins[self._seen & moves]),
                                            counts - _counts(self._bins[self._seen & any_changed])))
        # Now it is known which color is the wall's at most places, so the colors of things are known better.
        inner = np.stack([shrunk(each.reshape(usable.shape), 3).ravel() for each in self._changed])
        other = self._seen & (self._changed | self.standing.ravel())
        self._likely = _likelihood(_counts(self._bins[inner]), counts - _counts(self._bins[other]))
        bare |= self._bare(look, self._likely)
        self._find_standing(look)
        return bare

    def look_changed(self, where: Booleans, part: tuple[slice, slice], look: Floats) -> None:
        """Take in that the look, (h, w, 3) float32, has changed at some pixels of a part."""
        at = np.arange(self.standing.size).reshape(self.standing.shape)[part][where]
        off = np.abs(self._unlit.take(at, axis=1) - look[part][where])
        self._changed[:, at] = _largest(off) > SAME_LEVELS
        self.standing[part][where] = False

    def like_things(self, unlit: Floats) -> Booleans:
        """(h, w): where a frame, (h, w, 3) float32, in the light of the look, has colors of things."""
        return np.asarray((self._likely > self._least_likely)[_bins(_bytes(unlit))])

    def in_front(self, unlit: Floats, look: Floats, valid: Booleans) -> Booleans:
        """(h, w): where things that stand there are in front of the wall in a frame: see add."""
        other = valid & self._usable & (largest_difference(unlit, look) > SAME_LEVELS)
        other[other] = self.like_things(unlit[other])
        labels, count = components(other | self.standing)
        is_thing = np.bincount(labels[self.standing], minlength=count + 1) > 0
        is_thing[0] = False
        return is_thing[labels] & valid

    @property
    def _least_likely(self) -> float:
        return PATTERN_LIKELY if self._wall is None else BLANK_LIKELY

    def _bare(self, look: Floats, likely: Floats) -> Booleans:
        """Make the look that of the wall where things were taken for it. Returns where, (h, w).

        ``likely``: see _likelihood. At least two views must show the wall's color.
        """
        any_changed = self._changed.any(axis=0).reshape(self._usable.shape)
        at = np.flatnonzero(grown(any_changed, BLANK_PX) & self._usable)
        bare = np.zeros(look.shape[:2], bool)
        if not len(at):
            return bare
        changed, seen, bins = (views.take(at, axis=1) for views in (self._changed, self._seen, self._bins))
        colors = self._unlit.take(at, axis=1).astype(np.float32)
        odds, pixels = likely[bins], np.arange(len(at))
        known = look.reshape(-1, 3)[at]
        most = likely[_bins(_bytes(known))] / BARE_TIMES
        of_others = np.where(changed, odds, np.inf)
        color = colors[of_others.argmin(axis=0), pixels]
        same = changed & (_largest(np.abs(colors - color)) < SAME_LEVELS)
        bare.ravel()[at] = (same.sum(axis=0) >= 2) & (of_others.min(axis=0) < most)
        bare = opened(bare)
        if not bare.any():
            return bare
        # Right beside that, a smaller displacement than else is enough.
        off = _largest(np.abs(colors - known))
        of_others = np.where((off > SAME_LEVELS) & seen, odds, np.inf)
        beside = (grown(bare, BLANK_PX) & ~bare).ravel()[at] & (of_others.min(axis=0) < most)
        color[beside] = colors[of_others.argmin(axis=0), pixels][beside]
        bare.ravel()[at] |= beside
        behind = look.copy()
        behind.reshape(-1, 3)[at] = color
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
        if not like.any():
            self.standing = like
            return
        colors = mean_color(look, like, NEAR_PX)
        moved = self._bared & (largest_difference(self._bared_from, colors) < SAME_LEVELS)
        views, at = np.divmod(np.flatnonzero(self._changed & ~like.ravel()), like.size)
        off = _largest(np.abs(self._unlit[views, at] - colors.reshape(-1, 3)[at]))
        are_things = (off < SAME_LEVELS) & (self._likely[self._bins[views, at]] > self._least_likely)
        moved.ravel()[at[are_things]] = True
        labels, count = components(grown(like, 3))
        moved_px = np.bincount(grown_labels(labels, TOUCH_PX)[moved], minlength=count + 1)
        outline_px = np.bincount(labels[outline_of(labels > 0)], minlength=count + 1)
        self.standing = like & ((moved_px >= MOVED_PX) & (moved_px > MOVED_SHARE * outline_px))[labels]


def without(look: Floats, things: Booleans) -> Floats:
    """(h, w, 3) float32: a look with the mean color of the wall around where things, (h, w), stand."""
    if not things.any():
        return look
    hidden = grown(things, THING_PX)
    around = mean_color(look, ~hidden, 2 * NEAR_PX)
    return np.asarray(cv2.copyTo(around, hidden.view(np.uint8), look.copy()), np.float32)


def _differs(image: Floats, look: Floats, px: int) -> Booleans:
    """(h, w): where a frame has a color that the look has nowhere in a window of that width. Both (h, w, 3)."""
    return np.asarray(difference_from_window(image, look, px) > OTHER_LEVELS + OTHER_SHARE * mean_channel(look))


def _largest(values: Floats) -> Floats:
    """(...,): the largest of three values, (..., 3). NumPy's own maximum takes many times as long."""
    return np.maximum(np.maximum(values[..., 0], values[..., 1]), values[..., 2])


def _bytes(colors: Floats) -> Image:
    """The same colors, (..., 3), as uint8, rounded down."""
    return np.minimum(colors, 255).astype(np.uint8)


def _bins(colors: Image) -> Integers:
    """(...,) uint16: the bins of colors, (..., 3) uint8, in a histogram."""
    levels = np.right_shift(colors, 8 - LEVEL_BITS).astype(np.uint16)
    return levels[..., 0] << 2 * LEVEL_BITS | levels[..., 1] << LEVEL_BITS | levels[..., 2]


def _counts(bins: Integers) -> Integers:
    """(BINS,) int64: the number of pixels, (n,), in each of these bins."""
    return np.bincount(bins, minlength=BINS)


def _likelihood(of_things: Integers, of_wall: Integers) -> Floats:
    """(BINS,) float32: how likely the colors of each bin are those of things, 0 to 1.

    This is Bayes' theorem, where things and wall are as likely at first. ``of_things``, ``of_wall``: the
    numbers of their pixels, see _counts.
    """
    things, wall = _shares(of_things), _shares(of_wall)
    return np.asarray(things / (things + wall + FEW), np.float32)


def _shares(counts: Integers) -> Floats:
    """(BINS,) float64: which share of the pixels has the color of each bin, or nearly so."""
    levels = 2**LEVEL_BITS
    spread = (2 * np.eye(levels) + np.eye(levels, k=1) + np.eye(levels, k=-1)) / 4
    spread[0, 0] = spread[-1, -1] = 0.75  # beyond the last level, there is none
    wide = spread @ counts.reshape((levels,) * 3) @ spread
    return np.asarray(spread @ wide.reshape(levels, -1) / max(counts.sum(), 1), np.float64).ravel()
