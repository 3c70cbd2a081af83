"""The look of the picture on its wall: what of it is visible, and in which light."""
from __future__ import annotations

from typing import Any, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Image
from aruco_ar.geometry.homography import homography_from, transform
from aruco_ar.painting.paint import warp
from aruco_ar.settings.settings import CLEAN, FULL, HIDE, KEEP, MATCH, PAINT, SHOW
from aruco_ar.tags.corner_rays import straight_corners
from aruco_ar.tags.tag import Tag
from aruco_ar.tracking.area import Area

from .grain import Grain
from .hidden_tags import HiddenTags
from .light import COARSE, WallLight, white_and_black
from .wall_model import WallModel

MAX_STEP_S = 0.5        # a longer time between frames counts as this
PIXELS = 40_000         # number of pixels of the rectified area
SHAPES = 0.1, 10        # limits of the rectified area's width divided by its height
TAG_SCALE = 1.5         # width of a tag with its white rim, in sides of the tag
AS_IN_COURSE = PAINT, FULL, CLEAN, SHOW


def asks_for_look(settings: Any) -> bool:
    """Whether settings ask for more than the course does. ``settings``: see Look."""
    return (settings.foreground, settings.light, settings.grain, settings.tags) != AS_IN_COURSE


class Look:
    """Learns how the wall of an area looks, so that a picture on it looks as if it hung there.

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
        # The time since the model learned a frame, and whether it was the turn of the last one to be learned.
        self._unlearned_s, self._is_turn = 0.0, False
        self._size = 0, 0
        self._image: Image = np.zeros((0, 0, 3), np.uint8)  # the last frame, rectified

    def update(self, frame: Image, stamp: float, area: Area, tags: Sequence[Tag], settings: Any,
               sure: bool = True) -> None:
        """Take in a frame.

        ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``stamp``: its time, seconds. ``area``: the Area
        in it. ``tags``: those in sight. ``settings``: see above. ``sure``: whether the frame shows
        where the area is. If not, nothing is learned from it, and what was in front before stays in front.
        """
        if self._stamp is not None and stamp < self._stamp:
            self.reset()
        passed = 0.0 if self._stamp is None else min(stamp - self._stamp, MAX_STEP_S)
        self._stamp = stamp
        if not sure:
            return
        if settings.foreground == KEEP or settings.light == MATCH:
            self._learn_wall(frame, area, tags, passed, settings.settle, settings.foreground == KEEP)
        if settings.grain == MATCH:
            self._grain.measure(frame, area.window(frame)[0], tags)

    def _learn_wall(self, frame: Image, area: Area, tags: Sequence[Tag], passed: float, settle: float,
                    keep: bool) -> None:
        if not self._model.look.size:
            shape = np.clip(area.ratio or 1.0, *SHAPES)
            sides = np.sqrt([PIXELS * shape, PIXELS / shape])
            width, height = (COARSE * round(side / COARSE) for side in sides)  # OpenCV shrinks such sizes fast
            self._size = width, height
        image = area.rectified(frame, self._size)
        begun = self._model.begun
        self._unlearned_s += passed
        self._is_turn = not self._is_turn
        if keep or self._is_turn or not begun:  # for the light alone, every other frame tells enough
            self._model.update(image, area.in_frame(frame, self._size), lambda: self._of_tags(area, tags),
                               self._unlearned_s, settle)
            self._unlearned_s = 0.0
        if self._model.begun != begun:
            self._light = None
        if self._light is None and tags:
            centers = np.array([tag.center for tag in tags], np.float64)
            centers = transform(homography_from(area.undistorted),
                                centers if area.lens is None else area.lens.undistort(centers))
            white, black = white_and_black(frame, tags, area.lens)
            self._light = WallLight(centers, white / self._model.light, black / self._model.light, self._model)
        self._image = image

    def apply(self, picture: Image, mask: Image, part: Area, settings: Any) -> tuple[Image, Image]:
        """The picture as it looks on the wall of the last frame, (h, w, 3) BGR or (h, w, 4) BGRA, and its mask.

        ``picture``: (h, w, 3) BGR or (h, w, 4) BGRA, warped onto the area. ``mask``: (h, w, 3), the area's.
        ``part``: the Area, in the pixels of both. ``settings``: see above.
        """
        if not mask.size:
            return picture, mask
        area_mask = mask
        if settings.light == MATCH and self._light is not None:
            white = self._warped(self._light.update(self._image, self._model), mask, part)
            black = self._light.black
            printed = cv2.convertScaleAbs(picture[:, :, :3], alpha=1 - black, beta=255 * black)
            lit = cv2.multiply(printed, white, scale=1 / 255)
            picture = lit if picture.shape[2] == 3 else np.dstack([lit, picture[:, :, 3]])
        if settings.grain == MATCH:
            picture, mask = self._grain.apply(picture, mask)
        if settings.foreground == KEEP and self._model.front.any():
            free = np.round(255 * (1 - self._model.front)).astype(np.uint8)
            alpha = self._warped(np.dstack([free] * 3), area_mask, part)[:, :, 0]
            alpha[area_mask[:, :, 0] == 0] = 255  # a soft mask reaches beyond the area, where nothing is known
            if picture.shape[2] == 4:
                alpha = cv2.multiply(alpha, picture[:, :, 3], scale=1 / 255)
            picture = np.dstack([picture[:, :, :3], alpha])
        return picture, mask

    def hide_tags(self, frame: Image, image: Image, area: Area, tags: Sequence[Tag], settings: Any,
                  sure: bool = True) -> None:
        """Cover the tags in an image with what the wall around them looks like. This changes the image.

        ``image``: what to paint on, of the size of ``frame``; it may be the frame itself. The others are those
        of ``update``, which comes first.
        """
        if settings.tags == HIDE:
            self._hidden_tags.hide(frame, image, area, tags, sure, settings.foreground == KEEP,
                                   self._grain.noisy if settings.grain == MATCH else None)

    def _of_tags(self, area: Area, tags: Sequence[Tag]) -> Booleans:
        """(h, w): where tags and their white rims are."""
        image = np.zeros(self._size[::-1], np.uint8)
        from_frame = np.diag([*self._size, 1.0]) @ homography_from(area.undistorted)
        for tag in tags:
            corners = transform(from_frame, straight_corners(tag, area.lens))
            middle = corners.mean(axis=0)
            cv2.fillConvexPoly(image, np.round(middle + TAG_SCALE * (corners - middle)).astype(np.int32), (1,))
        return image > 0

    def _warped(self, image: Image, mask: Image, part: Area) -> Image:
        return warp(image, part.homography(image.shape[1], image.shape[0]), mask, part.positions)
