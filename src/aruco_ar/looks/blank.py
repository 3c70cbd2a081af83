"""A blank wall: one color in a light that changes smoothly. It can be known even where something hides it."""
from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats

from .difference import largest_difference, mean_channel
from .parts import grown, outline_of, parts_of

STEP_PX = 6           # every sixth pixel is enough for the surface
ROUNDS = 12           # rounds of the iterative fit
# How far pixels of a blank wall are off the surface, as a share of the brightness: those of a flat wall, and
# those of a crumpled sheet, whose creases are lit and shaded.
FLAT, CRUMPLED = 0.05, 0.2
# A pixel is not the blank wall if its brightness differs by more than HIDDEN_LEVELS and three deviations, or
# its color by more than HIDDEN_LEVELS and this share of the brightness.
HIDDEN_LEVELS, COLOR = 4.0, 0.06
BLANK_SHARE = 0.4     # share of a blank wall's pixels that must follow the surface
# Longest outline of things that hide the wall, divided by the root of their size. Patterns have a longer one.
MAX_OUTLINE = 10
# Share of a blank wall that may be something else that hangs there. It may be more if its outline is short.
MAX_OTHER_SHARE, MAX_LARGE_SHARE = 0.2, 0.5
RIM_PX = 7            # pixels this near to what hides the wall may be mixtures with it
# More things than this that reach over the rim of the area are a pattern. So are things over all of its sides.
MAX_HIDING = 3


@dataclass(frozen=True)
class BlankWall:
    """A wall behind all that hides it.

    ``surface``: (h, w, 3) float32, BGR. ``hidden``: (h, w), where something hides it. ``shown``: (h, w), where
    the wall is seen. ``is_flat``: whether its brightness changes smoothly; that of a crumpled sheet does not,
    though its color is the same all over.
    """

    surface: Floats
    hidden: Booleans
    shown: Booleans
    is_flat: bool

    def shows(self, seen: Floats, part: tuple[slice, slice]) -> Booleans:
        """(h, w): where a part of a frame, (h, w, 3) float32, in the light of the surface, shows this wall."""
        return ~_differs(seen, self.surface[part], FLAT if self.is_flat else CRUMPLED)


def blank_wall(seen: Floats, usable: Booleans) -> BlankWall | None:
    """The BlankWall behind all that hides it; None if the wall is not blank.

    ``seen``: (h, w, 3) float32, the rectified area. ``usable``: (h, w), where the frame shows it, without tags.
    Only a thing that reaches over the rim of the area hides the wall, as a hand or a person does. A thing
    within the area hangs on the wall.
    """
    for deviation in FLAT, CRUMPLED:
        surface = _surface(seen, usable, deviation)
        if surface is not None:
            differs = _differs(seen, surface, deviation)
            hidden = _hidden(usable & differs, usable, deviation == FLAT)
            if hidden is not None:
                return BlankWall(surface, hidden, usable & ~differs, deviation == FLAT)
    return None


def _differs(seen: Floats, surface: Floats, deviation: float) -> Booleans:
    """(h, w): where the wall is not seen: its brightness differs much, or its color a little."""
    gray, wall_gray = mean_channel(seen), np.maximum(mean_channel(surface), 1)
    lit = np.asarray(cv2.multiply(surface, cv2.merge([gray / wall_gray] * 3)), np.float32)
    off = largest_difference(seen, lit)
    return np.asarray((np.abs(gray - wall_gray) > HIDDEN_LEVELS + 3 * deviation * wall_gray)
                      | (off > HIDDEN_LEVELS + COLOR * gray))


def _hidden(differs: Booleans, usable: Booleans, is_flat: bool) -> Booleans | None:
    """(h, w): what hides the wall, of what differs from it; None if that is a pattern.

    ``is_flat``: whether a large thing may hang there. The creases of a crumpled sheet would seem to be one.
    """
    labels, _ = parts_of(differs)
    rims = [np.unique(rim[rim > 0]) for rim in (labels[0], labels[-1], labels[:, 0], labels[:, -1])]
    over_rim = np.unique(np.concatenate(rims))
    hidden = np.isin(labels, over_rim)
    if _is_ragged(hidden) or all(len(rim) for rim in rims) or len(over_rim) > MAX_HIDING:
        return None
    other = (labels > 0) & ~hidden
    share = np.count_nonzero(other) / max(np.count_nonzero(usable & ~hidden), 1)
    if share > (MAX_OTHER_SHARE if not is_flat or _is_ragged(other) else MAX_LARGE_SHARE):
        return None
    return grown(hidden, RIM_PX)


def _is_ragged(mask: Booleans) -> bool:
    """Whether the outline of a mask is too long for that of things: see MAX_OUTLINE."""
    return np.count_nonzero(outline_of(mask)) > MAX_OUTLINE * np.sqrt(max(np.count_nonzero(mask), 1))


def _surface(seen: Floats, usable: Booleans, deviation: float) -> Floats | None:
    """(h, w, 3) float32: a smooth surface that most pixels follow, or None.

    ``deviation``: FLAT or CRUMPLED. It is a polynomial of the second order for the logarithm, fitted by
    iteratively reweighted least squares, with the squares of Cauchy's weights. So what differs has hardly any
    influence.
    """
    height, width = seen.shape[:2]
    chosen = usable[::STEP_PX, ::STEP_PX]
    if np.count_nonzero(chosen) < 40:
        return None
    rows, columns = np.nonzero(chosen)
    terms = _terms(columns * STEP_PX / width, rows * STEP_PX / height)
    values = np.log(np.maximum(seen[::STEP_PX, ::STEP_PX][chosen], 1))
    # The start is the brightness that occurs most often.
    gray = values.mean(axis=1)
    counts, edges = np.histogram(gray, 24, (gray.min() - 1e-3, gray.max() + 1e-3))
    often = np.argmax(np.convolve(counts, [1, 1, 1], 'same'))
    weights = 1 / (1 + ((gray - edges[often:often + 2].mean()) / 0.2)**2)
    off = np.zeros(len(gray))
    found = np.zeros((6, 3))
    for _ in range(ROUNDS):
        weighted = weights * terms.T
        found = np.linalg.lstsq(weighted @ terms, weighted @ values, rcond=None)[0]
        if deviation == CRUMPLED:  # it has one color: otherwise a large hand among creases would pass for paper
            found[1:] = found[1:].mean(axis=1, keepdims=True)
            found[0] = np.average(values - terms[:, 1:] @ found[1:], axis=0, weights=weights)
        rest = values - terms @ found
        shade = rest.mean(axis=1)
        off = np.abs(rest).max(axis=1) if deviation == FLAT else np.maximum(
            np.abs(shade), np.abs(rest - shade[:, None]).max(axis=1) * CRUMPLED / FLAT)
        weights = 1 / (1 + (off / deviation)**2)**2
    if np.mean(off < 2 * deviation) < BLANK_SHARE:
        return None
    x, y = np.meshgrid(np.arange(0, width, STEP_PX) / width, np.arange(0, height, STEP_PX) / height)
    coarse = np.exp(np.clip(_terms(x, y) @ found, 0, 6)).astype(np.float32)
    fine = cv2.resize(coarse, None, fx=STEP_PX, fy=STEP_PX, interpolation=cv2.INTER_LINEAR)
    return np.asarray(fine, np.float32)[:height, :width]


def _terms(x: Floats, y: Floats) -> Floats:
    """(..., 6): the terms of the polynomial at places from 0 to 1."""
    x, y = 2 * x - 1, 2 * y - 1
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
