"""What frames of a camera show of a flat sheet, and which of them tell more than others."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats

MAX_VIEWS = 60
MIN_POINTS = 8  # of a view that tells something
MIN_SPREAD = 0.5  # squares of a board: the smaller singular value of the points that are seen, less their mean
ALIKE = 0.04  # between two views (see View.describe) that both count as different
CELLS = 8, 6  # of the frame, for the coverage


@dataclass(frozen=True)
class View:
    """What one frame shows of the sheet. ``points``: {key: (n, 2) float64 pixels}.

    A key is the id of a tag, whose four corners are the pixels, or that of a single point of a board.
    """

    points: dict[int, Floats]

    def describe(self, size: tuple[int, int]) -> Floats:
        """(5,): where in a frame of that size, how large and how slanted the sheet is seen."""
        points = np.concatenate(list(self.points.values())) / np.array(size)
        spread = np.cov(points.T)
        return np.array([*points.mean(axis=0), *np.sqrt(spread.diagonal()), 4 * spread[0, 1]])


def is_spread(view: View, board: dict[int, Floats] | None = None) -> bool:
    """Whether a view tells something: it has enough points, and they are not all on one line of the board.

    ``board``: {key: (n, 2) float64}, where the points of a board are; None for tags, which are never a line.
    """
    if sum(map(len, view.points.values())) < MIN_POINTS:
        return False
    if board is None:
        return True
    places = np.concatenate([board[key] for key in view.points])
    return bool(np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[-1] > MIN_SPREAD)


def different_views(views: Sequence[View], size: tuple[int, int], least: float = ALIKE) -> list[View]:
    """The most different ones of many views, by where and how large they show the sheet, at most MAX_VIEWS.

    ``size``: (width, height) of the frames. ``least``: the difference between any two of them.
    """
    if not views:
        return []
    kinds = np.array([view.describe(size) for view in views])
    chosen = [0]
    away = np.linalg.norm(kinds - kinds[0], axis=1)
    while len(chosen) < min(MAX_VIEWS, len(views)):
        farthest = int(np.argmax(away))
        if away[farthest] < least:
            break
        chosen.append(farthest)
        away = np.minimum(away, np.linalg.norm(kinds - kinds[farthest], axis=1))
    return [views[number] for number in sorted(chosen)]


def cells_of(views: Sequence[View], size: tuple[int, int]) -> Booleans:
    """CELLS of bool: the cells of the frame in which a point was seen."""
    seen = np.zeros(CELLS, bool)
    for view in views:
        points = np.concatenate(list(view.points.values())) / np.array(size) * CELLS
        cells = np.clip(points.astype(int), 0, np.array(CELLS) - 1)
        seen[cells[:, 0], cells[:, 1]] = True
    return seen
