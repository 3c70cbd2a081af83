"""The area: the quadrilateral through the centers of four tags."""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from math import ceil, log2, sqrt
from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import homography_from, homography_to, transform
from aruco_ar.geometry.lens import Lens, rectify
from aruco_ar.geometry.ordering import largest_quadrilateral, order_coordinates
from aruco_ar.tags.tag import Tag

MIN_AREA_PX = 0.1  # an area of fewer square pixels is not visible
STEP_PX = 16       # step of the grid that shows which part of a distorted frame the area touches
SIDE_POINTS = 32   # number of points of an outline along each side
MAX_HALVINGS = 4   # a frame is halved so many times, at most, if its area is larger than the rectified view
USUAL_FOCAL = 0.9  # focal length without a calibration, as a share of the frame's longer side
MARGIN_PX = 2      # width of the frame's rim, in which rectified pixels are mixtures with what is outside


@dataclass(frozen=True, eq=False)
class Area:
    """The quadrilateral that the picture is painted into.

    ``corners``: (4, 2) float32, pixels of the frame, where the picture's top
    left, top right, bottom right and bottom left belong. ``ratio``: the area's
    width divided by its height on the wall, or None if that is unknown.
    ``lens``: the Lens that distorts the frame, or None. ``undistorted``: (4, 2)
    float32, the corners in undistorted pixels (see Lens), by default those of
    ``corners``. Without a lens, they are ``corners``. ``positions``: (h, w, 2)
    float32, the undistorted position of each pixel, by default those of the
    whole frame; None without a lens.
    """

    corners: Floats
    ratio: float | None = None
    lens: Lens | None = None
    undistorted: Floats = NO_ARRAY
    positions: Image | None = None

    def __post_init__(self) -> None:
        if self.undistorted is NO_ARRAY:
            undistorted = self.corners if self.lens is None else self.lens.undistort(self.corners)
            object.__setattr__(self, 'undistorted', np.asarray(undistorted, np.float32))
        if self.positions is None and self.lens is not None:
            object.__setattr__(self, 'positions', self.lens.undistorted_pixels)

    @classmethod
    def from_undistorted(cls, undistorted: Floats, ratio: float | None = None,
                         lens: Lens | None = None) -> Area:
        """The Area with these corners, (4, 2), in undistorted pixels."""
        corners = undistorted if lens is None else lens.distort(undistorted)
        return cls(np.asarray(corners, np.float32), ratio, lens, np.asarray(undistorted, np.float32))

    def part(self, corners: Floats) -> Area:
        """The part of the area with these corners, (4, 2). The whole is from (0, 0) to (1, 1)."""
        undistorted = np.asarray(transform(homography_to(self.undistorted), corners), np.float32)
        if self.lens is None:
            return Area(undistorted)
        seen = self.lens.distort(np.concatenate([undistorted, self.undistorted[:1]]))
        in_window = np.asarray(seen[:4] + (self.corners[0] - seen[4]), np.float32)
        return replace(self, corners=in_window, ratio=None, undistorted=undistorted)

    def window(self, frame: Image) -> tuple[Image, Area]:
        """The part of a frame that the area touches, as a view, (h, w, 3), and the Area in its pixels.

        The undistorted pixels remain those of the whole frame. The part is
        empty if the area is outside of the frame, or too small to be visible.
        Raises InputError as check_size does.
        """
        self.check_size(frame)
        touched = self.corners
        if self.positions is not None:
            touched = np.concatenate([touched, self._box_inside(self.positions)])
        columns, rows = map(_touched, touched.min(axis=0).tolist(), touched.max(axis=0).tolist(),
                            frame.shape[1::-1])
        if (columns.start >= columns.stop or rows.start >= rows.stop
                or cv2.contourArea(self.undistorted) < MIN_AREA_PX):
            return frame[:0, :0], self
        corners = self.corners - np.array((columns.start, rows.start), np.float32)
        return frame[rows, columns], Area(corners, self.ratio) if self.positions is None else replace(
            self, corners=corners, positions=self.positions[rows, columns])

    def check_size(self, frame: Image) -> None:
        """Raise InputError if the lens, and so ``positions``, is not that of a frame of this size."""
        if self.positions is not None and self.positions.shape[:2] != frame.shape[:2]:
            sizes = *frame.shape[1::-1], *self.positions.shape[1::-1]
            raise InputError('The frame has %d x %d pixels, but the lens is that of %d x %d. Calibrate the '
                             'camera at the size at which it runs.' % sizes, 'lens of another size')

    def outline(self) -> Floats:
        """(n, 2) float32, pixels of the frame: the area's outline. With a lens, its sides are curves."""
        if self.lens is None:
            return self.corners
        begin, end = self.undistorted[:, None], np.roll(self.undistorted, -1, axis=0)[:, None]
        along = begin + np.arange(SIDE_POINTS)[:, None] / SIDE_POINTS * (end - begin)
        return np.asarray(self.lens.distort(along.reshape(-1, 2)), np.float32)

    def homography(self, width: int, height: int) -> Floats:
        """(3, 3) float64: the homography from pixels of a picture of that size to undistorted pixels.

        The picture's corners are (0, 0) and (width, height), as in the course.
        """
        picture = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
        found = cv2.getPerspectiveTransform(picture, np.asarray(self.undistorted, np.float32))
        return np.asarray(found, np.float64)

    def rectified(self, frame: Image, size: tuple[int, int], first: float = 0.0) -> Image:
        """(h, w, 3) uint8: the area in a frame, (H, W, 3), straight from the front. ``size``: (w, h).

        ``first``: where the middle of the first pixel is, in pixels right of the area's corner and below.
        Raises InputError as check_size does.
        """
        self.check_size(frame)
        times = float(np.linalg.norm(self.undistorted[1] - self.undistorted[0])) / size[0]
        halvings = min(int(log2(max(times, 1.0))), MAX_HALVINGS) if self.lens is None else 0
        shift = np.array([[1, 0, first], [0, 1, first], [0, 0, 1]])
        homography = self.homography(*size) @ shift
        window, part = self.window(frame) if halvings else (frame, self)
        if not halvings or not window.size:
            return rectify(frame, homography, size, self.lens)
        block = 2**halvings
        corner = [round(offset) for offset in (self.corners[0] - part.corners[0]).tolist()]
        window, (left, top) = _in_blocks(frame, corner, window.shape[1::-1], block)
        for _ in range(halvings):  # OpenCV does this many times faster than any other shrinking
            half = window.shape[1] // 2, window.shape[0] // 2
            window = cv2.resize(window, half, interpolation=cv2.INTER_AREA)
        middle = (block - 1) / 2  # of the first block
        shrink = np.array([[1, 0, -left - middle], [0, 1, -top - middle], [0, 0, block]]) / block
        return rectify(window, shrink @ homography, size)

    def in_frame(self, frame: Image, size: tuple[int, int]) -> Booleans:
        """(h, w): which pixels of the area, rectified, a frame shows. ``frame``, ``size``: see rectified."""
        limits = np.array(frame.shape[1::-1]) - 1 - MARGIN_PX
        if np.all(self.corners >= MARGIN_PX) and np.all(self.corners <= limits):
            return np.ones(size[::-1], bool)
        inner = np.zeros(frame.shape[:2], np.uint8)
        inner[MARGIN_PX:-MARGIN_PX, MARGIN_PX:-MARGIN_PX] = 255
        return rectify(inner, self.homography(*size), size, self.lens) == 255

    def slope(self, frame: Image) -> Floats:
        """(2,) float64: from which side a frame, (h, w, 3), shows the area.

        It is how far to the right and below the area's middle the camera is, divided by its distance from the
        wall. The columns of a homography are those of a rotation and the way to the area (Z. Zhang, A flexible
        new technique for camera calibration, 2000, section 3.1). Without a lens, a usual focal length is taken.
        """
        height, width = frame.shape[:2]
        focal = USUAL_FOCAL * max(height, width)
        matrix = (np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1.0]])
                  if self.lens is None else self.lens.matrix)
        across = sqrt(self.ratio or 1.0)
        to_rays = np.linalg.inv(matrix) @ homography_to(self.undistorted)
        right, down, away = to_rays[:, 0] / across, to_rays[:, 1] * across, to_rays[:, 2]
        lengths = sqrt(right @ right), sqrt(down @ down)
        right, down, away = right / lengths[0], down / lengths[1], away / sqrt(lengths[0] * lengths[1])
        # The camera is at x * right + y * down + z * (right x down), seen from the corner of the area.
        slanted = right @ down
        square = max(1 - slanted * slanted, 1e-12)  # of the length of right x down
        to_right, to_down = right @ away, down @ away
        x: float = (slanted * to_down - to_right) / square
        y: float = (slanted * to_right - to_down) / square
        (a, b, c), (d, e, f) = right.tolist(), down.tolist()
        z = np.array([b * f - c * e, c * d - a * f, a * e - b * d]) @ away / square
        return np.array([x - across / 2, y - 0.5 / across]) / max(abs(z), 1e-6)

    def _box_inside(self, positions: Image) -> Floats:
        """(2, 2) pixels: the box around the points of a grid that are in the area, with a margin; or (0, 2)."""
        box = binding.find_box(positions, STEP_PX, homography_from(self.undistorted)).reshape(2, 2)
        return box + [[-STEP_PX], [STEP_PX]] if np.isfinite(box[0, 0]) else box[:0]


def _in_blocks(frame: Image, corner: Sequence[int], size: Sequence[int],
               block: int) -> tuple[Image, tuple[int, int]]:
    """A larger part of a frame, which consists of blocks of so many pixels each way, and its corner, x and y.

    ``corner``, ``size``: of the part. There is one more block left of it and above, and what is beyond the
    frame is like its rim.
    """
    left, top = (max(start - block, 0) for start in corner)
    width, height = (-(-(start + length - begin) // block) * block
                     for start, length, begin in zip(corner, size, (left, top)))
    part = frame[top:top + height, left:left + width]
    below, right = height - part.shape[0], width - part.shape[1]
    if below or right:
        part = cv2.copyMakeBorder(part, 0, below, 0, right, cv2.BORDER_REPLICATE)
    return part, (left, top)


def _touched(least: float, most: float, size: int) -> slice:
    """Of all rows or columns, those that something from ``least`` to ``most`` touches; none for NaN."""
    return slice(int(min(max(0.0, least - 1), size)), ceil(min(max(0.0, most + 2), size)))


def find_four_centers(tags: Sequence[Tag]) -> Floats | None:
    """(4, 2) float32: the four centers that span the area, in order along its rim, or None.

    Tags with the same id are all ignored, since nothing shows which of them is
    meant. Of more than four tags, those four are taken whose centers enclose
    the largest area.
    """
    seen = Counter(tag.id for tag in tags)
    return largest_quadrilateral([tag.center for tag in tags if seen[tag.id] == 1])


def find_area(tags: Sequence[Tag]) -> Area | None:
    """The Area between tags, or None if they do not span one (see find_four_centers)."""
    centers = find_four_centers(tags)
    if centers is None:
        return None
    corners = order_coordinates(centers)
    to_plane = homography_from(corners)
    four = [tag for tag in tags if np.any(np.all(tag.center == corners, axis=1))]
    return Area(corners, ratio_of([transform(to_plane, np.asarray(tag.corners, np.float64)) for tag in four]))


def ratio_of(places: Floats | list[Floats]) -> float:
    """An area's width divided by its height on the wall, as its tags show it.

    ``places``: (n, 4, 2), the tags' corners in the plane in which the area is
    the unit square. On the wall a tag is a square, which is as wide as high,
    even if it is turned. So if it seems narrower in the plane, the area is
    wider by the same factor.
    """
    across, down = np.var(places, axis=1).mean(axis=0)
    return float(np.sqrt(down / across))
