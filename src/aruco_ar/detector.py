"""Finding tags in a frame."""
import cv2
import numpy as np

from .edges import fit_tags
from .tags import Tag, get_dictionary, tag_cells

SEARCHES = 'fast', 'normal', 'thorough'
LIKENESS = 0.8
# A search for tags of a known size shrinks the frame until they are this wide.
SEARCH_SIDE_PX = 24
# What is between a tag's edges must be as like it as this (see fit_tags). That
# keeps out what OpenCV would mistake for a tag when it corrects as many wrong
# cells as it can, which is what finds tags blurred by motion.
MIN_LIKENESS = 0.8
# Size of the neighborhood against whose mean a pixel is dark or light, then.
THRESHOLD_WINDOW_PX = 11


class Detector:
    """Finds the tags of one dictionary.

    ``dictionary`` is a name such as ``DICT_6X6_250``. With ``ids``, tags of
    other ids are passed over. Raises InputError for an unknown dictionary.
    """

    def __init__(self, dictionary='DICT_6X6_250', ids=(), **detection):
        self._dictionary = dictionary
        self._ids = frozenset(ids)
        self._cells = {}
        parameters = cv2.aruco.DetectorParameters()
        parameters.errorCorrectionRate = 1.0
        parameters.maxErroneousBitsInBorderRate = 0.6
        # For tags whose edges cannot be fitted: else their corners are whole pixels.
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._anywhere = cv2.aruco.ArucoDetector(get_dictionary(dictionary), parameters)
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        parameters.adaptiveThreshWinSizeMin = THRESHOLD_WINDOW_PX
        parameters.adaptiveThreshWinSizeMax = THRESHOLD_WINDOW_PX
        self._of_a_size = cv2.aruco.ArucoDetector(get_dictionary(dictionary), parameters)

    def detect(self, frame):
        """The tags in a frame, a list of Tag in the order in which they were found.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8.
        """
        return self._fitted(frame, *self._find(self._anywhere, frame))

    def search(self, frame, side):
        """The same for tags at least ``side`` pixels wide, in a fraction of the time."""
        shrink = min(1.0, SEARCH_SIDE_PX / side)
        small = frame if shrink == 1 else cv2.resize(frame, None, fx=shrink, fy=shrink)
        ids, quads = self._find(self._of_a_size, small)
        # The middle of the first pixel is (0, 0), before and after shrinking.
        return self._fitted(frame, ids, (quads + 0.5) / shrink - 0.5)

    def fit(self, frame, ids, quads):
        """Put quadrilaterals, (n, 4, 2), onto the tags with those ids: see fit_tags."""
        for tag_id in ids:
            if tag_id not in self._cells:
                self._cells[tag_id] = tag_cells(self._dictionary, tag_id)
        return fit_tags(frame, quads, np.array([self._cells[tag_id] for tag_id in ids]))

    def _find(self, detector, frame):
        gray = frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        corners, ids, _ = detector.detectMarkers(gray)
        found = [] if ids is None else [
            (int(tag_id), quad.reshape(4, 2)) for tag_id, quad in zip(ids.ravel(), corners)
            if not self._ids or int(tag_id) in self._ids]
        return [tag_id for tag_id, _ in found], np.float32([quad for _, quad in found])

    def _fitted(self, frame, ids, quads):
        """Tags, fitted to their edges where those can be seen."""
        if not ids:
            return []
        fitted, _, likeness = self.fit(frame, ids, quads)
        return [Tag(tag_id, quad) for tag_id, quad, alike in zip(ids, fitted, likeness)
                if alike > MIN_LIKENESS]
