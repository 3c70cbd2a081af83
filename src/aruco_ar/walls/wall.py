"""A wall with tags: its YAML file and its geometry.

Wall coordinates are meters. For a viewer in front of the wall, x points to the
right, y up, and z out of the wall toward the viewer. The origin is on the
floor, in the middle of the wall.
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
    """A tag on the wall: its center and its side, meters, and by how many degrees it is turned clockwise."""

    id: int
    x: float
    y: float
    side: float
    turn: float = 0.0

    def on_wall(self, across: Numbers, down: Numbers) -> Floats:
        """Wall points, (..., 3) float64, of points on the tag.

        ``across`` and ``down``: coordinates on the tag, from -0.5 to 0.5. The
        tag's own top left is at (-0.5, -0.5).
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
    """A picture on the wall: the path of its file, and its middle and its size, meters."""

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
    """The content of a wall's YAML file.

    ``width``, ``height``: meters. ``color``: (blue, green, red). ``quiet``:
    the width of the white margin around each tag, in cells. ``area``: the ids
    of the four tags of the area, or none. ``plaster``: the strength of the
    wall's own pattern, 0 for none. ``posters``: the pictures behind the tags;
    later ones cover earlier ones.
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
        """(4, 3) float64, wall meters: the centers of the area's tags, in its order; (0, 3) without an area."""
        by_id = {tag.id: tag for tag in self.tags}
        return np.array([[by_id[id].x, by_id[id].y, 0.0] for id in self.area]).reshape(-1, 3)

    @property
    def paper_scale(self) -> int:
        """How many pixels of ``paper`` each cell of a tag is wide: the margin is rounded to whole pixels."""
        return 1 if self.quiet == int(self.quiet) else 16

    def paper(self, tag: WallTag) -> tuple[Image, Floats]:
        """A tag with its white margin as an image, and the corners of this paper.

        The image is (n, n) uint8, 0 black and 255 white, with ``paper_scale``
        pixels for the width of a cell. The corners are (4, 3) float64, wall
        meters, clockwise from the tag's own top left.
        """
        cells = tag_cells(self.dictionary, tag.id).repeat(self.paper_scale, 0).repeat(self.paper_scale, 1)
        paper = np.pad(cells, round(self.quiet * self.paper_scale), constant_values=255)
        reach = 0.5 * len(paper) / len(cells)
        return paper, tag.on_wall([-reach, reach, reach, -reach], [-reach, -reach, reach, reach])


def load_wall(path: str) -> Wall:
    """Read a Wall from its YAML file; config/wall.yaml shows all entries.

    Raises InputError, which names the file and the wrong entry.
    """
    with yaml_entries(path) as data:
        tags = tuple(WallTag(_id(entry['id']), within(entry['x'], -100, 100), within(entry['y'], -100, 100),
                             within(entry['side'], *SIDE_M), within(entry.get('turn', 0), -360, 360))
                     for entry in data['tags'])
        surface, first_four = data.get('wall', {}), [tag.id for tag in tags[:4]] if len(tags) > 3 else []
        width, height = within(surface.get('width', 8), 0.1, 100), within(surface.get('height', 2.6), 0.1, 100)
        posters = [_poster(entry, path) for entry in data.get('posters', [])]
        if 'image' in surface:
            posters.insert(0, Poster(_image_path(path, surface['image']), 0, height / 2, width, height))
        wall = Wall(width, height, _color(surface.get('color', (214, 203, 186))),
                    str(data.get('dictionary', DICTIONARY)), within(data.get('quiet', 1), 0, 10), tags,
                    tuple(_id(id) for id in data.get('area', first_four)),
                    within(surface.get('plaster', 1), 0, 10), tuple(posters))
        for tag in tags:
            tag_cells(wall.dictionary, tag.id)
    ids = [tag.id for tag in wall.tags]
    if not ids or len(ids) > len(set(ids)):
        raise InputError('The wall "%s" has the tags %s; give at least one tag, and each id only once.'
                         % (path, ids))
    if wall.area and not (len(wall.area) == len(set(wall.area)) == 4 and set(wall.area) <= set(ids)):
        raise InputError('The area of the wall "%s" is %s; give the ids of four different tags on the wall.'
                         % (path, list(wall.area)))
    return wall


def _poster(entry: Any, path: str) -> Poster:
    return Poster(_image_path(path, entry['image']),
                  within(entry['x'], -100, 100), within(entry['y'], -100, 100),
                  within(entry['width'], 0.01, 100), within(entry['height'], 0.01, 100))


def _image_path(path: str, image: Any) -> str:
    """The path of an image that the wall's file at ``path`` names; it may be relative to that file's folder."""
    return os.path.join(os.path.dirname(path), os.path.expanduser(str(image)))


def _color(value: Any) -> Color:
    red, green, blue = (within(part, 0, 255) for part in value)
    return blue, green, red


def _id(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError('%s is not an id' % (value,))
    return value
