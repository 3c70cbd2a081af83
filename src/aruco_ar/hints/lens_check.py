"""Whether a calibration fits the tags: a camera of another focal length cannot see flat squares in this way."""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from aruco_ar.calibration.calibrate import ALIKE, MIN_POINTS, View, pose_error
from aruco_ar.calibration.layout import learn_layout
from aruco_ar.geometry.homography import transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.tags.tag import Tag

EVERY_S = 0.3           # one frame in so many seconds is considered
CHECKED = 12, 18, 24    # numbers of different views at which the lens is checked
OFF_PX, FACTOR = 0.6, 2.5  # it does not fit if tags are off by more, and by so many times more than need be


class LensCheck:
    """Collects views of tags, and compares two errors: with the lens, and with any camera at all.

    A homography shows how well the tags fit a plane that any pinhole sees. If the plane with the lens fits much
    worse, the lens is wrong. Tags that are not in one plane fit neither, so nothing is said of them.

    ``hint``: a sentence, or None.
    """

    def __init__(self) -> None:
        self.hint: str | None = None
        self._lens: Lens | None = None
        self._begin()

    def _begin(self) -> None:
        self.hint = None
        self._views: list[View] = []
        self._considered = -np.inf
        self._checks = 0

    @property
    def is_due(self) -> bool:
        """Whether there are enough new views for ``check``."""
        return self._checks < len(CHECKED) and len(self._views) >= CHECKED[self._checks]

    def update(self, stamp: float, tags: Sequence[Tag], lens: Lens | None) -> None:
        """Take in a frame at a time, seconds, with tags of the same size, and its Lens, if it is known."""
        if lens is not self._lens:
            self._lens = lens
            self._begin()
        if lens is None or self.is_due or self._checks == len(CHECKED) or \
                0 <= stamp - self._considered < EVERY_S:
            return
        self._considered = stamp
        view = View({tag.id: np.asarray(tag.corners, np.float64) for tag in tags})
        if 4 * len(view.points) < MIN_POINTS:
            return
        size = lens.width, lens.height
        kind = view.describe(size)
        if all(np.linalg.norm(other.describe(size) - kind) >= ALIKE for other in self._views):
            self._views.append(view)

    def check(self) -> None:
        """Compare the errors. It takes some tenths of a second, and may be called in another thread."""
        lens, views = self._lens, list(self._views)
        self._checks += 1
        if lens is None:
            return
        with_lens, at_best = misfit(lens, views)
        fits = with_lens < max(OFF_PX, FACTOR * at_best)
        self.hint = None if fits else (
            'The calibration does not fit this camera: with it, the tags are off by %.1f px, and could be '
            'within %.1f px. So poses are wrong. Calibrate it with calibrate_live.launch.'
            % (with_lens, at_best))


def misfit(lens: Lens, views: Sequence[View]) -> tuple[float, float]:
    """By how many pixels tags in one plane are off: as the lens sees planes, and as any pinhole does."""
    straight = [{tag_id: lens.undistort(corners) for tag_id, corners in view.points.items()} for view in views]
    layout = learn_layout(straight)
    errors = []
    for view, undistorted in zip(views, straight):
        ids = [tag_id for tag_id in view.points if tag_id in layout]
        if ids:
            sheet = np.concatenate([layout[tag_id] for tag_id in ids])
            pixels, flat = (np.concatenate([points[tag_id] for tag_id in ids])
                            for points in (view.points, undistorted))
            seen = transform(np.asarray(cv2.findHomography(sheet, flat)[0], np.float64), sheet)
            errors.append((pose_error(lens, sheet, pixels),
                           np.sqrt(np.mean(np.sum((seen - flat)**2, axis=1)))))
    with_lens, at_best = np.sqrt(np.mean(np.square(errors), axis=0))
    return float(with_lens), float(at_best)
