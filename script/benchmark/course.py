"""The course's own code for exercise 5.6, frame in to painted frame out: what ours is measured against.

Step by step as the course has it, with the names that OpenCV gives these
functions today. The picture is loaded once, as it would be in a node, and the
frame keeps its size, which the course shrinks to 0.7 first.
"""
import cv2
import numpy as np
from aruco_ar import DICTIONARIES


class Course:
    """Finds the area in each frame alone, and paints the whole frame.

    ``ids``: the four tags that count, where there are more; the course has no such choice.
    """

    def __init__(self, dictionary, picture, ids=()):
        self._ids = ids
        self._detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(DICTIONARIES[dictionary]),
                                                 cv2.aruco.DetectorParameters())
        self._picture = picture

    def area(self, frame):
        """(4, 2) int: the area's corners, or None without four tags."""
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        corners, ids, _ = self._detector.detectMarkers(gray)
        if ids is not None and self._ids:
            corners = [quad for quad, tag_id in zip(corners, ids.ravel()) if tag_id in self._ids]
        if ids is None or len(corners) < 4:
            return None
        centers = np.array([(int(quad[0][:, 0].mean()), int(quad[0][:, 1].mean())) for quad in corners])
        total, difference = centers.sum(axis=1), np.diff(centers, axis=1)
        return centers[[np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]]

    def paint(self, frame):
        """The frame with the picture in the area, and the area's corners."""
        area = self.area(frame)
        painted = None if area is None else self.paint_at(frame, area)
        return (frame, None) if painted is None else (painted, area)

    def paint_at(self, frame, area):
        """The frame with the picture in an area, (4, 2) pixels, or None where there is no homography."""
        height, width = self._picture.shape[:2]
        ends = np.array([[0, 0], [width, 0], [width, height], [0, height]])
        homography, _ = cv2.findHomography(ends, area)
        if homography is None:
            return None
        warped = cv2.warpPerspective(self._picture, homography, frame.shape[1::-1])
        mask = np.zeros_like(frame)
        cv2.fillConvexPoly(mask, np.int32([np.round(area)]), (255, 255, 255), cv2.LINE_AA)
        return cv2.add(warped, cv2.subtract(frame, mask))
