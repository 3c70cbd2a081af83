"""What differs from the wall by more than light and noise can explain: something stands in front of it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.compiled import binding

from .parts import around, closed, components, grown, opened, outline_of, shrunk

# The light at a pixel, relative to that on the whole wall: the darkest shadow and the lightest spot.
DARKEST, LIGHTEST = 0.36, 2.6
# What is lighter or darker than the whole wall by these factors is no light or shadow if this share of its
# outline is sharp.
LIGHTER, DARKER, SHARP_SHARE = 1.3, 0.75, 0.6
THING_PX = 9          # narrower things than this are found by their rims alone
RIM_PX = 3            # edges of a pattern may be displaced, so the contrast in a window of this width counts
NEAR_PX = 5           # in a window of this width around pixels surely in front, weaker evidence is enough
# Gaps up to this wide between such pixels are filled where the light differs from that around.
BRIDGE_PX = 21
SMOOTH_PX = 5         # width of the window whose mean color tells where a thing goes on
AROUND_PX = 61        # width of the window that shows the usual light around a pixel
CORE_PX = 9           # what is in front by half of this on all sides has nothing of the wall
SHADE_PX = 15         # width of the window that shows the light on the wall beside a thing
# The light on the wall at the rim of a thing differs from that as if 1 were so many gray levels. A pixel inside
# is no thing if it is off a shadow by less than SHADOW_LEVELS, with less than SHADOW_SHARE of the thing.
SHADE_LEVELS, SHADOW_LEVELS, SHADOW_SHARE = 50.0, 10.0, 0.25
RIM_MARGIN_PX = 8     # width of the margin around the things in front, for their rims
MIN_CONTRAST = 5.0    # gray levels between a thing and the wall that are needed to tell a pixel's share
# The widths of the windows in which a pattern is recognized, and the least correlation with the wall's. The
# large window also shows what a glare has made pale.
WINDOWS = (15, 0.8), (61, 0.7)
FIT = 0.25            # a pixel fits if it is off by less than noise plus this share of the pattern's deviation
PATTERN_LEVELS = 6.0  # least standard deviation of a pattern that can be recognized, in gray levels
# How the wall is aligned with the frame. Its displacement is at most MAX_MOVE_PX pixels, and is averaged in a
# window of the width MOVED_PX, weighted by the contrast beyond NO_PATTERN gray levels. With a mean contrast of
# about FEW_PATTERN or less beyond that, it is hardly moved.
MAX_MOVE_PX, MOVED_PX = 4, 31
NO_PATTERN, FEW_PATTERN = 6, 2
COARSE, HALF = 4, 2   # means in large windows are computed of images that are smaller by these factors
OWN_LIGHT = np.ones(3, np.float32)
MARGIN_PX = 40        # width of the margin around what seems to be in front that is looked at twice


@dataclass(frozen=True)
class Difference:
    """How a frame differs from the wall. ``front``: (h, w), where something seems to stand in front of it.

    ``planes``: (8, h, w) float32, what unit5_compare_wall has found out about each pixel; see wall.c.
    """

    front: Booleans
    planes: Floats


def difference(seen: Image, look: Floats, whole: Floats, contrast: Image, variance: Floats, usable: Booleans,
               unshaded: float = 1.0) -> Difference:
    """Compare a rectified frame with the wall.

    ``seen``: (h, w, 3) uint8, the frame. ``look``: (h, w, 3) float32, the wall. ``whole``: (3,) float32, the
    light on all of it, as factors of ``look``. ``contrast``: of the look, see contrast_of. ``variance``: (h, w)
    float32, of the noise. ``usable``: (h, w), where both are known. ``unshaded``: the light outside of shadows,
    as a factor of that on the whole wall.
    """
    front, planes = compare(seen, look, whole, contrast, variance, usable, unshaded)
    front = opened(front)
    if front.any():
        rows, columns = part = around(front, MARGIN_PX, COARSE)
        front[part], planes[:, rows, columns] = _looked_at_twice(
            front[part], seen[part], look[part], whole, contrast[part], variance[part], usable[part], unshaded)
    return Difference(front, planes)


def _looked_at_twice(front: Booleans, seen: Image, look: Floats, whole: Floats, contrast: Image,
                     variance: Floats, usable: Booleans, unshaded: float) -> tuple[Booleans, Floats]:
    """A better Difference, as its parts, of a window in which something seems to be in front.

    The other arguments are those of ``difference``, within that window.
    """
    in_light = np.asarray(largest_channel(contrast), np.float32) * whole.mean()
    weight = np.maximum(in_light, NO_PATTERN) - NO_PATTERN
    aligned = _aligned(look, whole, weight, seen) if weight.any() else look
    still_front, planes = compare(seen, aligned, whole, contrast_of(aligned), variance, usable, unshaded)
    front = front & still_front
    pixels = _Planes(*planes)
    free = ~usable | _shows_pattern(seen, binding.light_wall(aligned, whole), pixels, front)
    front = opened(front & ~free)
    return _completed(front, pixels, usable, free) if front.any() else front, planes


class _Planes(NamedTuple):
    """What the C function compare has found out about each pixel, (h, w) float32 each; see wall.c."""

    gray: Floats
    wall_gray: Floats
    light: Floats
    error: Floats
    excess: Floats
    step: Floats
    noise: Floats
    rims: Floats


def _completed(front: Booleans, pixels: _Planes, usable: Booleans, free: Booleans) -> Booleans:
    """(h, w): the pixels surely in front, (h, w), and around them those with weaker evidence.

    ``usable``: (h, w), where the wall is known. ``free``: (h, w), where nothing is in front.
    """
    _, wall_gray, light, _, excess, step, noise, rims = pixels
    # Beside a thing that is surely in front, a shadow begins sharply. So there, a sharp rim says nothing.
    sure = grown((excess > 1) | (light < DARKEST), RIM_PX)
    darker = ((DARKER - light) * wall_gray > noise + rims) & ~free & ~sure
    front = (front | _with_sharp_rims(((light - LIGHTER) * wall_gray > noise + rims) & ~free, step > 1)
             | _with_sharp_rims(darker, step > 1, grown(sure, NEAR_PX)))
    unusual = np.abs(light - _usual(light, usable & ~grown(front, NEAR_PX))) * wall_gray - rims > noise / 2
    weak = excess > 0.5
    mean = np.asarray(cv2.blur(np.minimum(excess, 1), (SMOOTH_PX, SMOOTH_PX)))
    front |= _connected((mean > 0.5) & (excess > 0.25), front)
    front |= grown(front, NEAR_PX) & (weak | ((step > 0.5) & unusual))
    front |= closed(front, BRIDGE_PX) & (weak | unusual)
    return front & ~free


def compare(seen: Image, look: Floats, whole: Floats, contrast: Image, variance: Floats, usable: Booleans,
            unshaded: float = 1.0) -> tuple[Booleans, Floats]:
    """(h, w), where something seems to stand in front of the wall, and the planes: see wall.c."""
    return binding.compare_wall(seen, look, whole, contrast, variance, usable, DARKEST, unshaded * LIGHTEST)


def contrast_of(look: Floats) -> Image:
    """(h, w, 3) uint8: the largest differences near each pixel of a look, (h, w, 3) float32, in its light."""
    kernel, wall = np.ones((RIM_PX, RIM_PX), np.uint8), binding.light_wall(look, OWN_LIGHT)
    return cv2.subtract(cv2.dilate(wall, kernel), cv2.erode(wall, kernel))


def _aligned(look: Floats, whole: Floats, weight: Floats, seen: Image) -> Floats:
    """(h, w, 3) float32: the look, moved by a few pixels to where the frame shows it.

    A sheet that is not flat, or a lens that is not calibrated, displaces it. The
    displacement is smooth, and known where the wall has a pattern. ``weight``:
    (h, w) float32, how much it tells at each pixel. The others are those of
    ``difference``.
    """
    height, width = weight.shape
    method = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)  # one must not serve two threads
    gray, wall_gray = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in (
        seen, binding.light_wall(look, whole)))
    flow = method.calc(gray, wall_gray, NO_ARRAY)
    # What is averaged in so large a window may be coarse before.
    weight = _coarse(weight, COARSE)
    limited = np.clip(_coarse(flow, COARSE), -MAX_MOVE_PX, MAX_MOVE_PX)
    moved = _mean_around(np.asarray(limited * weight[..., None], np.float32), MOVED_PX // COARSE)
    moved /= (_mean_around(weight, MOVED_PX // COARSE) + FEW_PATTERN)[..., None]
    moved = _fine(moved, (height, width))
    moved[..., 0] += np.arange(width, dtype=np.float32)
    moved[..., 1] += np.arange(height, dtype=np.float32)[:, None]
    aligned = cv2.remap(look, moved, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(aligned, np.float32)


def soft_rim(seen: Floats, wall: Floats, front: Booleans) -> Floats:
    """(h, w) float32, 0 to 1: how much of each pixel the things in front cover.

    ``seen``, ``wall``: see difference. A pixel at a rim is a mixture of the color of the thing and that of the
    wall, which may be in a shadow of the thing there. Least squares tell both shares of each pixel. The shadow
    is expected to be like that on the wall around, see SHADE_LEVELS.
    """
    share = np.zeros(front.shape, np.float32)
    part = around(front, RIM_MARGIN_PX)
    seen, wall, front = seen[part], wall[part], front[part]
    core = shrunk(front, CORE_PX)
    rim = grown(front, 3)
    free = ~rim
    rim &= ~core
    at = np.nonzero(rim)
    weight = core + np.float32(0.01) * front  # without a core nearby, all of ``front`` counts
    window = 2 * CORE_PX - 1, 2 * CORE_PX - 1
    weights = np.maximum(cv2.blur(weight, window)[at], 1e-4)[:, None]
    things: Floats = cv2.blur(cv2.multiply(seen, cv2.merge([weight] * 3)), window)[at] / weights
    mixed, off = _mixture(seen[at], things, wall[at], _shade_around(seen, wall, free)[at])
    is_shadow = (mixed < SHADOW_SHARE) & (off < SHADOW_LEVELS)
    shares = core.astype(np.float32)
    shares[at] = np.where(shrunk(front, 5)[at] & ~is_shadow, 1, mixed)
    share[part] = shares
    return share


def _mixture(colors: Floats, things: Floats, walls: Floats, shade: Floats) -> tuple[Floats, Floats]:
    """(n,) each: the share of the thing in each color, 0 to 1, and how far the mixture is off, in gray levels.

    ``colors``, ``things``, ``walls``: (n, 3) float32, a pixel, the thing there, and the wall. ``shade``: (n,),
    the light that is expected on the wall. A color is share * thing + rest * wall. Least squares tell both
    factors, where rest is expected to be (1 - share) * shade.
    """
    trust = np.float32(SHADE_LEVELS**2)
    thing_thing, thing_wall, wall_wall, thing_color, wall_color = (
        np.einsum('nc,nc->n', one, other) for one, other in (
            (things, things), (things, walls), (walls, walls), (things, colors), (walls, colors)))
    thing_thing += trust * shade * shade
    thing_wall += trust * shade
    wall_wall += trust
    thing_color += trust * shade * shade
    wall_color += trust * shade
    least = np.float32(3 * MIN_CONTRAST**2)  # with less contrast than that, nothing is known
    determinant = thing_thing * wall_wall - thing_wall * thing_wall + least * wall_wall
    share = np.clip((thing_color * wall_wall - wall_color * thing_wall) / determinant, 0, 1)
    rest = (wall_color - share * thing_wall) / wall_wall
    off = np.abs(colors - share[:, None] * things - rest[:, None] * walls).max(axis=1)
    return share, np.maximum(off, SHADE_LEVELS * np.abs(rest - (1 - share) * shade))


def _shade_around(seen: Floats, wall: Floats, free: Booleans) -> Floats:
    """(h, w) float32: the mean light on the free wall around each pixel, a factor; 1 where nothing is free."""
    mask, window = free.view(np.uint8), (SHADE_PX, SHADE_PX)
    bright, usual = (cv2.blur(cv2.copyTo(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), mask), window)
                     for image in (seen, wall))
    return np.asarray((bright + 1e-3) / (usual + 1e-3), np.float32)


def largest_difference(one: Floats, other: Floats) -> Floats:
    """(h, w) float32: the largest difference among the channels of two images, (h, w, 3) float32."""
    return np.asarray(largest_channel(cv2.absdiff(one, other)), np.float32)


def difference_from_window(image: Floats, other: Floats, px: int) -> Floats:
    """(h, w) float32: how far a color is off all that another image has in a window of that width there.

    Both are (h, w, 3) float32. It is the largest one of the channels, each for itself; 0 or less in between.
    """
    window = np.ones((px, px), np.uint8)
    off = cv2.max(cv2.subtract(image, cv2.dilate(other, window)), cv2.subtract(cv2.erode(other, window), image))
    return np.asarray(largest_channel(off), np.float32)


def largest_channel(image: Image) -> Image:
    """(h, w): the largest of the three channels of an image. NumPy's own maximum takes many times as long."""
    blue, green, red = cv2.split(image)
    return cv2.max(cv2.max(blue, green), red)


def mean_channel(image: Floats) -> Floats:
    """(h, w) float32: the mean of the three channels of an image. NumPy's own mean takes many times as long."""
    blue, green, red = cv2.split(image)
    return np.asarray((blue + green + red) / np.float32(3))


def _mean_around(image: Floats, px: int) -> Floats:
    """The mean of an image in a window of that width around each pixel."""
    return np.asarray(cv2.boxFilter(image, -1, (px, px)))


def _coarse(image: Image | Floats, factor: int) -> Floats:
    """A float32 image that is smaller by a factor: each pixel is a mean."""
    height, width = image.shape[:2]
    size = max(width // factor, 1), max(height // factor, 1)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)


def _fine(image: Floats, shape: tuple[int, ...]) -> Floats:
    """A coarse image at full size again, (h, w)."""
    return np.asarray(cv2.resize(image, shape[1::-1], interpolation=cv2.INTER_LINEAR))


def _with_sharp_rims(mask: Booleans, sharp: Booleans, ignored: Booleans | None = None) -> Booleans:
    """(h, w): the connected parts of a mask that have sharp rims, but for what is ignored. All are (h, w)."""
    mask = grown(shrunk(mask, THING_PX), THING_PX)
    if not mask.any():
        return mask
    labels, count = components(mask)
    outline = outline_of(mask) if ignored is None else outline_of(mask) & ~ignored
    length, sharp_length = (np.bincount(labels[part], minlength=count + 1)
                            for part in (outline, outline & grown(sharp, 3)))
    return (sharp_length > SHARP_SHARE * length)[labels]


def _connected(mask: Booleans, seeds: Booleans) -> Booleans:
    """(h, w): the connected parts of a mask that contain seeds, (h, w)."""
    labels, count = components(mask)
    chosen = np.bincount(labels[seeds], minlength=count + 1) > 0
    chosen[0] = False
    return chosen[labels]


def _usual(light: Floats, free: Booleans) -> Floats:
    """(h, w) float32: the mean light around each pixel, where it is free; 1 where nothing is free."""
    weight = free.astype(np.float32)
    sums, weights = (_mean_around(_coarse(image, COARSE), AROUND_PX // COARSE)
                     for image in (light * weight, weight))
    return _fine((sums + 1e-3) / (weights + 1e-3), light.shape)


def _shows_pattern(seen: Image, wall: Image, pixels: _Planes, where: Booleans) -> Booleans:
    """(h, w): of the pixels ``where``, (h, w), those where the wall's pattern is seen, so nothing is in front.

    ``seen``, ``wall``: (h, w, 3) uint8, the frame and the wall in the same light. ``pixels``: what is known of
    each pixel. In a window, light changes the contrast of the pattern, and a glare adds to it. Both are
    estimated. The pattern is seen where it correlates with the wall's, and where the pixel itself fits.
    """
    shows = np.zeros(where.shape, bool)
    if not where.any():
        return shows
    # The frame is smooth: half as many pixels across and down show a pattern as well.
    grays = _coarse(pixels.gray, HALF), _coarse(pixels.wall_gray, HALF)
    colors = [_coarse(image, HALF) for image in (seen, wall)]
    near = grown(_coarse(where.view(np.uint8) * 255, HALF) > 0, 3)
    for px, least in WINDOWS:
        window = px // HALF
        pattern, wall_pattern = (image - _mean_around(image, window) for image in grays)
        own, known = (np.maximum(_mean_around(image * image, window), 0) for image in (pattern, wall_pattern))
        both = _mean_around(pattern * wall_pattern, window)
        like = both > least * np.sqrt(own * known)
        like &= near & (known > PATTERN_LEVELS**2) & (own > PATTERN_LEVELS**2 / 16)
        if like.any():
            part = around(like, 1)
            whole_part = tuple(slice(HALF * side.start, HALF * side.stop) for side in part)
            factor = both[part] / np.maximum(known[part], PATTERN_LEVELS**2)
            fits = FIT * factor * np.sqrt(known[part])
            color, wall_color = (_mean_around(image, window)[part] for image in colors)
            rest = color - factor[..., None] * wall_color  # the glare
            rest, factor, fits, liked = (_fine(image, where[whole_part].shape)
                                         for image in (rest, factor, fits, like[part].astype(np.float32)))
            off = largest_difference(seen[whole_part] - rest, factor[..., None] * wall[whole_part])
            shows[whole_part] |= (liked >= 0.5) & (off < pixels.noise[whole_part] + fits)
    return shows & where
