"""Hiding the tags: each is covered with what the wall around it looks like."""
from __future__ import annotations

from typing import Callable, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.geometry.homography import homography_from, homography_to, transform
from aruco_ar.painting.paint import paint
from aruco_ar.painting.picture import Picture
from aruco_ar.painting.place import find_place
from aruco_ar.tags.corner_rays import straight_corners
from aruco_ar.tags.tag import Tag
from aruco_ar.tracking.area import Area

from .difference import DARKEST, LIGHTEST, difference, largest_difference, soft_rim
from .parts import components, grown, parts_of

SIZE = 64, 64          # size of a patch, which shows the wall straight from the front, in pixels
SCALE = 2.5            # width of the wall in a patch, in sides of its tag
# A tag that moves farther than this is not fixed to the wall. It is a share of the tag's side.
SAME_PLACE = 0.1
PLACE_OF = 30          # a tag's place is the running mean of about this many frames
MEAN_OF = 60           # the wall's look is the running mean of about this many frames
ALIKE = 0.15           # colors are alike if they differ by less than this share of their brightness
INPAINT_AFTER = 1, 4, 16, 64  # numbers of learned frames after which a patch is inpainted
# If more than this share of a patch turned out not to be the wall, it is inpainted again, but not within this
# number of learned frames.
REPLACED, AGAIN_AFTER = 0.01, 8
EVERY = 2, 4           # light is measured in every second frame, and a known wall is learned in every fourth
KNOWN_AFTER = 16       # number of learned frames after which a wall is known
INPAINT_PX = 3
SMOOTHINGS, SMOOTH_PX = 20, 15
PAPER_SCALE = 1.15     # outer width of the ring that shows the color of the tag's paper, in sides of the tag
PAPER_LEVELS = 0.1     # the paper's color varies by less than this share of it
REACH_PX = 4           # paper that reaches this near to the patch's rim has no end in sight
MARGIN_PX = 7          # the filled part is wider than the paper by half of this on each side: its rim is soft
BARE_SCALE = 1.25      # least width of the filled part, in sides of the tag, whatever paper is found
SOFT_PX = 5            # width of the soft rim of the filled part
CELLS = 8              # number of cells along each side of a patch; the light is measured in each
MIN_COVER = 0.1        # share of a cell that must show the wall around the tag
SAME_COLOR = 0.15      # light changes a color by less than this share of its brightness
ENOUGH = 0.1           # share of the wall around a tag that must show the light
ANOTHER_AFTER = 15     # after this many frames in which less of it shows the light, it is another wall
VARIANCE = 4.0         # assumed variance of the noise
DARK = 40.0            # ALIKE takes darker colors to have this brightness, in gray levels

MEAN = np.full((1, 3), 1 / 3, np.float32)  # of the channels
SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
PATCH = (SQUARE - 0.5) * SCALE + 0.5  # (4, 2): the corners of a patch; those of its tag are the unit square


class HiddenTags:
    """Covers the tags of a wall.

    Each tag's place is inpainted from the wall around it, and again as the average improves.
    """

    def __init__(self) -> None:
        self._patches: dict[int, _Patch] = {}

    def reset(self) -> None:
        """Forget the wall."""
        self._patches.clear()

    def hide(self, frame: Image, image: Image, area: Area, tags: Sequence[Tag], is_located: bool,
             keep: bool, noisy: Callable[[Image], Image] | None = None) -> None:
        """Cover the tags in an image. This changes it.

        ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``image``: what to paint on, of the same size; it
        may be the frame itself. ``area``: the Area in the frame. ``tags``: those in sight.
        ``is_located``: whether the frame shows where the area is. If not, nothing is learned from it. ``keep``:
        whether things that stand in front of the wall stay there. ``noisy``: adds the camera's noise to an
        image, if given.
        """
        if is_located:
            self._find(area, tags)
        seen = {tag.id for tag in tags} if is_located else set()
        squares = [patch.place for patch in self._patches.values()]
        covers, from_area = [], homography_to(area.undistorted)
        for tag_id, patch in self._patches.items():
            to_frame = from_area @ homography_to(patch.place)
            around = Area.from_undistorted(transform(to_frame, PATCH), lens=area.lens)
            if around.window(frame)[0].size:
                if patch.is_turn(keep):
                    patch.update(around.rectified(frame, SIZE), around.in_frame(frame, SIZE), squares,
                                 tag_id in seen, keep)
                cover, corners = patch.cover()
                covers.append((cover, Area.from_undistorted(transform(to_frame, corners), lens=area.lens)))
        for cover, covered in covers:
            paint(find_place(image, covered, cover), cover, finish=lambda warped: warped if noisy is None else
                  np.dstack([noisy(warped[:, :, :3]), warped[:, :, 3]]))

    def _find(self, area: Area, tags: Sequence[Tag]) -> None:
        """Take in where the tags are in the area, which is the unit square."""
        from_frame = homography_from(area.undistorted)
        for tag in tags:
            place = transform(from_frame, straight_corners(tag, area.lens))
            patch = self._patches.get(tag.id)
            if patch is None or not patch.is_at(place):
                self._patches[tag.id] = _Patch(place, len(self._patches))  # so that they take turns


class _Patch:
    """A tag and the wall around it. ``place``: (4, 2) float64, the tag's corners in the area."""

    def __init__(self, place: Floats, number: int) -> None:
        self.place = place
        self._places, self._frames = 1, number
        self._reset()

    def is_at(self, place: Floats) -> bool:
        """Whether the tag is still where it was. Its place is a running mean."""
        side = np.linalg.norm(self.place[1] - self.place[0])
        if np.abs(place - self.place).max() > SAME_PLACE * side:
            return False
        self._places = min(self._places + 1, PLACE_OF)
        self.place = self.place + (place - self.place) / self._places
        return True

    def _reset(self) -> None:
        self._look: Floats = np.zeros((*SIZE, 3), np.float32)  # the wall in the light of its first frame
        self._known = np.zeros(SIZE, bool)
        self._light: Floats = np.ones((*SIZE, 3), np.float32)
        self._votes = np.zeros(SIZE, np.float32)
        self._count = self._unlike = self._replaced = self._inpainted_at = 0
        self._front: Floats | None = None  # how much of the patch things in front cover
        self._picture: Picture | None = None  # what covers the tag, until something of it changes

    def is_turn(self, keep: bool) -> bool:
        """Whether the next frame tells anything that is wanted. ``keep``: see HiddenTags.hide."""
        self._frames += 1
        return (keep or self._count < KNOWN_AFTER or any(self._frames % every == 0 for every in EVERY)
                or not self._known.all())

    def cover(self) -> tuple[Picture, Floats]:
        """What to cover the tag with, BGRA, and its corners, (4, 2). Those of the tag are the unit square."""
        if not self._count:
            return Picture(np.zeros((1, 1, 4), np.uint8)), SQUARE
        if self._picture is None:
            part = self._rows, self._columns
            cover = self._cover[part] if self._front is None else self._cover[part] * (1 - self._front[part])
            fill = cv2.convertScaleAbs(cv2.multiply(self._fill[part], self._light[part]))
            self._picture = Picture(cv2.merge([*cv2.split(fill), cv2.convertScaleAbs(cover, alpha=255)]))
        return self._picture, self._corners

    def update(self, image: Image, valid: Booleans, squares: Sequence[Floats], seen: bool, keep: bool) -> None:
        """Take in a frame.

        ``image``: (h, w, 3) BGR uint8, the rectified frame. ``valid``: (h, w), where it shows the wall.
        ``squares``: the places of all tags. ``seen``: whether the tag is. ``keep``: see HiddenTags.hide.
        """
        colors = np.asarray(image, np.float32)
        self._front = self._picture = None
        light_turn, learning_turn = (self._frames % every == 0 for every in EVERY)
        if self._count and (light_turn or self._count < KNOWN_AFTER):
            self._measure_light(colors, valid)  # it may find another wall, of which nothing is known
        new = valid & ~self._known
        if seen and (learning_turn or self._count < KNOWN_AFTER or new.any()):
            self._known |= new
            self._count += 1
            replaced = self._vote(np.asarray(cv2.divide(colors, self._light), np.float32), valid)
            self._replaced += np.count_nonzero(replaced)
            if self._count in INPAINT_AFTER or (self._replaced > REPLACED * SIZE[0] * SIZE[1]
                                                and self._count >= self._inpainted_at + AGAIN_AFTER):
                self._inpaint(squares)
        if keep and self._count:
            lit = self._look * self._light
            front = difference(cv2.blur(image, (3, 3)), lit, np.ones(3, np.float32),
                               np.full(SIZE, VARIANCE, np.float32), valid & self._known).front
            labels, count = parts_of(front) if front.any() else (front, 0)
            if count:
                self._front = soft_rim(colors, lit, labels > 0)

    def _vote(self, colors: Floats, valid: Booleans) -> Booleans:
        """Take colors into the look. Returns (h, w), where they replace it.

        Somebody may have stood here at first. So each pixel takes a majority vote, as in R. Boyer and J. Moore,
        MJRTY, 1981: it counts votes for the look, less those against it. When the votes run out, the other
        color replaces the look.
        """
        away, gray = largest_difference(colors, self._look), cv2.transform(self._look, MEAN)
        alike = valid & (away < np.maximum(ALIKE * gray, ALIKE * DARK))
        self._votes += alike
        self._votes -= valid & ~alike
        replaced = self._votes < 0
        self._votes[replaced] = 1
        np.minimum(self._votes, MEAN_OF, out=self._votes)
        weight = (alike / np.maximum(self._votes, 1) + replaced)[..., None]
        self._look += weight.astype(np.float32) * (colors - self._look)
        return replaced

    def _measure_light(self, colors: Floats, valid: Booleans) -> None:
        """Measure the light around the tag, relative to ``look``, and extend it under the tag."""
        shown = self._around * (valid & self._known)
        cover = _cells(shown)
        ratio = _cells(colors * shown[..., None]) / np.maximum(_cells(self._look * shown[..., None]), 0.1)
        usable = cover > MIN_COVER
        usual = np.maximum(np.median(ratio[usable], axis=0), 0.01) if usable.any() else np.ones(3)
        change = ratio / usual
        bright = change.mean(axis=1)
        usable &= (bright > DARKEST) & (bright < LIGHTEST)
        usable &= np.abs(change - bright[:, None]).max(axis=1) < SAME_COLOR * bright
        if cover[usable].sum() <= ENOUGH * cover.sum():
            self._unlike += cover.sum() > 0
            if self._unlike >= ANOTHER_AFTER:
                self._reset()
            return
        self._unlike = 0
        weights = NEARNESS * (cover * usable)
        light = (weights @ ratio / weights.sum(axis=1)[:, None]).astype(np.float32)
        self._light = cv2.resize(light.reshape(CELLS, CELLS, 3), SIZE, interpolation=cv2.INTER_LINEAR)

    def _inpaint(self, squares: Sequence[Floats]) -> None:
        self._replaced, self._inpainted_at = 0, self._count
        look = np.clip(np.round(self._look), 0, 255).astype(np.uint8)
        to_patch = np.diag([*SIZE, 1.0]) @ homography_from(PATCH) @ homography_from(self.place)
        tags = np.zeros(SIZE, np.uint8)  # all tags in the patch: neighbors must not bleed into the wall
        for square in squares:
            corners = transform(to_patch @ homography_to(square), (SQUARE - 0.5) * BARE_SCALE + 0.5)
            cv2.fillConvexPoly(tags, np.round(corners).astype(np.int32), (1,))
        own = _paper(look) | _square(BARE_SCALE)
        own = grown(own, MARGIN_PX)
        self._around = (~own & (tags == 0)).astype(np.float32)
        hole = own | (tags > 0) | ~self._known
        fill = cv2.inpaint(look, hole.astype(np.uint8), INPAINT_PX, cv2.INPAINT_TELEA).astype(np.float32)
        for _ in range(SMOOTHINGS):  # inpainting leaves streaks
            fill[hole] = cv2.blur(fill, (SMOOTH_PX, SMOOTH_PX))[hole]
        self._fill: Floats = fill
        cover = np.asarray(cv2.blur(grown(own, SOFT_PX).astype(np.float32), (SOFT_PX, SOFT_PX)))
        cover[[0, -1]] = cover[:, [0, -1]] = 0
        self._cover = cover
        x, y, width, height = cv2.boundingRect((cover > 0).astype(np.uint8))
        self._rows, self._columns = slice(y, y + height), slice(x, x + width)
        box = SQUARE * (width, height) + (x, y)
        self._corners = (box / SIZE - 0.5) * SCALE + 0.5


def _square(scale: float) -> Booleans:
    """(h, w): a square in the middle of a patch. ``scale``: its width, in sides of the tag."""
    places = np.abs((np.arange(SIZE[0]) + 0.5) / SIZE[0] - 0.5) * SCALE < scale / 2
    return places & places[:, None]


def _paper(look: Image) -> Booleans:
    """(h, w): the paper around a tag in its patch; empty if the paper has no end in sight."""
    ring = _square(PAPER_SCALE) & ~_square(1.02)
    color = np.maximum(np.median(look[ring], axis=0), 1)
    like = np.abs(look / color - 1).max(axis=2) < PAPER_LEVELS
    labels, _ = components(like | _square(1.0))
    paper = labels == labels[SIZE[0] // 2, SIZE[1] // 2]
    inner = paper[REACH_PX:-REACH_PX, REACH_PX:-REACH_PX]
    return paper if np.count_nonzero(inner) == np.count_nonzero(paper) else np.zeros(SIZE, bool)


def _cells(image: Floats) -> Floats:
    """(CELLS**2, channels): the means in the cells of an image; (CELLS**2,) for a mask."""
    cells = np.asarray(cv2.resize(image, (CELLS, CELLS), interpolation=cv2.INTER_AREA), np.float32)
    return cells.reshape(-1, 3) if cells.ndim == 3 else cells.reshape(-1)


def _nearness() -> Floats:
    """(CELLS**2, CELLS**2): the weight of each cell in the mean for each other cell."""
    y, x = np.divmod(np.arange(CELLS**2), CELLS)
    return 1 / ((x[:, None] - x)**2 + (y[:, None] - y)**2 + 0.5)**1.5


NEARNESS = _nearness()
