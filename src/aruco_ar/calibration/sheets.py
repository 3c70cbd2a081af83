"""What a camera is calibrated with: a flat sheet of tags, or a ChArUco board."""
from __future__ import annotations

from itertools import product

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image, Integers
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.homography import transform
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import OFFICIAL, get_dictionary

from .views import MIN_POINTS, View

MIN_SIDE_PX = 20.0  # the corners of smaller tags are not exact enough
MAX_SQUARES = 50    # of a board, along a side
OFF = 0.1           # a tag of a board is where it belongs if it is off by less than this part of its side


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
        """The View of the sheet in a frame, (h, w, 3) BGR uint8. It may be printed white on black."""
        tags = [tag for tag in self._detector.detect(frame)
                if np.linalg.norm(tag.corners[1] - tag.corners[0]) >= MIN_SIDE_PX]
        ids = [tag.id for tag in tags]
        view = View({tag.id: np.asarray(tag.corners, np.float64) for tag in tags if ids.count(tag.id) == 1})
        return view if 4 * len(view.points) >= MIN_POINTS else View({})


class CharucoBoard:
    """Finds the inner corners of a ChArUco board, whatever the id is that its ids begin with.

    ``points``: where they are, in squares. ``needs``: what must be in sight.
    """

    def __init__(self, dictionary: str, columns: int, rows: int, ratio: float) -> None:
        """Raises InputError if there is no such dictionary, or if it has too few tags."""
        self.dictionary, table = dictionary, get_dictionary(dictionary)
        count, tags = columns * rows // 2, len(table.bytesList)
        if count > tags:  # OpenCV would make a board with tags that do not exist
            raise InputError('A board of %d x %d squares has %d tags, but %s only has %d. Give the dictionary '
                             'of the board.' % (columns, rows, count, dictionary, tags))
        self._table, self._squares, self._ratio = table, (columns, rows), ratio
        self._finder = cv2.aruco.ArucoDetector(table)
        # OpenCV before 4.6 began a board with an even number of rows with a white square.
        self._tags = [np.array(self._board(0, is_older).getObjPoints(), np.float64)[..., :2]
                      for is_older in ([False, True] if rows % 2 == 0 else [False])]
        # OpenCV 4 has AprilTags turned by 180 degrees, so it also draws boards with such tags.
        self._may_be_turned = [False, True] if dictionary.upper() in OFFICIAL else [False]
        self._detectors: dict[tuple[int, bool], cv2.aruco.CharucoDetector] = {}
        self._negated = False          # whether the last board was white on black
        self._kind = 0, False, False   # that of the last board: see _kind_of
        corners = np.array(self._board(0, False).getChessboardCorners(), np.float64)
        self.points = {number: corner[None, :2] for number, corner in enumerate(corners)}
        self.needs = '%d corners of a board of %d x %d squares with tags of %s, not all in a line' % (
            MIN_POINTS, columns, rows, dictionary)

    def view(self, frame: Image) -> View:
        """The View of the board in a frame, (h, w, 3) BGR uint8."""
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        for negated in self._negated, not self._negated:
            shown = cv2.bitwise_not(gray) if negated else gray
            quads, tag_ids, _ = self._finder.detectMarkers(shown)
            if tag_ids is not None:
                kind = self._kind_of(np.array(quads, np.float64).reshape(-1, 4, 2), np.ravel(tag_ids))
                first, is_older, is_turned = kind
                if is_turned:
                    quads = [np.roll(quad, 2, axis=1) for quad in quads]
                detector = self._detector(first, is_older)
                corners, ids, _, _ = detector.detectBoard(shown, None, None, quads, tag_ids)
                if ids is not None and len(ids) >= MIN_POINTS:
                    self._negated, self._kind = negated, kind
                    return View({int(number): np.asarray(corner, np.float64).reshape(1, 2)
                                 for number, corner in zip(np.ravel(ids), corners)})
        return View({})

    def _kind_of(self, quads: Floats, ids: Integers) -> tuple[int, bool, bool]:
        """The board for which most tags are where they belong: its first id, whether it is an older one, and
        whether its tags are turned by 180 degrees.

        ``quads``: (n, 4, 2) pixels of the tags with those ids. Boards of a set have ids one after the other.
        """
        best, most = self._kind, 0
        count, total = len(self._tags[0]), len(self._table.bytesList)
        firsts = {max(0, min(int(tag_id) - number, total - count)) for tag_id in ids for number in range(count)}
        likely = sorted(firsts, key=lambda first: (first != self._kind[0], first % count != 0, first))
        # If several fit as well, it is most likely drawn as the last one.
        drawn = sorted(product([False, True][:len(self._tags)], self._may_be_turned),
                       key=lambda drawn: drawn != self._kind[1:])
        for first in likely:
            is_own = (ids >= first) & (ids < first + count)
            for is_older, is_turned in drawn:
                if np.count_nonzero(is_own) > most:  # else it cannot be better
                    tags, seen = self._tags[is_older][ids[is_own] - first], quads[is_own]
                    fitting = _fitting(tags, np.roll(seen, 2, axis=1) if is_turned else seen)
                    if fitting > most:
                        best, most = (first, is_older, is_turned), fitting
        return best

    def _detector(self, first: int, is_older: bool) -> cv2.aruco.CharucoDetector:
        if (first, is_older) not in self._detectors:
            self._detectors[first, is_older] = cv2.aruco.CharucoDetector(self._board(first, is_older))
        return self._detectors[first, is_older]

    def _board(self, first: int, is_older: bool) -> cv2.aruco.CharucoBoard:
        """The board whose ids begin with ``first``. ``is_older``: as OpenCV before 4.6 drew it."""
        count = self._squares[0] * self._squares[1] // 2
        board = cv2.aruco.CharucoBoard(self._squares, 1.0, self._ratio, self._table,
                                       np.arange(first, first + count, dtype=np.int32))
        board.setLegacyPattern(is_older)
        return board


def _fitting(tags: Floats, quads: Floats) -> int:
    """How many tags are where they belong, as one plane sees them.

    ``tags``: (n, 4, 2), their corners on the board. ``quads``: (n, 4, 2), in the frame.
    """
    side = np.median(np.linalg.norm(quads[:, 1] - quads[:, 0], axis=1))
    there, _ = cv2.findHomography(tags.reshape(-1, 2), quads.reshape(-1, 2), cv2.RANSAC, OFF * side)
    if there is None:
        return 0
    off = np.linalg.norm(transform(np.asarray(there, np.float64), tags) - quads, axis=2).max(axis=1)
    return int(np.count_nonzero(off < 2 * OFF * side))
