"""Collecting views of a sheet from the frames of a camera, and showing what is still to be seen."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image

from .views import ALIKE, CELLS, MAX_VIEWS, MIN_POINTS, View, cells_of

SEEN_COLOR = np.array([90, 200, 60, 0.0])  # BGR, the tint of what was seen
SEEN_SHARE = 0.25
POINT_COLOR = (0, 220, 255)
STILL = 0.004  # of the frame: in a view of a sheet that moves faster, corners are blurred or late


class Collection:
    """The views of a sheet that differ from each other, and where in the frame they show it."""

    def __init__(self, size: tuple[int, int]) -> None:
        """``size``: (width, height) of the frames."""
        self.size = size
        self.views: list[View] = []
        self._kinds: list[Floats] = []
        self._before: Floats | None = None
        self._seen: Booleans = np.zeros(CELLS, bool)

    @property
    def coverage(self) -> float:
        """The share of the frame's cells in which a point was seen."""
        return float(self._seen.mean())

    def offer(self, view: View) -> bool:
        """Keep the View of the newest frame if it differs from the others, and the sheet is still."""
        if sum(map(len, view.points.values())) < MIN_POINTS:
            self._before = None
            return False
        kind, before = view.describe(self.size), self._before
        self._before = kind
        if before is None or np.linalg.norm(kind - before) > STILL or len(self.views) >= MAX_VIEWS:
            return False
        if self._kinds and np.linalg.norm(np.array(self._kinds) - kind, axis=1).min() < ALIKE:
            return False
        self.views.append(view)
        self._kinds.append(kind)
        self._seen |= cells_of([view], self.size)
        return True

    def draw(self, frame: Image, view: View) -> Image:
        """A frame, (h, w, 3) BGR uint8, with a tint where the sheet was seen, and the points of a View."""
        seen = cv2.resize(self._seen.T.astype(np.uint8), self.size, interpolation=cv2.INTER_NEAREST)
        tinted = cv2.add(cv2.convertScaleAbs(frame, alpha=1 - SEEN_SHARE), SEEN_SHARE * SEEN_COLOR)
        image = cv2.copyTo(tinted, seen, frame.copy())
        for points in view.points.values():
            for x, y in np.round(points).astype(int).tolist():
                cv2.circle(image, (x, y), 3, POINT_COLOR, -1, cv2.LINE_AA)
        return image
