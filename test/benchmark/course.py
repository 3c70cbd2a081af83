"""The course's own code for exercise 5.6, from a frame to the painted frame: the baseline of the benchmark.

It follows the course step by step, with the names that OpenCV gives these
functions today. The picture is loaded once, as in a node. The frame keeps its
size, whereas the course first shrinks it to 0.7.
"""
import cv2
import numpy as np
from aruco_ar import DICTIONARIES


def course_order(centers):
    """The indices of centers, (n, 2), that the course takes as top left, top right, bottom right, bottom left.

    A center may be taken twice.
    """
    total, difference = centers.sum(axis=1), np.diff(centers, axis=1).ravel()
    return [np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]


class Course:
    """Finds the area in each frame separately, and paints the whole frame.

    ``ids``: the four tags that span the area, if a frame shows others, too. The course has no such choice.
    """

    def __init__(self, dictionary, picture, ids=()):
        self._ids = ids
        self._detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(DICTIONARIES[dictionary]),
                                                 cv2.aruco.DetectorParameters())
        self._picture = picture

    def area(self, frame):
        """(4, 2) int: the area's corners, or None if there are fewer than four tags."""
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        corners, ids, _ = self._detector.detectMarkers(gray)
        if ids is not None and self._ids:
            corners = [quad for quad, tag_id in zip(corners, ids.ravel()) if tag_id in self._ids]
        if ids is None or len(corners) < 4:
            return None
        centers = np.array([(int(quad[0][:, 0].mean()), int(quad[0][:, 1].mean())) for quad in corners])
        return centers[course_order(centers)]

    def paint(self, frame):
        """The frame with the picture painted into the area, and the area's corners.

        If no area is found, the frame stays as it is, and the corners are None.
        """
        area = self.area(frame)
        painted = None if area is None else self.paint_at(frame, area)
        return (frame, None) if painted is None else (painted, area)

    def paint_at(self, frame, area):
        """The frame with the picture painted into an area, (4, 2) pixels, or None if there is no homography."""
        height, width = self._picture.shape[:2]
        picture_corners = np.array([[0, 0], [width, 0], [width, height], [0, height]])
        homography, _ = cv2.findHomography(picture_corners, area)
        if homography is None:
            return None
        warped = cv2.warpPerspective(self._picture, homography, frame.shape[1::-1])
        mask = np.zeros_like(frame)
        cv2.fillConvexPoly(mask, np.int32([np.round(area)]), (255, 255, 255), cv2.LINE_AA)
        return cv2.add(warped, cv2.subtract(frame, mask))
