"""What a camera is calibrated with: a flat sheet of tags, or a ChArUco board."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import get_dictionary

from .views import MIN_POINTS, View

MIN_SIDE_PX = 20.0  # the corners of smaller tags are not exact enough
MAX_SQUARES = 50    # of a board, along a side


def read_board(text: str) -> tuple[int, int, float]:
    """(columns, rows, marker's side divided by the square's) of a text such as 5x7 or 5x7:0.5.

    Raises ValueError if it is no board.
    """
    size, _, share = text.partition(':')
    columns, rows = (int(part) for part in size.split('x'))
    ratio = float(share or 0.75)
    if min(columns, rows) < 2 or max(columns, rows) > MAX_SQUARES or not 0.1 < ratio < 1:
        raise ValueError
    return columns, rows, ratio


class TagSheet:
    """Finds the tags of a sheet.

    ``points``: None, since where they are on the sheet is not known. ``needs``: what must be in sight.
    """

    points = None

    def __init__(self, dictionary: str) -> None:
        """Raises InputError if there is no such dictionary."""
        self.dictionary = dictionary
        self._detector = Detector(dictionary)
        self.needs = 'two tags of %s, each at least %.0f px wide' % (dictionary, MIN_SIDE_PX)

    def view(self, frame: Image) -> View:
        """The View of the sheet in a frame, (h, w, 3) BGR uint8."""
        tags = [tag for tag in self._detector.detect(frame)
                if np.linalg.norm(tag.corners[1] - tag.corners[0]) >= MIN_SIDE_PX]
        ids = [tag.id for tag in tags]
        return View({tag.id: np.asarray(tag.corners, np.float64) for tag in tags if ids.count(tag.id) == 1})


class CharucoBoard:
    """Finds the inner corners of a ChArUco board.

    ``points``: where they are, in squares. ``needs``: what must be in sight.
    """

    def __init__(self, dictionary: str, columns: int, rows: int, ratio: float) -> None:
        """Raises InputError if there is no such dictionary, or if it has too few tags."""
        self.dictionary, table = dictionary, get_dictionary(dictionary)
        count, tags = columns * rows // 2, len(table.bytesList)
        if count > tags:  # OpenCV would make a board with tags that do not exist
            raise InputError('A board of %d x %d squares has %d tags, but %s only has %d. Give the dictionary '
                             'of the board.' % (columns, rows, count, dictionary, tags))
        board = cv2.aruco.CharucoBoard((columns, rows), 1.0, ratio, table)
        self._detectors = [cv2.aruco.CharucoDetector(board)]
        if rows % 2 == 0:  # OpenCV before 4.6 began such a board with a white square
            older = cv2.aruco.CharucoBoard((columns, rows), 1.0, ratio, table)
            older.setLegacyPattern(True)
            self._detectors.append(cv2.aruco.CharucoDetector(older))
        corners = np.array(board.getChessboardCorners(), np.float64)
        self.points = {number: corner[None, :2] for number, corner in enumerate(corners)}
        self.needs = '%d corners of a board of %d x %d squares with tags of %s, not all in a line' % (
            MIN_POINTS, columns, rows, dictionary)

    def view(self, frame: Image) -> View:
        """The View of the board in a frame, (h, w, 3) BGR uint8."""
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        for detector in self._detectors:
            corners, ids, _, _ = detector.detectBoard(gray)
            if ids is not None and len(ids) >= MIN_POINTS:
                self._detectors = [detector]  # the board has this pattern
                return View({int(number): np.asarray(corner, np.float64).reshape(1, 2)
                             for number, corner in zip(np.ravel(ids), corners)})
        return View({})
