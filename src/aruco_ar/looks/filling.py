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
    if shaded.any():
        off = (OFF_LINES @ side_by_side).reshape(DIRECTIONS, 4 * COUNT, count, 3)
        rest = np.mean(off * off, axis=(1, 3))
        best = rest.argmin(axis=0)
        explained = np.interp(rest.min(axis=0) / np.maximum(variance, 1e-9), (EXPLAINED, UNEXPLAINED), (1, 0))
        for number in np.flatnonzero(shaded * explained):
            fill[number] += shaded[number] * explained[number] * (LINES[best[number]] @ colors[number])
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
    """How each color of a ring counts if lines of equal color go on, for each direction.

    (DIRECTIONS * 4 * COUNT, 4 * COUNT): in the difference between the line through each place on the ring and
    the color there. (DIRECTIONS, COUNT**2, 4 * COUNT): in what is to be added to the soap film in each pixel
    inside, so that the lines go on there, and the film shows what remains.
    """
    angles = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    across = np.column_stack([np.cos(angles), np.sin(angles)])
    y, x = (np.indices((COUNT, COUNT)).reshape(2, -1) + 0.5) / COUNT
    ring = across @ points_of_sides(COUNT).reshape(-1, 2).T
    on_ring, inside = (np.exp(-0.5 * ((places[:, :, None] - ring[:, None]) / LINE_WIDTH)**2)
                       for places in (ring, across @ np.stack([x, y])))
    on_ring, inside = (lines / lines.sum(axis=2, keepdims=True) for lines in (on_ring, inside))
    return (on_ring - np.eye(4 * COUNT)).reshape(-1, 4 * COUNT), inside - FILM @ on_ring


FILM = _film()
OFF_LINES, LINES = _lines()
