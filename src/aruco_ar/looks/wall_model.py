"""What the wall itself looks like, learned from frames in which other things stand in front of it.

All images here show the area rectified, straight from the front. There the
wall stands still, though the camera moves.
"""
from __future__ import annotations

from typing import Callable, NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers
from aruco_ar.compiled import binding

from .blank import BlankWall, blank_wall
from .difference import (
    Difference,
    compare,
    contrast_of,
    difference,
    difference_from_window,
    largest_difference,
    soft_rim,
)
from .outlines import came_or_left
from .parts import WHOLE, around, grown, parts_of, still_parts
from .patches import Patches
from .views import Views, without

MEAN_OF = 30                    # the wall's look is the running mean of about this many frames
KNOWN_S = 0.25                  # a color seen for less time than this is not trusted
GUESS_S = 3.0                   # a blank wall counts at first as seen for this time, even if hidden
SURE_S = 2.0                    # a color seen for less time than this gives way to any color that stays
LASTING_S = 5.0                 # what comes where the wall was seen for this time is never taken for the wall
PLAIN_SHARE = 0.1               # a blank wall's colors are off by less than this, as a share of its brightness
SAME_LEVELS = 16.0              # colors are the same if they differ by less than this, in gray levels
# A thing is still if at most MOVED_SHARE of its outline has moved for STILL_S seconds.
STILL_S = 1.0
MOVED_SHARE = 0.03
VARIANCE = 4.0                  # assumed variance of the noise until it is known
VARIANCE_RATE = 0.03            # weight of a new frame in the running mean of the variance
# Noise is much the same on the whole wall: its variance at a pixel is at most this multiple of the median.
# Otherwise a thing that is overlooked once would teach that it is noise, and be overlooked ever after.
NOISIEST = 4.0
# The wall or the light is another one if more than ANOTHER_SHARE of the wall differs from the look, and less
# than BEFORE_SHARE did so in the frame before. It is also another one if the light changes its color at once,
# one channel by ANOTHER_COLOR times as much as another, though in the frame before hardly anything differed:
# otherwise the color may be that of a person.
ANOTHER_SHARE, BEFORE_SHARE = 0.85, 0.5
ANOTHER_COLOR, HARDLY = 1.5, 0.01
# A glance is enough if the light changes by less than this factor. After one that shows something, so many
# frames are taken in: noise may be the reason.
SAME_LIGHT, PAUSE = 1.1, 10
KEPT_FOR = 8                    # the look changes slowly: what is computed from it is kept for so many frames
SAMPLE_PX = 8                   # every eighth pixel is a sample of the noise on the whole wall
SHADE_S = 5.0                   # the light outside of shadows is remembered: one may fall on most of the wall
DIM = 0.2                       # in less light than this, the color of the light is uncertain
NEAR_PART_PX = 12               # more than what is learned near things in front, on each side
NEAR_PX = 5                     # pixels in a window of this width around things in front may be mixtures


class _Kept(NamedTuple):
    """What is computed from the look, and kept for some frames.

    ``contrast``: (h, w, 3) uint8, see contrast_of. ``half``: (h / 2, w / 2, 3) float32, the look, smooth, with
    half of the pixels across and down. ``half_contrast``: (h / 2, w / 2, 3) uint8, that of ``half``.
    ``half_variance``: (h / 2, w / 2) float32.
    """

    contrast: Image
    half: Floats
    half_contrast: Image
    half_variance: Floats


class _Earlier(NamedTuple):
    """An earlier frame. ``front``: (h, w), where things were in front. ``unlit``: see _unlit."""

    front: Booleans
    unlit: Floats


class WallModel:
    """The wall's look: at each pixel, the color that was seen there for the longest time.

    ``look``: (h, w, 3) float32, BGR, in the light in which the wall was first seen; empty before that.
    ``light``: (3,) float32, the light on the whole wall in the last frame, as factors of ``look``.
    ``front``: (h, w) float32, 0 to 1: how much things in front of the wall cover. ``free``: (h, w), where the
    last frame certainly shows the wall. ``plain``: (h, w), where the wall has its one color; None if it is not
    blank. ``begun``: how often a wall was learned anew.
    """

    def __init__(self) -> None:
        self.begun = 0
        self.reset()

    def reset(self) -> None:
        """Forget the wall."""
        self.look: Floats = np.zeros((0, 0, 3), np.float32)
        self.front: Floats = np.zeros((0, 0), np.float32)
        self.light = np.ones(3, np.float32)
        self.free: Booleans = np.zeros((0, 0), bool)
        self.plain: Booleans | None = None
        self._blank: BlankWall | None = None
        self._front_share = 1.0
        self._glance_pause = PAUSE  # so many frames must be taken in before the next glance
        self._age = 0.0
        self._earlier: list[_Earlier] = []

    def update(self, image: Image, valid: Booleans, tags: Callable[[], Booleans], passed: float,
               settle: float, slope: Floats | None = None) -> None:
        """Take in a frame.

        ``image``: (h, w, 3) BGR uint8. ``valid``: (h, w), where the frame shows the area. ``tags``: a function
        that says where the tags are, (h, w); it is called when a wall is seen first. ``passed``: seconds since
        the frame before. ``settle``: seconds after which a thing that does not move becomes a part of the wall.
        ``slope``: (2,), the view, see Area.slope; None if it is unknown.
        """
        seen = cv2.blur(image, (3, 3))
        if not self.look.size:
            self._begin(seen, valid, tags)
        before = self.light
        found = self._compare(seen, valid, passed)
        share = self._share_in_front(found.front, valid)
        if self._is_another(share, before):
            self._begin(seen, valid, tags)
            found = self._compare(seen, valid, passed)
        self._front_share = share
        self._glance_pause -= 1
        if slope is not None and self._views.is_new(slope):
            self._look_from(slope, seen, found, valid)
        in_front = found.front
        if self._views.standing.any():
            in_front = in_front | self._views.in_front(self._unlit(seen), self.look, valid)
        labels, count = parts_of(in_front) if in_front.any() else (np.zeros(valid.shape, np.int32), 0)
        front = labels > 0
        part = around(front, NEAR_PART_PX) if count else (slice(0), slice(0))
        self.free = valid & self._known & ~(grown(front, NEAR_PX) if count else front)
        # The wall, before it is learned further.
        lit = _times(without(self.look[part], self._views.standing[part]), self.light) if count else self.look
        self._learn_wall(seen, found, valid & ~front, passed, settle)
        self.front = np.zeros(valid.shape, np.float32)
        if count:
            self._learn_front(seen, labels, count, passed, settle, part)
            self.front[part] = soft_rim(np.asarray(image[part], np.float32), lit,
                                        front[part] & (self._seen_s[part] >= KNOWN_S))
        if self._blank is not None:
            self._clear_patches(seen, valid, labels, self._blank)
        self._before = front
        self._age += passed
        if self._age >= STILL_S:
            self._earlier, self._age = [self._earlier[1], _Earlier(front, self._unlit(seen))], 0.0

    def can_glance(self, slope: Floats) -> bool:
        """Whether a glance at a frame may be enough: the wall is known well, and nothing was in front of it.

        ``slope``: see update. In a new view, and as long as there are patches, more is learned.
        """
        if not self.look.size or self._count < MEAN_OF or self.front.any() or self._views.standing.any():
            return False
        has_patches = self._blank is not None and self._patches.any()
        return not has_patches and self._glance_pause <= 0 and not self._views.is_new(slope)

    def glance(self, image: Image, valid: Booleans) -> bool:
        """Whether a frame shows nothing but the wall, in about the same light. Only the light is learned then.

        ``image``, ``valid``: see update, but of half the width and height. With that, a thing is found as well,
        but not its rim. If the result is False, the frame should be taken in by update.
        """
        kept, seen, usable = self._kept_of_look(), cv2.blur(image, (3, 3)), valid & self._known[::2, ::2]
        light, _ = binding.measure_light(seen, kept.half, usable, self._before[::2, ::2], self.light)
        change = light / self.light
        if change.max() < SAME_LIGHT and change.min() > 1 / SAME_LIGHT:
            front, _ = compare(seen, kept.half, light, kept.half_contrast, kept.half_variance, usable)
            if not front.any():
                self.light = light
                return True
        self._glance_pause = PAUSE
        return False

    def _begin(self, seen: Image, valid: Booleans, tags: Callable[[], Booleans]) -> None:
        self.reset()
        self.begun += 1
        self.look = np.asarray(seen, np.float32)
        shape = seen.shape[:2]
        self._known = valid.copy()                  # where the look is known
        self._seen_s = np.zeros(shape, np.float32)  # for how long it was seen
        self._other = self.look.copy()              # another look, which was seen for a shorter time
        self._other_s = np.zeros(shape, np.float32)
        self._was_wall = np.zeros(shape, bool)      # whether that other look was once the wall's
        self._variance = np.full(shape, VARIANCE, np.float32)
        self._before = np.zeros(shape, bool)        # where something was in front in the frame before
        self._earlier = [_Earlier(self._before, self.look.copy())] * 2
        self._age = 0.0                             # seconds since the later of those two
        self._count = 0
        self._kept: _Kept | None = None             # None if the look has changed at once
        self._kept_age = 0                          # for how many frames that was used
        self._unshaded = 1.0                        # the light outside of shadows, as a factor of the look
        self._papers = ~valid | tags()              # where no patch can be
        self._blank = found = blank_wall(self.look, ~self._papers)
        self._views: Views = Views(~self._papers, found)
        if found is not None:
            self.look[found.hidden] = found.surface[found.hidden]
            self._seen_s[found.hidden | found.shown] = GUESS_S
            self._patches = Patches(found, self.look, ~self._papers)
        if found is not None and found.is_flat:
            self.plain = _is_near(self.look, found.surface)
            self._seen_s[self.plain] = GUESS_S

    def _compare(self, seen: Image, valid: Booleans, passed: float) -> Difference:
        """The Difference from the wall in the light of this frame."""
        usable = self._known & valid
        self.light, now = binding.measure_light(seen, self.look, usable, self._before, self.light)
        if now >= 0:
            self._unshaded = max(now, self._unshaded * float(np.exp(-passed / SHADE_S)))
        unshaded = max(1.0, self._unshaded / float(self.light.mean()))
        contrast = self._kept_of_look().contrast
        return difference(seen, self.look, self.light, contrast, self._variance, usable, unshaded)

    def _kept_of_look(self) -> _Kept:
        self._kept_age += 1
        if self._kept is None or self._kept_age > KEPT_FOR:
            half = np.asarray(cv2.blur(_halved(self.look), (3, 3)), np.float32)
            self._kept, self._kept_age = _Kept(contrast_of(self.look), half, contrast_of(half),
                                               _halved(self._variance)), 0
        return self._kept

    def _share_in_front(self, front: Booleans, valid: Booleans) -> float:
        """The share of the known wall in a frame that something seems to stand in front of."""
        if not front.any():
            return 0.0
        known = self._known & valid & (self._seen_s >= KNOWN_S)
        return np.count_nonzero(front & known) / max(np.count_nonzero(known), 1)

    def _is_another(self, front_share: float, light_before: Floats) -> bool:
        """Whether the wall or the light is another one than in the frame before: see ANOTHER_SHARE."""
        change = np.maximum(self.light, DIM) / np.maximum(light_before, DIM)
        return bool((front_share > ANOTHER_SHARE and self._front_share < BEFORE_SHARE)
                    or (change.max() > ANOTHER_COLOR * change.min() and self._front_share < HARDLY))

    def _unlit(self, seen: Image) -> Floats:
        """(h, w, 3) float32: a frame, (h, w, 3) uint8, in the light of the look."""
        return _times(np.asarray(seen, np.float32), 1 / self.light)

    def _learn_wall(self, seen: Image, found: Difference, wall: Booleans, passed: float,
                    settle: float) -> None:
        """Learn the wall's look where nothing is in front."""
        self._count = min(self._count + 1, MEAN_OF)
        binding.learn_wall(seen, self.light, found.planes, wall, self.free, passed, max(settle, LASTING_S),
                           1 / self._count, VARIANCE_RATE, self.look, self._variance, self._known, self._seen_s)
        sample = self._variance[::SAMPLE_PX, ::SAMPLE_PX].ravel()
        middle = (sample.size - 1) // 2
        usual = np.partition(sample, middle)[middle]  # np.median is slower
        np.minimum(self._variance, NOISIEST * usual, out=self._variance)

    def _learn_front(self, seen: Image, labels: Integers, count: int, passed: float, settle: float,
                     part: tuple[slice, slice]) -> None:
        """Learn what stays in front. Some of it becomes the wall: see _became_wall.

        ``seen``: (h, w, 3) uint8. ``labels``, ``count``: the things in front, see parts_of. ``part``: all of
        them are there, and what is near.
        """
        unlit, labels, earlier = self._unlit(seen[part]), labels[part], self._earlier[0]
        other, other_s, was_wall = self._other[part], self._other_s[part], self._was_wall[part]
        seen_s, front = self._seen_s[part], labels > 0
        same = front & (largest_difference(unlit, other) < SAME_LEVELS)
        still = still_parts(labels, count, earlier.front[part], _changed(unlit, earlier.unlit[part]),
                            MOVED_SHARE)
        stays = same & (still | (seen_s < SURE_S))
        other_s += np.float32(passed) * stays
        other_s[same & ~stays & ~was_wall] = 0
        new = front & ~same
        cv2.copyTo(unlit, new.view(np.uint8), other)
        other_s[new], was_wall[new] = 0, False
        wins = (same & was_wall) | self._became_wall(unlit, labels, count, settle, part)
        if self._views.standing.any():
            wins &= ~self._views.like_things(unlit)
        if wins.any():
            self._swap_looks(wins, part)

    def _look_from(self, slope: Floats, seen: Image, found: Difference, valid: Booleans) -> None:
        """Learn from a new view, (2,), which parts of the wall are things, and what is behind them."""
        unlit = self._unlit(seen)
        bare = self._views.add(slope, unlit, self.look, valid)
        found.front[bare] = (largest_difference(unlit, self.look) > SAME_LEVELS)[bare]
        self._take_for_wall(bare)

    def _take_for_wall(self, where: Booleans) -> None:
        """Take the look at some pixels for the wall for good."""
        self._known[where], self._seen_s[where], self._variance[where] = True, LASTING_S, VARIANCE
        self._kept = None
        self._find_plain(where, WHOLE)

    def _clear_patches(self, seen: Image, valid: Booleans, labels: Integers, wall: BlankWall) -> None:
        """Learn which patches of a blank wall are things in front of it.

        ``seen``, ``valid``: see update. ``labels``: see _learn_front.
        """
        things = self._patches.things(seen, valid, self.light, labels)
        if things is None:
            return
        self.look[things] = wall.surface[things]
        self._views.look_changed(things, WHOLE, self.look)
        self._take_for_wall(things)

    def _became_wall(self, unlit: Floats, labels: Integers, count: int, settle: float,
                     part: tuple[slice, slice]) -> Booleans:
        """Where something in front is to be taken for the wall from now on, within a part of the image.

        It has been seen for longer than the wall was, or for ``settle`` seconds. If it is behind a thing that
        has left, SURE_S is enough. If it has come where the wall was seen for LASTING_S, it stays in front.
        """
        other_s, seen_s = self._other_s[part], self._seen_s[part]
        wins = (labels > 0) & (other_s > np.minimum(np.minimum(seen_s, settle), SURE_S))
        if not wins.any():
            return wins
        came, left = came_or_left(labels, count, unlit, self.look[part])
        longer = (other_s > np.minimum(seen_s, settle)) & ~(came[labels] & (seen_s >= LASTING_S))
        return wins & (left[labels] | longer)

    def _swap_looks(self, where: Booleans, part: tuple[slice, slice]) -> None:
        """Make the other look that of the wall, and the wall's the other one, at some pixels of a part."""
        for one, other in ((self.look[part], self._other[part]), (self._seen_s[part], self._other_s[part])):
            one[where], other[where] = other[where], one[where]
        self._was_wall[part][where] = True
        self._variance[part][where] = VARIANCE
        self._kept = None
        self._views.look_changed(where, part, self.look)
        self._find_plain(where, part)
        if self._blank is not None:
            self._patches = Patches(self._blank, self.look, ~self._papers)

    def _find_plain(self, where: Booleans, part: tuple[slice, slice]) -> None:
        """Find out what is plain where the look of a blank wall has changed, within a part of the image."""
        if self._blank is not None and self.plain is not None:
            self.plain[part][where] = _is_near(self.look[part][where], self._blank.surface[part][where])


def _halved(image: Floats) -> Floats:
    """An image of half the width and height, which are even: each pixel is a mean."""
    size = image.shape[1] // 2, image.shape[0] // 2
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)


def _is_near(colors: Floats, surface: Floats) -> Booleans:
    """(...,): where colors are those of the surface of a blank wall, but for a little. Both are (..., 3)."""
    return np.asarray(np.abs(colors - surface).max(axis=-1) < PLAIN_SHARE * surface.mean(axis=-1))


def _times(image: Floats, factors: Floats) -> Floats:
    """(h, w, 3) float32: an image with its channels multiplied by three factors."""
    return np.asarray(cv2.multiply(image, np.array([*factors, 0.0])), np.float32)


def _changed(image: Floats, before: Floats) -> Booleans:
    """(h, w): where no pixel nearby had that color before. Both are (h, w, 3) float32."""
    return np.asarray(difference_from_window(image, before, 3) > SAME_LEVELS)
