"""The roughness of the ground beside a tag, which is put under it: its texture, and the camera's noise."""
from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.geometry.lens import Lens

from .ring import DARK, middle

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
ACROSS = 6            # a source is judged by so many pixels across and down
# This share of the sources is calm. Those whose roughness differs from theirs by more than this share, and so
# many gray levels, show the edges of other things, or a smooth thing.
CALM, ROUGHER, LEVELS = 0.25, 0.6, 1.0
INVISIBLE = 0.6       # ground with less roughness than this, gray levels, is smooth
# Sources whose color or roughness differs from the usual one by more than this share, besides what light does
# to all of them, show something in front. If fewer than this share remain, the ground itself has changed.
CHANGED, CHANGED_ROUGH, SAME = 0.1, 0.4, 0.3
FEW = 4               # with fewer sources than this, the tag's place stays smooth
NEAR = 0.5            # how much the order of the sources is mixed, in widths of the whole: near ones come first


class Tiles(NamedTuple):
    """Roughness to put under a tag, from a frame, (h, w, 3) BGR uint8.

    ``to_tiles``: (3, 3), from undistorted pixels to the square from 0 to n. ``shifts``: (n, n, 2) int32,
    pixels, from each tile to its source. ``smooth``: (n, n, 3, 3), the smooth part of that source: its color,
    and what is added to this per tile to the right and down.
    """

    frame: Image
    to_tiles: Floats
    shifts: Integers
    smooth: Floats

    def add_to(self, warped: Image, begin: Integers, positions: Image | None) -> None:
        """Add the roughness to a part of an image, (h, w, 3) or (h, w, 4) uint8. This changes it.

        ``begin``: x and y of the part in the frame. ``positions``: see Place.
        """
        to_tiles, (x, y) = self.to_tiles, begin.tolist()
        if positions is None:
            to_tiles = to_tiles @ np.array([[1, 0, x], [0, 1, y], [0, 0, 1.0]])
        binding.add_roughness(warped, positions, (x, y), self.frame, to_tiles, self.shifts, self.smooth)


class Roughness:
    """Finds the roughness of the ground beside a tag, in each frame anew, but in steady places.

    So the texture of the ground stays where it is, and the noise changes as it does beside the tag.
    """

    def __init__(self) -> None:
        self._blur = self._depth = self._distance = 0.0  # in sides of the tag
        self._count, self._frames, self._frames_so = 0, 0, 0
        self._rough = self._colors = np.zeros(0)
        self._shifts: Integers | None = None  # those of this layout, if any are known yet

    def tiles(self, frame: Image, lens: Lens | None, outline: Floats, blur_px: float,
              depth_px: float, seen: bool) -> Tiles | None:
        """The Tiles to put under a tag or its paper, or None if too little of the ground can be seen.

        ``frame``: (h, w, 3) BGR uint8. ``lens``: that of the frame, or None. ``outline``: (4, 2) undistorted
        pixels. ``blur_px``, ``depth_px``: how far out from it the blur reaches, and the ground: see Rings.
        ``seen``: whether the tag is in sight. If not, something is in front, and nothing is learned.
        """
        side = float(np.sqrt(cv2.contourArea(np.asarray(outline, np.float32))))
        if seen or not self._count:
            self._lay_out(max(blur_px, NEAREST_PX) / side, depth_px / side)
        count, size = self._count, self._size()
        if count > MOST or side * size < SMALLEST_PX:
            return None
        from_tiles = homography_to(outline) @ np.array([[size, 0, -self._distance], [0, size, -self._distance],
                                                        [0, 0, 1]])
        layout = _layout(count)
        points = transform(from_tiles, layout.points)
        if lens is not None:
            points = lens.distort(points)
        tiles, sources, samples = points[:count**2], points[count**2:-layout.samples], points[-layout.samples:]
        x, y = np.round(samples).astype(int).T
        height, width = frame.shape[:2]
        shown = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        colors = frame[np.where(shown, y, 0), np.where(shown, x, 0)].astype(np.float32).reshape(ACROSS**2, -1)
        planes = FIT @ colors
        rest = colors - PLACES @ planes
        rough = np.sqrt((rest * rest).sum(axis=0).reshape(-1, 3).sum(axis=1) / FREE)
        usable = self._usable(rough, planes[0].reshape(-1, 3), shown.reshape(ACROSS**2, -1).all(axis=0), seen)
        if usable.sum() < FEW:
            return None
        chosen = np.where(usable, layout.order, np.inf).argmin(axis=1)
        shifts = sources[chosen] - tiles
        if self._shifts is not None:
            stay = np.all(np.abs(shifts - self._shifts) < STAYS_PX, axis=1, keepdims=True)
            shifts = np.where(stay, self._shifts, shifts)
        self._shifts = np.round(shifts).astype(np.int32)
        return Tiles(frame, np.linalg.inv(from_tiles), self._shifts.reshape(count, count, 2),
                     planes.reshape(3, -1, 3)[:, chosen].swapaxes(0, 1).reshape(count, count, 3, 3))

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
        self._frames_so, self._shifts = 1, None

    def _size(self) -> float:
        """The size of a tile, in sides of the tag."""
        return (1 + 2 * self._distance) / self._count

    def _usable(self, rough: Floats, colors: Floats, shown: Booleans, seen: bool) -> Booleans:
        """(m,), which sources show rough ground. ``rough``: (m,), and ``colors``: (m, 3), their means.

        ``shown``: (m,), those in the frame. ``seen``: whether the tag is in sight.
        """
        if self._frames_so == 1:
            self._rough, self._colors = rough, colors
        if shown.sum() < FEW:
            return shown
        change = (colors + DARK) / (self._colors + DARK)
        same = np.abs(change / middle(change[shown]) - 1).max(axis=1) < CHANGED
        same &= np.abs(rough - self._rough) < CHANGED_ROUGH * self._rough + LEVELS
        if seen:
            rate = (same | (same.mean() < SAME)) / self._frames_so
            self._colors = self._colors + rate[:, None] * (colors - self._colors)
            self._rough = self._rough + rate * (rough - self._rough)
        usual = middle(self._rough[shown], share=CALM)
        return shown & same & (usual > INVISIBLE) & (np.abs(self._rough - usual) <= ROUGHER * usual + LEVELS)


class _Layout(NamedTuple):
    """How n rows and columns of tiles, and the m sources around them, are laid out.

    ``points``: (k, 2), in tiles: the middles of the tiles and of the sources, and the samples of these, one
    after the other. ``samples``: the number of these. ``order``: (n * n, m), the usable source with the least
    of these is taken for a tile.
    """

    points: Floats
    samples: int
    order: Floats


@lru_cache(maxsize=None)
def _layout(count: int) -> _Layout:
    """The _Layout of tiles in ``count`` rows and columns."""
    tiles, around = (np.column_stack([image.ravel() for image in np.indices((rows, rows))[::-1]])
                     for rows in (count, count + 2))
    tiles = tiles + 0.5
    sources = around[np.any((around == 0) | (around == count + 1), axis=1)] - 0.5
    sources += binding.SEAM / 2 * ((sources > count).astype(float) - (sources < 0))
    samples = (sources + PLACES[:, None, 1:]).reshape(-1, 2)
    random = np.random.RandomState(count)
    away = np.linalg.norm(tiles[:, None] - sources, axis=2) / count
    order = away + NEAR * random.uniform(size=away.shape)
    # Each source is taken about equally often, if all are usable.
    taken = np.zeros(len(sources))
    for tile in random.permutation(len(tiles)):
        first = int(np.argmin(order[tile] + taken))
        taken[first] += NEAR
        order[tile, first] = -1
    return _Layout(np.concatenate([tiles, sources, samples]), len(samples), order)


def _places() -> Floats:
    """(ACROSS**2, 3): 1, and the samples of a source and its seams, in tiles from its middle, x and y."""
    y, x = (1 + binding.SEAM) * (np.indices((ACROSS, ACROSS)).reshape(2, -1) / (ACROSS - 1) - 0.5)
    return np.column_stack([np.ones(len(x)), x, y]).astype(np.float32)


PLACES = _places()
FIT = np.linalg.pinv(PLACES)    # from the colors of the samples to the plane that fits them best
FREE = 3 * (ACROSS**2 - 3)      # so many numbers of a source tell how rough it is
