"""The wall with tags that the simulated camera looks at: its YAML file and its geometry.

Wall coordinates are meters: x to the right and y up for who looks at the
wall, z out of it towards them; the origin is on the floor in the middle.
"""
from __future__ import annotations

import os
from dataclasses import dataclass
from math import cos, radians, sin
from typing import Any

import numpy as np

from aruco_ar.base.arrays import Color, Floats, Image, Numbers
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import within, yaml_entries
from aruco_ar.tags.tag import SIDE_M, tag_cells

DICTIONARY = 'DICT_6X6_250'


@dataclass(frozen=True)
class WallTag:
    """A tag on the wall: its center and side in meters, turned clockwise by degrees."""

    id: int
    x: float
    y: float
    side: float
    turn: float = 0.0

    def on_wall(self, across: Numbers, down: Numbers) -> Floats:
        """Wall points, (..., 3) float64, of places on the tag.

        ``across`` and ``down`` run from -0.5 to 0.5 over the tag's own side,
        (-0.5, -0.5) being its own top left.
        """
        turn = radians(self.turn)
        right, foot = self.side * np.asarray(across), self.side * np.asarray(down)
        return np.stack([self.x + cos(turn) * right - sin(turn) * foot,
                         self.y - sin(turn) * right - cos(turn) * foot,
                         np.zeros(np.shape(right))], axis=-1)

    @property
    def corners(self) -> Floats:
        """(4, 3) float64, wall meters, clockwise from the tag's own top left."""
        return self.on_wall([-.5, .5, .5, -.5], [-.5, -.5, .5, .5])


@dataclass(frozen=True)
class Poster:
    """A picture on the wall: the path of its file, and its middle and its size in meters."""

    image: str
    x: float
    y: float
    width: float
    height: float

    @property
    def corners(self) -> Floats:
        """(4, 3) float64, wall meters, clockwise from the picture's top left."""
        right, up = self.width / 2, self.height / 2
        return np.array([[self.x - right, self.y + up, 0], [self.x + right, self.y + up, 0],
                         [self.x + right, self.y - up, 0], [self.x - right, self.y - up, 0]])


@dataclass(frozen=True)
class Wall:
    """What a wall's YAML file says. ``color`` is (blue, green, red). ``area``: four ids, or none.

    ``plaster``: how strong the pattern of the wall itself is, 0 for none.
    ``posters``: what hangs behind the tags, the first of them farthest behind.
    """

    width: float
    height: float
    color: Color
    dictionary: str
    quiet: float
    tags: tuple[WallTag, ...]
    area: tuple[int, ...]
    plaster: float = 1.0
    posters: tuple[Poster, ...] = ()

    @property
    def area_corners(self) -> Floats:
        """(4, 3) float64, wall meters: the centers of the area's tags, in its order; (0, 3) without one."""
        by_id = {tag.id: tag for tag in self.tags}
        return np.array([[by_id[id].x, by_id[id].y, 0.0] for id in self.area]).reshape(-1, 3)

    @property
    def parts(self) -> int:
        """Into how many parts the side of a tag's cell is divided on its paper: quiet is rounded to them."""
        return 1 if self.quiet == int(self.quiet) else 16

    def paper(self, tag: WallTag) -> tuple[Image, Floats]:
        """A tag's cells on its white paper, and where the paper's corners are.

        The cells are (n, n) uint8, 0 black and 255 white, and there are several
        for each of the tag's own where its rim is no whole number of them wide
        (see ``parts``); the corners (4, 3) float64, wall meters, clockwise from
        the tag's own top left.
        """
        cells = tag_cells(self.dictionary, tag.id).repeat(self.parts, 0).repeat(self.parts, 1)
        paper = np.pad(cells, round(self.quiet * self.parts), constant_values=255)
        reach = 0.5 * len(paper) / len(cells)
        return paper, tag.on_wall([-reach, reach, reach, -reach], [-reach, -reach, reach, reach])


def load_wall(path: str) -> Wall:
    """Read a Wall from its YAML file (config/wall.yaml shows all there is).

    Raises InputError naming the file and the entry that is wrong.
    """
    with yaml_entries(path) as data:
        tags = tuple(WallTag(_id(entry['id']), within(entry['x'], -100, 100), within(entry['y'], -100, 100),
                             within(entry['side'], *SIDE_M), within(entry.get('turn', 0), -360, 360))
                     for entry in data['tags'])
        look, first_four = data.get('wall', {}), [tag.id for tag in tags[:4]] if len(tags) > 3 else []
        width, height = within(look.get('width', 8), 0.1, 100), within(look.get('height', 2.6), 0.1, 100)
        posters = [_poster(entry, path) for entry in data.get('posters', [])]
        if 'image' in look:
            posters.insert(0, Poster(_beside(path, look['image']), 0, height / 2, width, height))
        wall = Wall(width, height, _color(look.get('color', (214, 203, 186))),
                    str(data.get('dictionary', DICTIONARY)), within(data.get('quiet', 1), 0, 10), tags,
                    tuple(_id(id) for id in data.get('area', first_four)),
                    within(look.get('plaster', 1), 0, 10), tuple(posters))
        for tag in tags:
            tag_cells(wall.dictionary, tag.id)
    ids = [tag.id for tag in wall.tags]
    if not ids or len(ids) > len(set(ids)):
        raise InputError('The wall "%s" has the tags %s; give at least one, and each id once.' % (path, ids))
    if wall.area and not (len(wall.area) == len(set(wall.area)) == 4 and set(wall.area) <= set(ids)):
        raise InputError('The area of the wall "%s" is %s; give the ids of four different tags of it.'
                         % (path, list(wall.area)))
    return wall


def _poster(entry: Any, path: str) -> Poster:
    return Poster(_beside(path, entry['image']), within(entry['x'], -100, 100), within(entry['y'], -100, 100),
                  within(entry['width'], 0.01, 100), within(entry['height'], 0.01, 100))


def _beside(path: str, image: Any) -> str:
    """The path of an image that a wall's file names: as it stands there, or from the folder of that file."""
    return os.path.join(os.path.dirname(path), os.path.expanduser(str(image)))


def _color(value: Any) -> Color:
    red, green, blue = (within(part, 0, 255) for part in value)
    return blue, green, red


def _id(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError('%s is no id' % (value,))
    return value
