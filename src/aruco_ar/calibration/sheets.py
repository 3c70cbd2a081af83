"""What a camera is calibrated with: a flat sheet of tags, or a ChArUco board."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import get_dictionary

from .views import View

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
    """Finds the tags of a sheet. ``points``: None, since where they are on the sheet is not known."""

    points = None

    def __init__(self, dictionary: str) -> None:
        """Raises InputError if there is no such dictionary."""
        self._detector = Detector(dictionary)

    def view(self, frame: Image) -> View:
        """The View of the sheet in a frame, (h, w, 3) BGR uint8."""
        tags = [tag for tag in self._detector.detect(frame)
                if np.linalg.norm(tag.corners[1] - tag.corners[0]) >= MIN_SIDE_PX]
        ids = [tag.id for tag in tags]
        return View({tag.id: np.asarray(tag.corners, np.float64) for tag in tags if ids.count(tag.id) == 1})


class CharucoBoard:
    """Finds the inner corners of a ChArUco board. ``points``: where they are, in squares."""

    def __init__(self, dictionary: str, columns: int, rows: int, ratio: float) -> None:
        """Raises InputError if there is no such dictionary, or if it has too few tags."""
        try:
            board = cv2.aruco.CharucoBoard((columns, rows), 1.0, ratio, get_dictionary(dictionary))
        except cv2.error:
            raise InputError('%s has too few tags for a board of %d x %d squares.'
                             % (dictionary, columns, rows)) from None
        self._detector = cv2.aruco.CharucoDetector(board)
        corners = np.array(board.getChessboardCorners(), np.float64)
        self.points = {number: corner[None, :2] for number, corner in enumerate(corners)}

    def view(self, frame: Image) -> View:
        """The View of the board in a frame, (h, w, 3) BGR uint8."""
        corners, ids, _, _ = self._detector.detectBoard(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        return View({} if ids is None else {int(number): np.asarray(corner, np.float64).reshape(1, 2)
                                            for number, corner in zip(np.ravel(ids), corners)})
