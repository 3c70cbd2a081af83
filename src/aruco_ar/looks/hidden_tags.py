"""Hiding the tags: each is covered with what is right around it in the same frame."""
from __future__ import annotations

from math import hypot
from typing import Callable, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_from, homography_to, transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.painting.paint import put_in
from aruco_ar.tags.corner_rays import straight_corners
from aruco_ar.tags.tag import Tag
from aruco_ar.tracking.area import MIN_AREA_PX, Area

from .filling import filled
from .paper_outline import paper_of
from .ring import COUNT, Rings, rings_around
from .roughness import SMOOTH, Roughness, Tiles
from .tag_look import SIZE, Front, TagLook

# A tag that moves farther than this is not fixed to the wall. It is a share of the tag's side.
SAME_PLACE = 0.1
PLACE_OF = 30         # a tag's place is the running mean of about this many frames
SIGHTS, MISSES = 3, 15  # a tag in sight in fewer frames is forgotten after so many without it: a mistake
# The outline is looked for after so many frames: soon at first, later if there is none, rarely if it is known.
SOON, LATER, RARELY = 4, 30, 120
SAME_OUTLINE = 0.06   # outlines that differ by less are the same, in sides of the tag
WIDER = (UNIT_SQUARE - 0.5) * 1.15 + 0.5  # what is looked at for things in front, in sides of the outline
RIM = 8.0             # where a thing covers more than 1 part in so many, it is a rim, not noise
TO_SIZE = np.diag([*SIZE, 1.0])
UNKNOWN = np.full((4 * COUNT, 3), np.nan)


class HiddenTags:
    """Covers the tags of a wall."""

    def __init__(self) -> None:
        self._hidden: dict[int, _HiddenTag] = {}

    def reset(self) -> None:
        """Forget the wall."""
        self._hidden.clear()

    def hide(self, frame: Image, image: Image, area: Area, tags: Sequence[Tag], is_located: bool,
             keep: bool, noisy: Callable[[Image], Image] | None = None) -> None:
        """Cover the tags in an image. This changes it.

        ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``image``: what to paint on, of the same size; it
        may be the frame itself. ``area``: the Area in the frame. ``tags``: those in sight.
        ``is_located``: whether the frame shows where the area is. If not, nothing is learned from it. ``keep``:
        whether things that stand in front of the wall stay there. ``noisy``: adds the camera's noise to an
        image, if given.
        """
        seen = {tag.id: straight_corners(tag, area.lens) for tag in tags} if is_located else {}
        if is_located:
            self._find(area, seen)
        chosen, outlines, to_frame = [], [], homography_to(area.undistorted)
        for tag_id, hidden in self._hidden.items():
            # A tag may stand off the wall, or the wall be bent. So its own corners count if they are seen.
            quad = seen[tag_id] if tag_id in seen else transform(to_frame, hidden.place)
            contour = quad.astype(np.float32)
            if cv2.contourArea(contour) > MIN_AREA_PX and cv2.isContourConvex(contour):
                if tag_id in seen:
                    hidden.find_outline(frame, quad, area.lens)
                chosen.append((hidden, tag_id in seen))
                outlines.append(transform(homography_to(quad), hidden.outline))
        if not chosen:
            return
        rings = rings_around(frame, area.lens, np.stack(outlines))
        colors = _without_others(rings, chosen)
        covers = filled(colors)
        to_outlines = [homography_to(outline) for outline in outlines]
        tiles = [hidden.roughness.tiles(frame, area.lens, outline, to_outline, blur_px, depth_px, is_seen)
                 for (hidden, is_seen), outline, to_outline, blur_px, depth_px in zip(
                     chosen, outlines, to_outlines, rings.blurs.tolist(), rings.depths.tolist())]
        fronts = [hidden.look.front(frame, transform(to_outline, WIDER), area.lens, mean, is_seen)
                  if keep else None
                  for (hidden, is_seen), to_outline, mean in zip(chosen, to_outlines, colors.mean(axis=1))]
        to_covers = np.linalg.inv(np.stack([homography_to(corners) for corners in rings.corners]))
        # Only now the image changes, which may be the frame itself.
        for cover, front, outline, corners, to_cover, rough in zip(covers, fronts, outlines, rings.corners,
                                                                   to_covers, tiles):
            covered = Area.from_undistorted(corners, lens=area.lens)
            shown = cover if front is None else _behind(cover, front, outline, to_cover)
            _put(image, frame, covered, shown, 3 if front is None else 4, to_cover, rough, noisy)

    def _find(self, area: Area, seen: dict[int, Floats]) -> None:
        """Take in where tags are in the area. ``seen``: their corners, (4, 2) undistorted pixels, by ids."""
        places = transform(homography_from(area.undistorted), np.array([*seen.values()]).reshape(-1, 4, 2))
        for tag_id, place in zip(seen, places):
            hidden = self._hidden.get(tag_id)
            if hidden is None or not hidden.is_at(place):
                self._hidden[tag_id] = _HiddenTag(place)
        self._hidden = {tag_id: hidden for tag_id, hidden in self._hidden.items()
                        if tag_id in seen or not hidden.is_mistake()}


class _HiddenTag:
    """What is known of a tag.

    ``place``: (4, 2) float64, its corners in the area, which is the unit square. ``outline``: (4, 2) float64,
    the part that is covered, where the tag is the unit square: the tag alone, or its paper, too. ``look``,
    ``roughness``: those of this part. ``usual``: (4 * COUNT, 3), the usual colors of the ring around it, NaN if
    unknown.
    """

    def __init__(self, place: Floats) -> None:
        self.place = place
        self.outline, self.look, self.roughness = UNIT_SQUARE, TagLook(), Roughness()
        self._sights, self._misses = 1, 0
        self._search_in, self._pause, self._last_found = 0, SOON, UNIT_SQUARE  # see find_outline
        self.usual = UNKNOWN

    def is_at(self, place: Floats) -> bool:
        """Whether the tag is still where it was. Its place is a running mean."""
        x, y = (self.place[1] - self.place[0]).tolist()
        off = place - self.place
        if np.abs(off).max() > SAME_PLACE * hypot(x, y):
            return False
        self._sights, self._misses = self._sights + 1, 0
        self.place = self.place + off / min(self._sights, PLACE_OF)
        return True

    def is_mistake(self) -> bool:
        """Whether there seems to be no such tag, as it is not in sight in one more frame."""
        self._misses += 1
        return self._sights < SIGHTS and self._misses > MISSES

    def find_outline(self, frame: Image, quad: Floats, lens: Lens | None) -> None:
        """Learn the outline: at once in the first frame, and later if it is found twice in a row.

        If it is not found, it stays, since somebody may stand beside it. The arguments are those of paper_of.
        """
        self._search_in -= 1
        if self._search_in > 0:
            return
        found = paper_of(frame, quad, lens)
        if found is None:
            self._search_in = self._pause = min(2 * self._pause, LATER)
            return
        is_same = self._sights == 1 or np.abs(found - self._last_found).max() < SAME_OUTLINE
        self._search_in = self._pause = min(max(2 * self._pause, LATER), RARELY) if is_same else SOON
        if is_same and np.abs(found - self.outline).max() > SAME_OUTLINE:
            self.outline, self.look, self.roughness, self.usual = found, TagLook(), Roughness(), UNKNOWN
        self._last_found = found


def _without_others(rings: Rings, tags: Sequence[tuple[_HiddenTag, bool]]) -> Floats:
    """(n, 4 * COUNT, 3): the colors of rings without those of things in front and of other tags.

    ``tags``: the n tags, which learn the usual colors, and whether they are in sight.
    """
    even, usual = binding.even_rings(rings.colors, rings.shown, np.array([is_seen for _, is_seen in tags]),
                                     np.stack([hidden.usual for hidden, _ in tags]))
    for (hidden, _), colors in zip(tags, usual):
        hidden.usual = colors
    return even


def _behind(cover: Floats, front: Front, outline: Floats, to_cover: Floats) -> Floats:
    """A cover, (h, w, 4) float32, BGRA, made transparent where something is in front.

    At its rim, the frame's colors are a mixture with those of the tag. Painted with their share of the tag, the
    cover's colors are such that this share is replaced: the frame's, less the tag's, plus the cover's.
    ``outline``: (4, 2) undistorted pixels, of what is covered. ``to_cover``: see _put.
    """
    looked_at = homography_to(outline) @ homography_to(WIDER)
    to_pixels = np.asarray(TO_SIZE @ to_cover @ looked_at @ np.linalg.inv(TO_SIZE), np.float64)
    rim = np.minimum(RIM * front.share, 1)
    more = np.dstack([rim[..., None] * front.off, 255 * (1 - front.share)])
    more = np.asarray(cv2.warpPerspective(more, to_pixels, SIZE, borderMode=cv2.BORDER_REPLICATE), np.float32)
    more[:, :, :3] += cv2.resize(cover, SIZE, interpolation=cv2.INTER_LINEAR)[:, :, :3]
    return more


def _put(image: Image, frame: Image, covered: Area, cover: Floats, channels: int, to_cover: Floats,
         tiles: Tiles, noisy: Callable[[Image], Image] | None) -> None:
    """Paint a cover, (h, w, 4) float32, BGRA, into an image. This changes it.

    ``frame``, ``noisy``: see HiddenTags.hide. ``covered``: where the cover goes. ``channels``: 3 if it is
    opaque, else 4. ``to_cover``: (3, 3), from undistorted pixels to the unit square, which it fills.
    ``tiles``: what is not smooth there.
    """
    window, there = covered.window(image)
    if not window.size:
        return
    x, y = (round(offset) for offset in (covered.corners[0] - there.corners[0]).tolist())
    mask = binding.draw_mask(window, there.undistorted, there.positions)
    drawn = binding.draw_cover(mask, there.positions, (x, y), cover, to_cover, channels, frame, *tiles)
    if tiles is SMOOTH and noisy is not None:
        drawn[:, :, :3] = noisy(drawn[:, :, :3])
    put_in(window, drawn, mask)
