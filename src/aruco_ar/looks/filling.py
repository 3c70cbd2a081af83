"""What is inside of a ring of colors, if it goes on evenly."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Floats

from .ring import COUNT, DARK, points_of_sides

DIRECTIONS = 16       # in which the edge of a shadow is searched
LINE_WIDTH = 0.04     # standard deviation across a line of equal color, in lengths of a side
# Such lines are trusted if they leave the first of these shares of the colors' variance, not if the second.
EXPLAINED, UNEXPLAINED = 0.15, 0.5
PLAIN, SHADED = 0.04, 0.07  # by such shares, colors vary without an edge, and where there may be one


def filled(colors: Floats) -> Floats:
    """(n, COUNT, COUNT, 4) float32, BGRA: what is inside of n rings of colors, (n, 4 * COUNT, 3); see Rings.

    The edge of a shadow is nearly straight. So if straight lines of equal color in one direction explain most
    of the change along the ring, these lines go on inside. The rest is like a soap film.
    """
    count = len(colors)
    mean = colors.mean(axis=1)
    variance = np.mean((colors - mean[:, None])**2, axis=(1, 2))
    shaded = np.interp(np.sqrt(variance) / (mean.mean(axis=1) + DARK), (PLAIN, SHADED), (0, 1))
    side_by_side = colors.swapaxes(0, 1).reshape(4 * COUNT, -1)
    fill = (FILM @ side_by_side).reshape(COUNT**2, count, 3).swapaxes(0, 1)
    for number in np.flatnonzero(shaded):
        along = (LINES_ON_RING.reshape(-1, 4 * COUNT) @ colors[number]).reshape(DIRECTIONS, 4 * COUNT, 3)
        off = (along - colors[number]).reshape(DIRECTIONS, -1)
        rest = np.einsum('dn,dn->d', off, off) / off.shape[1]
        best = int(np.argmin(rest))
        share = shaded[number] * np.interp(rest[best] / variance[number], (EXPLAINED, UNEXPLAINED), (1, 0))
        if share:
            fill[number] += share * (LINES_INSIDE[best] @ colors[number] - FILM @ along[best])
    covers = np.full((count, COUNT, COUNT, 4), 255, np.float32)
    covers[..., :3] = fill.reshape(count, COUNT, COUNT, 3)
    return covers


def _film() -> Floats:
    """(COUNT**2, 4 * COUNT): the share of each color of a ring in each pixel inside, as in a soap film.

    Each pixel is the mean of its four neighbors, by Laplace's equation. Beyond the rim, these are the ring.
    """
    number = np.arange(COUNT**2).reshape(COUNT, COUNT)
    inner, rim = 4 * np.eye(COUNT**2), np.zeros((COUNT**2, 4 * COUNT))
    for one, other in ((number[1:], number[:-1]), (number[:, 1:], number[:, :-1])):
        inner[one.ravel(), other.ravel()] = inner[other.ravel(), one.ravel()] = -1
    for side, pixels in enumerate((number[0], number[:, -1], number[-1, ::-1], number[::-1, 0])):
        rim[pixels, side * COUNT + np.arange(COUNT)] = 1
    return np.linalg.solve(inner, rim)


def _lines() -> tuple[Floats, Floats]:
    """The share of each color of a ring in the line of equal color through each place, for each direction.

    (DIRECTIONS, 4 * COUNT, 4 * COUNT) for the places on the ring, and (DIRECTIONS, COUNT**2, 4 * COUNT) for
    those inside.
    """
    angles = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    across = np.column_stack([np.cos(angles), np.sin(angles)])
    y, x = (np.indices((COUNT, COUNT)).reshape(2, -1) + 0.5) / COUNT
    ring = across @ points_of_sides(COUNT).reshape(-1, 2).T
    on_ring, inside = (np.exp(-0.5 * ((places[:, :, None] - ring[:, None]) / LINE_WIDTH)**2)
                       for places in (ring, across @ np.stack([x, y])))
    return on_ring / on_ring.sum(axis=2, keepdims=True), inside / inside.sum(axis=2, keepdims=True)


FILM = _film()
LINES_ON_RING, LINES_INSIDE = _lines()
