"""Tags of which something covers a side: they are shorter than the other tags say."""
from __future__ import annotations

from typing import Mapping

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.tags.tag import Tag

from .layout import Layout, tolerance_of
from .measurement import measurement
from .motion import AreaMotion

# A side of a covered tag is shorter than the others say by more than the first limit, besides the bias of its
# corners, and by more than so many times what these are off themselves. On a sheet that is bent, or seen
# through a bad lens, no tag fits exactly.
SHORT_PX, SHORT_SPREADS = 0.5, 2.0
LEAST = 2         # so many tags must agree, and half of those in sight
MOST_COVERED = 3  # if more tags seem short, it is something else, such as the blur of a moving camera
NEXT = np.array([1, 2, 3, 0])


def short_tags(layout: Layout, motion: AreaMotion, seen: Mapping[int, Tag],
               expected: Mapping[int, Floats]) -> dict[int, dict[int, Floats]]:
    """The tags that are too short: {id: {side: (4, 2) pixels}}, their corners if that side is covered.

    ``seen``: {id: Tag}, known ones in a frame. ``motion``: as it is expected in this frame. It tells what a
    few tags alone do not. ``expected``: {id: (4, 2) pixels}, where it expects these tags.
    """
    if not seen:
        return {}
    ids, count = list(seen), len(seen)
    both = [*(tag.corners for tag in seen.values()), *(expected[tag_id] for tag_id in ids)]
    quads = np.array(both, np.float64)
    lengths = _lengths(quads)
    if max((lengths[count:] - lengths[:count]).ravel().tolist()) <= SHORT_PX:
        return {}  # usually, and fast
    quads, lengths, likely = quads[:count], lengths[:count], lengths[count:]
    measured = measurement(layout, seen, ids)  # points, pixels, deviation and bias, four of each for a tag
    bias = measured[-1][::4]
    if ((likely - lengths).max(axis=1) - bias).max() <= SHORT_PX:
        return {}
    is_left, places = np.ones(count, bool), measured[0].reshape(-1, 4, 2)
    while np.count_nonzero(is_left) >= max(LEAST, count / 2, count - MOST_COVERED):
        left = is_left.repeat(4)
        corrected = motion.corrected(*(part[left] for part in measured)).project(places)
        missing = _lengths(corrected) - lengths
        short, spread = missing.max(axis=1) - bias, np.abs(missing[is_left]).max()
        if not is_left.all() and np.all(short[~is_left] > SHORT_PX + SHORT_SPREADS * spread):
            off = np.linalg.norm(corrected - quads, axis=2)
            in_place = np.count_nonzero(off < tolerance_of(quads)[:, None], axis=1) >= 2  # others were moved
            return {ids[number]: _completed(quads[number], corrected[number])
                    for number in np.flatnonzero(~is_left & in_place)}
        worst = np.argmax(np.where(is_left, short, -np.inf))
        if short[worst] <= SHORT_PX:
            break
        is_left[worst] = False
    return {}


def _completed(quad: Floats, expected: Floats) -> dict[int, Floats]:
    """{side: (4, 2)}: a tag, (4, 2), with that side moved so far that it is as long as is expected, (4, 2).

    These are the two sides across the direction in which it is too short: 0 to 3, clockwise from the top.
    """
    ratio = _lengths(expected[None])[0] / np.maximum(_lengths(quad[None])[0], 1e-6)
    long = int(np.argmax(ratio[:2] + ratio[2:]))  # this side and the opposite one are too short
    found = {}
    for side in (long + 1) % 4, (long + 3) % 4:
        before, first, second, after = (np.arange(4) + side - 1) % 4
        found[side] = quad.copy()
        found[side][first] = quad[before] + ratio[before] * (quad[first] - quad[before])
        found[side][second] = quad[after] + ratio[second] * (quad[second] - quad[after])
    return found


def _lengths(quads: Floats) -> Floats:
    """(n, 4) pixels: the lengths of the sides of quadrilaterals, (n, 4, 2)."""
    corners = quads.view(np.complex128)[..., 0]  # complex numbers, which NumPy subtracts faster than pairs
    return np.abs(corners.take(NEXT, axis=1) - corners)
