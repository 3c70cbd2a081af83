"""The view in which a wall is learned and compared: the area with a margin, as if seen from straight ahead."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import homography_from, homography_to, transform
from aruco_ar.geometry.lens import Lens, rectify

MARGIN = 0.15            # width of the margin around the area, as a share of the area's size
MAX_LENGTH_PX = 320      # the longer side
MIN_SIDE_PX = 40         # an area with a shorter side in the frame shows too little
PAPER_SIDES = 1.7        # the width of the paper around a tag, in sides of the tag
PATCH_PX, COARSEST = binding.PATCH_WIDTH, 2**(binding.WALL_LEVELS - 1)


class Template:
    """The view of an area.

    ``inner``: (2,) pixels, the area's size in it. ``size``: its own width and height, pixels.
    """

    def __init__(self, inner: Floats, lens: Lens | None) -> None:
        """``lens``: that of all frames, or None. With a lens, corners and tags are undistorted pixels."""
        self.inner, self._lens = inner, lens
        width, height = (np.ceil(inner * (1 + 2 * MARGIN) / COARSEST).astype(int) * COARSEST).tolist()
        self.size: tuple[int, int] = (width, height)

    @classmethod
    def of(cls, corners: Floats, lens: Lens | None) -> Template:
        """The view with pixels as large as those of a frame with these corners, (4, 2), about, or larger."""
        sides = _sides(corners)
        size = np.array([sides[[0, 2]].mean(), sides[[1, 3]].mean()])
        return cls(size * min(1, MAX_LENGTH_PX / (1 + 2 * MARGIN) / size.max()), lens)

    @staticmethod
    def fits(corners: Floats) -> bool:
        """Whether an area with these corners is large enough in the frame."""
        return bool(_sides(corners).min() >= MIN_SIDE_PX)

    def scale(self, corners: Floats) -> float:
        """Pixels of the frame for each pixel of this view, if the area is at these corners."""
        return float(np.sqrt(cv2.contourArea(np.asarray(corners, np.float32)) / self.inner.prod()))

    def to_plane(self, points: Floats) -> Floats:
        """(..., 2): pixels of this view as points in the plane of the area."""
        return (np.asarray(points, np.float64) + 0.5) / self.inner - MARGIN

    def from_plane(self, points: Floats) -> Floats:
        """(..., 2): points in the plane of the area as pixels of this view."""
        return (points + MARGIN) * self.inner - 0.5

    def relative(self, points: Floats) -> Floats:
        """(n, 2): pixels of this view, relative to its middle, in halves of its width; see align.c."""
        return (2 * np.asarray(points, np.float64) + 1 - self.size) / self.size[0]

    def absolute(self, points: Floats) -> Floats:
        """(n, 2): the inverse of ``relative``."""
        return (points * self.size[0] + self.size - 1) / 2

    def rectified(self, frame: Image, corners: Floats) -> Floats:
        """(h, w) float32: this view of an area in a frame, gray, 0 beyond the frame."""
        to_plane = np.array([[1 / self.inner[0], 0, 0.5 / self.inner[0] - MARGIN],
                             [0, 1 / self.inner[1], 0.5 / self.inner[1] - MARGIN], [0, 0, 1]])
        seen = rectify(frame, homography_to(corners) @ to_plane, self.size, self._lens)
        return np.asarray(seen if seen.ndim == 2 else cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), np.float32)

    def draw_tags(self, tags: Floats, corners: Floats, sides: float) -> Image:
        """(h, w) uint8: white where this view shows tags, (n, 4, 2) pixels, in a frame.

        ``sides``: how wide they are drawn, in sides of the tag.
        """
        region = np.zeros(self.size[::-1], np.uint8)
        centers = tags.mean(axis=1, keepdims=True)
        papers = transform(homography_from(corners), centers + sides * (tags - centers))
        for paper in self.from_plane(papers):
            cv2.fillConvexPoly(region, np.round(paper).astype(np.int32), (255,))
        return region

    def draw_inside(self, corners: Floats, shape: tuple[int, ...]) -> Image:
        """(h, w) uint8: white where this view shows a frame of that ``shape``, with the patches around."""
        inside = cv2.erode(self.rectified(np.full(shape[:2], 255, np.uint8), corners),
                           np.ones((PATCH_PX, PATCH_PX)), borderType=cv2.BORDER_CONSTANT, borderValue=(0,))
        return np.asarray(inside, np.uint8)

    def in_sight(self, points: Floats, corners: Floats, shape: tuple[int, ...]) -> Booleans:
        """(n,) bool: which points of this view should be in a frame, with the patches around them."""
        reach = PATCH_PX / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        pixels = transform(homography_to(corners), self.to_plane(points[:, None] + reach))
        if self._lens is not None:
            pixels = self._lens.distort(pixels)
        return np.asarray(((pixels > 0) & (pixels < np.array(shape[1::-1]) - 1)).all(axis=(1, 2)))


def _sides(corners: Floats) -> Floats:
    return np.linalg.norm(corners - corners[[1, 2, 3, 0]], axis=1)
