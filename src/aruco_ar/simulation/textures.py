"""The textures of the simulated wall: its plaster, and the papers and posters on it."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.walls.wall import Wall

TAG_CELL_TEXELS = 32  # resolution of a tag's texture, which is halved repeatedly for far views
WALL_TEXELS_M = 160   # texels per meter of the wall's texture, enough for its soft pattern


class Textures:
    """The textures of a Wall. ``light``: how much darker the wall's right end is than its left, 0 to 1."""

    def __init__(self, wall: Wall, light: float) -> None:
        self._wall, self._light = wall, light

    def plaster(self, random: np.random.RandomState) -> Image:
        """The wall's texture, (h, w, 3) uint8: its color, a soft pattern of plaster, and a skirting board."""
        shape = int(self._wall.height * WALL_TEXELS_M), int(self._wall.width * WALL_TEXELS_M)
        plaster = np.zeros(shape)
        for grain, depth in (64, 5), (16, 4), (5, 3):
            strength = depth * self._wall.plaster
            coarse = random.normal(0, strength, (shape[0] // grain + 2, shape[1] // grain + 2))
            plaster += cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC)
        board = int(0.06 * WALL_TEXELS_M)
        plaster[-board:] = 25
        x = (np.arange(shape[1]) + 0.5) / WALL_TEXELS_M - self._wall.width / 2
        color = (np.array(self._wall.color) + plaster[:, :, None]) * self._light_at(x)[:, None]
        return np.clip(color, 0, 255).astype(np.uint8)

    def paper(self, cells: Image, corners: Floats) -> list[Image]:
        """The pyramid of a tag on its paper: images, (n, n) uint8. ``cells``, ``corners``: see Wall.paper."""
        texels = TAG_CELL_TEXELS // self._wall.paper_scale
        texture = cells.repeat(texels, 0).repeat(texels, 1)
        place = (np.arange(len(texture)) + 0.5) / len(texture)
        left, right, _, foot = corners[:, 0]
        x = left + (right - left) * place + (foot - left) * place[:, None]
        lit = (as_printed(texture) * self._light_at(x)).astype(np.uint8)
        return _pyramid(lit, 2 * len(cells) / self._wall.paper_scale)  # down to two texels per cell

    def poster(self, picture: Image | Floats, corners: Floats) -> list[Image]:
        """The pyramid of a picture, (h, w, 3 or 4) BGR: images, (h, w, 3). ``corners``: those on the wall."""
        (left, right), width = corners[:2, 0], picture.shape[1]
        x = left + (right - left) * (np.arange(width) + 0.5) / width
        return _pyramid((picture[:, :, :3] * self._light_at(x)[None, :, None]).astype(np.uint8), 8)

    def _light_at(self, x: Floats) -> Floats:
        return 1 - self._light * np.clip(x / self._wall.width + 0.5, 0, 1)


def as_printed(picture: Image) -> Floats:
    """What a picture, uint8, looks like on paper: paper is not perfectly white, and ink not perfectly black."""
    return 20 + picture * (225 / 255)


def _pyramid(texture: Image, least: float) -> list[Image]:
    """An image and smaller ones, each half the one before, until a side is at most ``least`` pixels."""
    pyramid = [texture]
    while min(pyramid[-1].shape[:2]) > least:
        pyramid.append(cv2.resize(pyramid[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
    return pyramid
