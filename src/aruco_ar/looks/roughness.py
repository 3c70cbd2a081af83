"""The roughness of the ground beside a tag, which is put under it: its texture, and the camera's noise."""
from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image, Integers
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import transform
from aruco_ar.geometry.lens import Lens

# A tag is divided into tiles. Around them is a ring of such tiles, the sources. Each tile gets what is not
# smooth in one of these.
FEWEST, MOST = 4, 16  # number of tiles in each row and column
SMALLEST_PX = 3.0     # smaller sources show nothing but the blur of what is around them
NEAREST_PX = 2.0      # blur is assumed to reach so far, at least
# The sources begin beyond the blur by this factor. All stay where they are as long as the blur is less, now and
# in the mean, than their distance times these factors, and more than it times the last one.
BEYOND, NOW, LESS, MORE = 1.3, 2.0, 1.0, 0.4
# So they do if they are as large as the ground beside the tag is deep, times factors between these.
SMALL, LARGE = 0.5, 1.15
MEAN_OF = 15          # blur, depth, and roughness are running means of about this many frames
STAYS_PX = 0.8        # a shift stays as long as it is off by less: else detection's noise would move textures
NEAR = 0.5            # how much the order of the sources is mixed, in widths of the whole: near ones come first


class Tiles(NamedTuple):
    """Roughness to put under a tag.

    ``to_tiles``: (3, 3), from undistorted pixels to the square from 0 to n. ``shifts``: (n, n, 2) int32,
    pixels, from each tile to its source. ``smooth``: (n, n, 3, 4) float32, the smooth part of that source: its
    color, BGR and 0, and what is added to this per tile to the right and down.
    """

    to_tiles: Floats
    shifts: Integers
    smooth: Floats


NO_SHIFTS: Integers = np.zeros((0, 2), np.int32)
SMOOTH = Tiles(np.eye(3), NO_SHIFTS.reshape(0, 0, 2), np.zeros((0, 0, 3, 4), np.float32))  # no roughness


class Roughness:
    """Finds the roughness of the ground beside a tag, in each frame anew, but in steady places.

    So the texture of the ground stays where it is, and the noise changes as it does beside the tag.
    """

    def __init__(self) -> None:
        self._blur = self._depth = self._distance = 0.0  # in sides of the tag
        self._count, self._frames, self._frames_so = 0, 0, 0
        self._usual: Floats = np.zeros((0, 4), np.float32)  # the colors and the roughness of the sources
        self._shifts = NO_SHIFTS  # those of this layout

    def tiles(self, frame: Image, lens: Lens | None, outline: Floats, homography: Floats, blur_px: float,
              depth_px: float, seen: bool) -> Tiles:
        """The Tiles to put under a tag or its paper; SMOOTH if the ground is, or too little of it can be seen.

        ``frame``: (h, w, 3) BGR uint8. ``lens``: that of the frame, or None. ``outline``: (4, 2) undistorted
        pixels. ``homography``: (3, 3), to it from the unit square. ``blur_px``, ``depth_px``: how far out from
        it the blur reaches, and the ground: see Rings. ``seen``: whether the tag is in sight. If not, something
        is in front, and nothing is learned.
        """
        side = float(np.sqrt(cv2.contourArea(np.asarray(outline, np.float32))))
        if seen or not self._count:
            self._lay_out(max(blur_px, NEAREST_PX) / side, depth_px / side)
        count, size = self._count, self._size()
        if count > MOST or side * size < SMALLEST_PX:
            return SMOOTH
        from_tiles = homography @ np.array([[size, 0, -self._distance], [0, size, -self._distance], [0, 0, 1]])
        layout = _layout(count)
        points = transform(from_tiles, layout.points)
        if lens is not None:
            points = lens.distort(points)
        tiles, sources = points[:count**2], points[count**2:].reshape(-1, 3, 2)
        if self._frames_so == 1:
            self._usual = np.zeros((len(sources), 4), np.float32)
        if self._shifts is NO_SHIFTS:
            self._shifts = np.full((count**2, 2), np.iinfo(np.int32).min, np.int32)  # of these, none stays
        smooth = binding.choose_sources(frame, tiles, sources, self._frames_so, seen, self._usual, layout.order,
                                        STAYS_PX, self._shifts)
        if smooth is None:
            return SMOOTH
        return Tiles(np.linalg.inv(from_tiles), self._shifts.reshape(count, count, 2),
                     smooth.reshape(count, count, 3, 4))

    def _lay_out(self, blur: float, depth: float) -> None:
        """Choose how many tiles there are, and where the sources begin. All lengths are in sides of the tag."""
        self._frames, self._frames_so = min(self._frames + 1, MEAN_OF), min(self._frames_so + 1, MEAN_OF)
        self._blur += (blur - self._blur) / self._frames
        self._depth += (depth - self._depth) / self._frames
        room = (self._depth - self._distance) / (1 + binding.SEAM)
        if (self._count and blur < NOW * self._distance and SMALL * room < self._size() < LARGE * room
                and MORE * self._distance < self._blur < LESS * self._distance):
            return
        self._distance = BEYOND * (max(blur, self._blur) if blur > NOW * self._distance else self._blur)
        room = (self._depth - self._distance) / (1 + binding.SEAM)
        self._count = max(int(np.ceil((1 + 2 * self._distance) / max(room, 1e-3))), FEWEST)
        self._frames_so, self._shifts = 1, NO_SHIFTS

    def _size(self) -> float:
        """The size of a tile, in sides of the tag."""
        return (1 + 2 * self._distance) / self._count


class _Layout(NamedTuple):
    """How n rows and columns of tiles, and the m sources around them, are laid out.

    ``points``: (n * n + 3 * m, 2), in tiles: the middles of the tiles, and then of each source its middle, and
    the places one tile right of it and below. ``order``: (n * n, m) float32, the usable source with the least
    of these is taken for a tile.
    """

    points: Floats
    order: Floats


@lru_cache(maxsize=None)
def _layout(count: int) -> _Layout:
    """The _Layout of tiles in ``count`` rows and columns."""
    tiles, around = (np.column_stack([image.ravel() for image in np.indices((rows, rows))[::-1]])
                     for rows in (count, count + 2))
    tiles = tiles + 0.5
    sources = around[np.any((around == 0) | (around == count + 1), axis=1)] - 0.5
    sources += binding.SEAM / 2 * ((sources > count).astype(float) - (sources < 0))
    axes = sources[:, None] + [[0, 0], [1, 0], [0, 1]]
    random = np.random.RandomState(count)
    away = np.linalg.norm(tiles[:, None] - sources, axis=2) / count
    order = away + NEAR * random.uniform(size=away.shape)
    # Each source is taken about equally often, if all are usable.
    taken = np.zeros(len(sources))
    for tile in random.permutation(len(tiles)):
        first = int(np.argmin(order[tile] + taken))
        taken[first] += NEAR
        order[tile, first] = -1
    return _Layout(np.concatenate([tiles, axes.reshape(-1, 2)]), order.astype(np.float32))
