"""Collecting views of a sheet from the frames of a camera, and showing what is still to be seen."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image

from .views import ALIKE, CELLS, MAX_VIEWS, View, cells_of, is_spread

SEEN_COLOR = np.array([90, 200, 60, 0.0])  # BGR, the tint of what was seen
SEEN_SHARE = 0.25
POINT_COLOR = (0, 220, 255)
STILL = 0.004  # of the frame: in a view of a sheet that moves faster, corners are blurred or late


# Why a view is not kept.
FEW = 'Too little of the sheet is in sight.'
MOVING = 'Hold the sheet still.'
LIKE = 'This view is like another one: move or tilt the sheet.'
FULL = 'No more than %d views are taken.' % MAX_VIEWS


class Collection:
    """The views of a sheet that differ from each other, and where in the frame they show it."""

    def __init__(self, size: tuple[int, int], board: dict[int, Floats] | None = None) -> None:
        """``size``: (width, height) of the frames. ``board``: see calibrate."""
        self.size = size
        self.views: list[View] = []
        self._board = board
        self._kinds: list[Floats] = []
        self._before: Floats | None = None
        self._seen: Booleans = np.zeros(CELLS, bool)

    @property
    def coverage(self) -> float:
        """The share of the frame's cells in which a point was seen."""
        return float(self._seen.mean())

    @property
    def is_full(self) -> bool:
        """Whether no more views are taken."""
        return len(self.views) >= MAX_VIEWS

    def offer(self, view: View) -> str:
        """Keep the View of the newest frame if it differs from the others, and the sheet is still.

        Returns a sentence that says why it is not kept, or an empty text.
        """
        if not is_spread(view, self._board):
            self._before = None
            return FEW
        kind, before = view.describe(self.size), self._before
        self._before = kind
        if self.is_full:
            return FULL
        if before is None or np.linalg.norm(kind - before) > STILL:
            return MOVING
        if self._kinds and np.linalg.norm(np.array(self._kinds) - kind, axis=1).min() < ALIKE:
            return LIKE
        self.views.append(view)
        self._kinds.append(kind)
        self._seen |= cells_of([view], self.size)
        return ''

    def draw(self, frame: Image, view: View) -> Image:
        """A frame, (h, w, 3) BGR uint8, with a tint where the sheet was seen, and the points of a View."""
        seen = cv2.resize(self._seen.T.astype(np.uint8), self.size, interpolation=cv2.INTER_NEAREST)
        tinted = cv2.add(cv2.convertScaleAbs(frame, alpha=1 - SEEN_SHARE), SEEN_SHARE * SEEN_COLOR)
        image = cv2.copyTo(tinted, seen, frame.copy())
        for points in view.points.values():
            for x, y in np.round(points).astype(int).tolist():
                cv2.circle(image, (x, y), 3, POINT_COLOR, -1, cv2.LINE_AA)
        return image
