"""The area: the quadrilateral through the centers of four tags."""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.geometry.homography import homography_from, transform
from aruco_ar.geometry.ordering import largest_quadrilateral, order_coordinates
from aruco_ar.tags.tag import Tag

MIN_AREA_PX = 0.1  # square pixels: a smaller area is not visible


@dataclass(frozen=True, eq=False)
class Area:
    """The quadrilateral that the picture is painted into.

    ``corners``: (4, 2) float32, pixels of the frame, where the picture's top
    left, top right, bottom right and bottom left belong. ``ratio``: the area's
    width divided by its height on the wall, or None if that is unknown.
    """

    corners: Floats
    ratio: float | None = None

    def window(self, frame: Image) -> tuple[Image, Area]:
        """The part of a frame that the area touches, as a view, (h, w, 3), and the Area in its pixels.

        The part is empty if the area is outside of the frame, or too small to be visible.
        """
        low = np.maximum(np.floor(self.corners.min(axis=0)) - 1, 0).astype(int)
        high = np.minimum(np.ceil(self.corners.max(axis=0)) + 2, frame.shape[1::-1]).astype(int)
        if np.any(low >= high) or cv2.contourArea(self.corners) < MIN_AREA_PX:
            return frame[:0, :0], self
        return frame[low[1]:high[1], low[0]:high[0]], replace(self, corners=self.corners - np.float32(low))

    def homography(self, width: int, height: int) -> Floats:
        """(3, 3) float64: the homography from pixels of a picture of that size to pixels of the frame.

        The picture's corners are (0, 0) and (width, height), as in the course.
        """
        picture = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
        found = cv2.getPerspectiveTransform(picture, np.asarray(self.corners, np.float32))
        return np.asarray(found, np.float64)


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
