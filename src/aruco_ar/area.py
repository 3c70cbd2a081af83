"""The area: the quadrilateral through the centers of four tags."""
from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np

from .ordering import largest_quadrilateral, order_coordinates


@dataclass(frozen=True, eq=False)
class Area:
    """Where the picture goes.

    ``corners``: (4, 2) float32, pixels of the frame: top left, top right,
    bottom right, bottom left of the picture to be painted.
    """

    corners: np.ndarray

    def homography(self, width, height):
        """(3, 3) float64: from pixels of a picture of that size to pixels of the frame.

        The picture's corners are (0, 0) and (width, height), as in the course.
        """
        picture = np.float32([[0, 0], [width, 0], [width, height], [0, height]])
        return cv2.getPerspectiveTransform(picture, np.asarray(self.corners, np.float32))


def find_four_centers(tags):
    """(4, 2) float32: the four centers that span the area, going around; None if none do.

    An id seen more than once does not count: nobody could say which of its
    tags is meant. Of more than four tags, those four count whose centers
    enclose the largest area.
    """
    seen = Counter(tag.id for tag in tags)
    return largest_quadrilateral([tag.center for tag in tags if seen[tag.id] == 1])


def find_area(tags):
    """The Area between tags, or None if they do not span one (see find_four_centers)."""
    centers = find_four_centers(tags)
    return None if centers is None else Area(order_coordinates(centers))
