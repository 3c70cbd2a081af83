"""A picture that looks as if it hung on its wall: what of it is visible, and in which light."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import homography_from, transform
from aruco_ar.painting.paint import warp
from aruco_ar.painting.place import Place
from aruco_ar.settings.settings import CLEAN, FULL, HIDE, KEEP, MATCH, PAINT, SHOW, PictureSettings
from aruco_ar.tags.corner_rays import straight_corners
from aruco_ar.tags.tag import Tag
from aruco_ar.tracking.area import Area
from aruco_ar.tracking.sight import SeenArea, Sight

from .grain import Grain
from .hidden_tags import HiddenTags
from .light import COARSE, WallLight, white_and_black
from .wall_model import WallModel

MAX_STEP_S = 0.5        # a longer time between frames counts as this
PIXELS = 40_000         # number of pixels of the rectified area
SHAPES = 0.1, 10        # limits of the rectified area's width divided by its height
TAG_SCALE = 1.5         # width of a tag with its white rim, in sides of the tag
# The wall is learned from every third frame as long as nothing is in front; for the light alone, from every
# other one if something is.
EVERY, EVERY_IN_FRONT = 3, 2
MIDDLE_OF_TWO = 0.25    # where the middle of two pixels is, in pixels as large as both, if the first is at 0
AS_IN_COURSE = PAINT, FULL, CLEAN, SHOW


@dataclass(frozen=True, eq=False)
class OnWall:
    """How a picture looks on its wall in one frame, as far as settings ask for it.

    ``white``: (h, w, 3) uint8, the level of white paper at each place of the area, or None: the picture has its
    own colors. ``black``: the level of ink as a share of that of paper. ``grain``: the Grain that the picture
    gets, or None. ``front``: (h, w) float32, how much of the area things cover that stay in front, or None.
    """

    white: Image | None = None
    black: float = 0.0
    grain: Grain | None = None
    front: Floats | None = None

    def apply(self, warped: Image, place: Place) -> tuple[Image, Image]:
        """The picture as it looks on the wall, (h, w, 3) BGR or (h, w, 4) BGRA, and its mask.

        ``warped``: (h, w, 3) BGR or (h, w, 4) BGRA, the picture that was warped to its Place; it may be
        overwritten.
        """
        mask = place.mask
        if not mask.size:
            return warped, mask
        if self.white is not None:
            warped = np.require(warped, requirements=('C', 'W'))
            binding.light_picture(warped, mask, _coarsely_warped(self.white, place), self.black)
        if self.grain is not None:
            warped, mask = self.grain.apply(warped, mask)
        if self.front is not None:
            free = np.round(255 * (1 - self.front)).astype(np.uint8)
            alpha = _warped(cv2.merge([free] * 3), place)[:, :, 0]
            alpha[place.mask[:, :, 0] == 0] = 255  # a soft mask reaches beyond the area, where nothing is known
            if warped.shape[2] == 4:
                alpha = cv2.multiply(alpha, warped[:, :, 3], scale=1 / 255)
            warped = cv2.merge([*cv2.split(warped)[:3], alpha])
        return warped, mask


class Hanging:
    """Learns what the wall of an area looks like, so that a picture looks as if it hung there.

    The wall is learned from frame to frame. It is learned anew if the time goes back. The settings decide what
    is learned and done. They are ``foreground``, ``light``, ``grain`` and ``tags``, each one of the values
    above, and ``settle`` (see WallModel.update).
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the wall."""
        self._model = WallModel()
        self._light: WallLight | None = None
        self._grain, self._hidden_tags = Grain(), HiddenTags()
        self._stamp: float | None = None
        self._unlearned_s = 0.0  # the time since the model learned a frame
        self._turn = 0           # the model learns a frame if this is 0
        self._size = 0, 0
        self._image: Image = np.zeros((0, 0, 3), np.uint8)  # the last frame, rectified

    def update(self, sight: Sight, seen: SeenArea, image: Image, settings: PictureSettings) -> OnWall | None:
        """Take in a frame. Returns how a picture looks on the wall in it; None if the settings ask for nothing.

        ``seen``: what is seen of the area. If nothing shows where it is, nothing is learned from the frame,
        and what was in front before stays in front. ``image``: what will be painted on, of the size of the
        frame; it may be the frame itself. If the settings ask for it, the tags are hidden in it.
        ``settings``: see above.
        """
        if seen.area is None or not asks_for_more(settings):
            return None
        keep, match_light, match_grain = (settings.foreground == KEEP, settings.light == MATCH,
                                          settings.grain == MATCH)
        if self._stamp is not None and sight.stamp < self._stamp:
            self.reset()
        passed = 0.0 if self._stamp is None else min(sight.stamp - self._stamp, MAX_STEP_S)
        self._stamp = sight.stamp
        if seen.is_located and (keep or match_light):
            self._learn_wall(sight.frame, seen.area, seen.tags, passed, settings)
        if seen.is_located and match_grain:
            self._grain.measure(sight.frame, seen.area.window(sight.frame)[0], seen.tags)
        on_wall = OnWall(self._light.update(self._image, self._model) if match_light and self._light else None,
                         self._light.black if self._light else 0.0,
                         self._grain if match_grain else None,
                         self._model.front if keep and self._model.front.any() else None)
        if settings.tags == HIDE:
            self._hidden_tags.hide(sight.frame, image, seen.area, seen.tags, seen.is_located, keep,
                                   self._grain.noisy if match_grain else None)
        return on_wall

    def _learn_wall(self, frame: Image, area: Area, tags: Sequence[Tag], passed: float,
                    settings: PictureSettings) -> None:
        if not self._model.look.size:
            shape = np.clip(area.ratio or 1.0, *SHAPES)
            sides = np.sqrt([PIXELS * shape, PIXELS / shape])
            width, height = (COARSE * round(side / COARSE) for side in sides)  # OpenCV shrinks such sizes fast
            self._size = width, height
        begun = self._model.begun
        self._unlearned_s += passed
        keep, match_light = settings.foreground == KEEP, settings.light == MATCH
        is_turn = self._turn == 0 or not begun
        self._turn = (self._turn + 1) % (EVERY if keep or not self._model.front.any() else EVERY_IN_FRONT)
        if match_light:  # always the same way, since the light would flicker otherwise
            self._image = area.rectified(frame, self._size)
        if not is_turn and (not keep or self._glance(frame, area, match_light)):
            return
        if not match_light:
            self._image = area.rectified(frame, self._size)
        self._model.update(self._image, area.in_frame(frame, self._size), lambda: self._of_tags(area, tags),
                           self._unlearned_s, settings.settle, area.slope(frame))
        self._unlearned_s = 0.0
        if self._model.begun != begun:
            self._light = None
        if self._light is None and tags:
            centers = np.array([tag.center for tag in tags], np.float64)
            centers = transform(homography_from(area.undistorted),
                                centers if area.lens is None else area.lens.undistort(centers))
            white, black = white_and_black(frame, tags, area.lens)
            self._light = WallLight(centers, white / self._model.light, black / self._model.light, self._model)

    def _glance(self, frame: Image, area: Area, is_rectified: bool) -> bool:
        """Whether a glance at a frame shows that nothing is in front: see WallModel.glance.

        ``is_rectified``: whether it has been rectified in full.
        """
        if not self._model.can_glance(area.slope(frame)):
            return False
        half = self._size[0] // 2, self._size[1] // 2
        image = (cv2.resize(self._image, half, interpolation=cv2.INTER_AREA) if is_rectified
                 else area.rectified(frame, half, MIDDLE_OF_TWO))
        return self._model.glance(image, area.in_frame(frame, half))

    def _of_tags(self, area: Area, tags: Sequence[Tag]) -> Booleans:
        """(h, w): where tags and their white rims are."""
        image = np.zeros(self._size[::-1], np.uint8)
        from_frame = np.diag([*self._size, 1.0]) @ homography_from(area.undistorted)
        for tag in tags:
            corners = transform(from_frame, straight_corners(tag, area.lens))
            middle = corners.mean(axis=0)
            cv2.fillConvexPoly(image, np.round(middle + TAG_SCALE * (corners - middle)).astype(np.int32), (1,))
        return image > 0


def asks_for_more(settings: PictureSettings) -> bool:
    """Whether settings ask for more than the course does: see Hanging."""
    return (settings.foreground, settings.light, settings.grain, settings.tags) != AS_IN_COURSE


def _warped(image: Image, place: Place) -> Image:
    """An image of the whole area, (h, w, 3), warped to where a picture goes."""
    homography = place.area.homography(image.shape[1], image.shape[0])
    return warp(image, homography, place.mask, place.positions)


def _coarsely_warped(image: Image, place: Place) -> Image:
    """The same for an image that changes slowly: see binding.light_picture. The mask does not count."""
    height, width = place.window.shape[:2]
    step = binding.LIGHT_STEP_PX
    first = step // 2
    rows, columns = -(-height // step), -(-width // step)
    from_coarse = np.array([[step, 0, first], [0, step, first], [0, 0, 1.0]])
    homography, positions = place.area.homography(image.shape[1], image.shape[0]), place.positions
    if positions is None:
        homography = np.linalg.inv(from_coarse) @ homography
    else:
        y, x = (np.minimum(np.arange(count) * step + first, length - 1)
                for count, length in ((rows, height), (columns, width)))
        positions = np.ascontiguousarray(positions[y[:, None], x])
    return warp(image, homography, np.full((rows, columns), 255, np.uint8), positions)
