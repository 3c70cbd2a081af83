"""Squares in sight that are tags of any dictionary or of none, all found and read in one search."""
from __future__ import annotations

from functools import lru_cache
from typing import Dict, NamedTuple, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers
from aruco_ar.geometry.homography import homography_to
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.tags.detector import MIN_CONTRAST, MIN_WHOLE, MIN_WHOLE_WIDE, WHOLE_OF_PX
from aruco_ar.tags.edges import compare_tags, fit_tags, sample_cells, side_of
from aruco_ar.tags.quads import inner_cells
from aruco_ar.tags.tag import DICTIONARY_NAMES, get_dictionary

WINDOWS, OFFSET = (7, 21), 7    # of adaptive thresholds: pixels, and gray levels below the mean around
MIN_RIM_PX, OFF_RIM = 32, 0.03  # the shortest rim of a square, and how far it may be off four straight lines
MAX_SQUARES = 600    # of more than these, only the largest are read
FITTED_CELLS = 8     # the width, in cells, that squares are assumed to have when they are fitted to their edges
SAME = 0.08          # two squares are the same one if they are less apart than this share of the side
MAX_WRONG = 0.15     # at most this share of a border's cells may be of the wrong color
CORRECTION = 0.5     # of the wrong cells that a dictionary can correct
NEAR = 0.1           # by how much less a grid may fit a square than the one that fits best

# Anything may have a border. So a tag of no known dictionary must be seen clearly, and be like a tag.
UNKNOWN_SIZES = 4, 5, 6, 7, 8  # cells within a black border
WHITE_SIZES, AROUND = (3, 4), 2  # within a white border: AprilTag's newer families, with AROUND more rings
MIN_CELL_PX = 3.0              # the width of a cell
MIN_UNKNOWN = 0.85             # the correlation of all that is seen with the cells
LIGHT_SHARE = 0.2, 0.8         # of the cells
MIN_CHANGES = 0.3              # the share of neighbors that differ
MIN_UNLIKE = 2                 # the number of cells that change when the tag is turned or mirrored

PLAIN, MIRRORED, UNKNOWN = 'plain', 'mirrored', 'unknown'  # how a tag is seen


class Kind(NamedTuple):
    """A kind of tags. ``border``: its width, cells.

    ``family``: the names of the dictionaries with these tags, the smallest dictionary first; () if UNKNOWN.
    """

    way: str
    border: int
    family: tuple[str, ...]


Meanings = Dict[Kind, int]  # all that one square may be: for each Kind, the id
UNKNOWN_TAG = Kind(UNKNOWN, 1, ())


class _Codes(NamedTuple):
    """All known tags with n * n cells.

    ``cells``: (n * n, k) float32, -1 or 1. ``tags``: k pairs of a family and an id. ``least``: (k,), the dot
    product that is needed; each wrong cell takes 2 from it.
    """

    cells: Floats
    tags: list[tuple[tuple[str, ...], int]]
    least: Floats


class _Grid(NamedTuple):
    """Squares read as if they were ``wide`` cells wide.

    ``numbers``: (k,), which squares. ``light``: (k, wide + 2, wide + 2) bool, the cells and those around; of
    the negative if the border is white. ``white``: (k,) bool, whether it is. ``whole``: (k,), see compare_tags.
    """

    wide: int
    numbers: Integers
    light: Booleans
    white: Booleans
    whole: Floats


def smallest_with(names: Sequence[str], tag_id: int) -> str:
    """The first of these dictionaries that has a tag with that id. One of them must."""
    return next(name for name in names if tag_id < len(get_dictionary(name).bytesList))


def read_squares(gray: Image, borders: Sequence[int]) -> list[Meanings]:
    """All that may be tags in a frame, (h, w) uint8: for each, what it may be.

    ``borders``: the widths of the black borders of known tags, cells. The id of a tag of no known dictionary is
    a number made of its cells.
    """
    quads = _squares(gray)
    widths = {size + 2 * border for size in _known_sizes() for border in borders}
    widths |= {size + 2 for size in (*WHITE_SIZES, *UNKNOWN_SIZES)}
    grids = [_grid(gray, quads, wide) for wide in sorted(widths)] if len(quads) else []
    best = np.zeros(len(quads))
    for grid in grids:
        np.maximum.at(best, grid.numbers, grid.whole)
    read: list[tuple[bool, float, int, Meanings]] = []  # first by whether it is no known tag
    for grid in grids:
        near = np.flatnonzero(grid.whole >= best[grid.numbers] - NEAR)
        for index, meanings in zip(near, _meanings(grid.light[near], borders)):
            whole, number = float(grid.whole[index]), int(grid.numbers[index])
            if meanings:
                read.append((False, -whole, number, meanings))
            elif whole == best[number]:
                tag_id = _unknown_id(gray, quads[number], grid, index)
                if tag_id is not None:
                    read.append((True, -whole, number, {UNKNOWN_TAG: tag_id}))
    # One square in each place: a known tag if there is one, and else the one that is read best.
    centers, sides, taken, found = quads.mean(axis=1), side_of(quads), np.zeros(len(quads), bool), []
    for _, _, number, meanings in sorted(read, key=lambda each: each[:3]):
        if not taken[number]:
            found.append(meanings)
            taken |= np.abs(centers - centers[number]).max(axis=1) < np.maximum(sides, sides[number]) / 2
    return found


def families() -> list[tuple[str, ...]]:
    """The names of the dictionaries with the same tags, the smallest dictionary first."""
    found: dict[str, list[str]] = {}
    for name in DICTIONARY_NAMES:
        family = name.rpartition('_')[0] if name.rpartition('_')[2].isdigit() else name
        found.setdefault(family, []).append(name)
    return [tuple(sorted(names, key=lambda name: len(get_dictionary(name).bytesList)))
            for names in found.values()]


def _squares(gray: Image) -> Floats:
    """(n, 4, 2) float32: the corners of what may be squares in perspective, clockwise, the largest first."""
    found: list[Image] = []
    for window in WINDOWS:
        dark = cv2.adaptiveThreshold(gray, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, window,
                                     OFFSET)
        # RETR_LIST, since a white square is a hole in what is dark.
        for contour in cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)[0]:
            if len(contour) >= MIN_RIM_PX:
                rim = cv2.approxPolyDP(contour, OFF_RIM * len(contour), True)
                if len(rim) == 4 and cv2.isContourConvex(rim):
                    found.append(rim[:, 0])
    quads = np.array(found, np.float32).reshape(-1, 4, 2)
    if not len(quads):
        return quads
    along = quads[:, 1:3] - quads[:, :2]
    turned = along[:, 0, 0] * along[:, 1, 1] < along[:, 0, 1] * along[:, 1, 0]
    quads[turned] = quads[turned, ::-1]
    quads = quads[np.argsort(-side_of(quads), kind='stable')[:MAX_SQUARES]]
    seen = sample_cells(gray, quads, FITTED_CELLS, -1).reshape(-1, FITTED_CELLS + 2, FITTED_CELLS + 2)
    white = _ring(seen, 1).mean(axis=1) > _ring(seen, 0).mean(axis=1)
    cells = np.zeros((len(quads), FITTED_CELLS, FITTED_CELLS), np.uint8)
    cells[white] = 255
    quads, _, _ = fit_tags(gray, quads, cells)
    quads = quads[is_quadrilateral(quads)]
    centers, sides = quads.mean(axis=1), side_of(quads)
    apart = np.abs(centers[:, None] - centers).max(axis=2) + np.abs(sides[:, None] - sides)
    return quads[~np.triu(apart < SAME * sides, 1).any(axis=0)]


def _grid(gray: Image, quads: Floats, wide: int) -> _Grid:
    """The squares that may be tags ``wide`` cells wide, border included."""
    seen = sample_cells(gray, quads, wide, -1).reshape(-1, wide + 2, wide + 2)
    own = seen[:, 1:-1, 1:-1].reshape(len(seen), -1)
    middle = own.mean(axis=1, keepdims=True)
    for _ in range(3):  # the threshold comes to be halfway between the means of the dark and the light cells
        is_light = own > middle
        light = (own * is_light).sum(axis=1) / np.maximum(is_light.sum(axis=1), 1)
        dark = (own * ~is_light).sum(axis=1) / np.maximum((~is_light).sum(axis=1), 1)
        middle = (light + dark)[:, None] / 2
    share = _ring(seen > middle[..., None], 1).mean(axis=1)
    good = np.flatnonzero((np.minimum(share, 1 - share) <= MAX_WRONG) & (light >= dark + MIN_CONTRAST))
    cells, white = seen[good] > middle[good, :, None], share[good] > 0.5
    whole = compare_tags(gray, quads[good], cells[:, 1:-1, 1:-1] * np.uint8(255))
    fits = whole > np.minimum(MIN_WHOLE + WHOLE_OF_PX * side_of(quads[good]) / wide, MIN_WHOLE_WIDE)
    return _Grid(wide, good[fits], (cells ^ white[:, None, None])[fits], white[fits], whole[fits])


def _ring(cells: Booleans | Floats, depth: int) -> Booleans | Floats:
    """(k, m): the values of the cells of the ring at some depth in (k, n, n)."""
    count = cells.shape[1]
    rim = np.zeros((count, count), bool)
    rim[depth:count - depth, depth:count - depth] = True
    rim[depth + 1:count - depth - 1, depth + 1:count - depth - 1] = False
    return cells[:, rim]


def _known_sizes() -> list[int]:
    return sorted({get_dictionary(name).markerSize for name in DICTIONARY_NAMES})


@lru_cache(maxsize=None)
def _codes(size: int) -> _Codes:
    cells, tags, least = [], [], []
    for family in families():
        marker = get_dictionary(family[-1])
        if marker.markerSize == size:
            inner = inner_cells(family[-1])
            count = len(inner)
            cells.append(inner.reshape(count, -1))
            tags += [(family, tag_id) for tag_id in range(count)]
            least += [size * size - 2 * int(CORRECTION * marker.maxCorrectionBits)] * count
    return _Codes(2 * np.concatenate(cells).T - np.float32(1), tags, np.array(least, np.float32))


def _meanings(light: Booleans, borders: Sequence[int]) -> list[Meanings]:
    """For each square, the known tags that it may be. ``light``: see _Grid."""
    found: list[Meanings] = [{} for _ in light]
    for border in borders:
        size = light.shape[1] - 2 - 2 * border
        if size not in _known_sizes():
            continue
        rim = np.concatenate([_ring(light, 1 + depth) for depth in range(border)], axis=1)
        good = np.flatnonzero(rim.mean(axis=1) <= MAX_WRONG)
        inner, codes = light[good, 1 + border:-1 - border, 1 + border:-1 - border], _codes(size)
        for way in PLAIN, MIRRORED:
            for turns in range(4):
                seen = np.rot90(inner[:, :, ::-1] if way == MIRRORED else inner, turns, axes=(1, 2))
                alike = (2 * seen.reshape(-1, size * size) - np.float32(1)) @ codes.cells
                for hit in np.flatnonzero(alike > codes.least - 1):
                    number, code = divmod(int(hit), len(codes.tags))
                    family, tag_id = codes.tags[code]
                    found[good[number]].setdefault(Kind(way, border, family), tag_id)
    return found


def _unknown_id(gray: Image, quad: Floats, grid: _Grid, index: int) -> int | None:
    """A number that stands for the cells of a square, however it is turned; None if it is not like a tag."""
    cells, wide, is_white = grid.light[index], grid.wide, bool(grid.white[index])
    own, code = cells[1:-1, 1:-1], cells[2:-2, 2:-2]
    is_clear = grid.whole[index] >= MIN_UNKNOWN and side_of(quad[None])[0] >= MIN_CELL_PX * wide
    if not is_clear or wide - 2 not in (WHITE_SIZES if is_white else UNKNOWN_SIZES) \
            or _ring(own[None], 0).any() or not _ring(cells[None], 0).all():
        return None
    if is_white:
        seen = 255 - sample_cells(gray, quad[None], wide, -AROUND).reshape(wide + 2 * AROUND, -1)
        middle = seen[AROUND:-AROUND, AROUND:-AROUND]
        code = seen > (middle[own].mean() + middle[~own].mean()) / 2
        first, last = -AROUND / wide, 1 + AROUND / wide
        corners = np.array([[[first, first], [last, first], [last, last], [first, last]]])
        whole = cv2.perspectiveTransform(corners, homography_to(quad)).astype(np.float32)
        if compare_tags(gray, whole, ~code[None] * np.uint8(255))[0] < MIN_UNKNOWN:
            return None
    changes = np.concatenate([(code[1:] != code[:-1]).ravel(), (code[:, 1:] != code[:, :-1]).ravel()]).mean()
    turned = [np.rot90(each, turns) for turns in range(4) for each in (code, code[:, ::-1])]
    if not LIGHT_SHARE[0] <= code.mean() <= LIGHT_SHARE[1] or changes < MIN_CHANGES \
            or min(np.sum(each != code) for each in turned[1:]) < MIN_UNLIKE:
        return None
    return min(int(''.join('01'[int(cell)] for cell in each.ravel()), 2) for each in turned[::2])
