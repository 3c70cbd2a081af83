"""Whether a calibration fits the tags: a camera of another focal length cannot see flat squares in this way."""
from __future__ import annotations

from functools import partial
from typing import Callable, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.geometry.homography import transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.tags.tag import Tag

from .calibrate import pose_error
from .collection import STILL
from .sheet_layout import learn_layout
from .views import ALIKE, MIN_POINTS, View

EVERY_S = 0.3           # at most one frame is considered within this time
CHECKED = 12, 18, 24    # numbers of different views at which the lens is checked
# A lens does not fit if it puts the tags off by more than OFF_PX, and FACTOR times as far as any camera would.
OFF_PX, FACTOR = 0.6, 2.5


class LensCheck:
    """Collects views of tags, and compares two errors: with the lens, and with any camera at all.

    A homography shows how well any pinhole camera can see the tags in one plane. If the lens fits much worse,
    it is wrong. Tags that are not in one plane fit neither, so there is no hint about them. Only views of a
    still camera count: while it turns, a rolling shutter shows squares as no lens does.
    """

    def __init__(self) -> None:
        self._reset(None)

    def _reset(self, lens: Lens | None) -> None:
        self._lens = lens
        self._before: Floats | None = None  # what the last frame shows: see View.describe
        self._result: tuple[Lens | None, str | None] = lens, None
        self._collect()

    def _collect(self) -> None:
        self._views: list[View] = []
        self._kinds: list[Floats] = []
        self._considered = -np.inf
        self._checks = 0

    @property
    def hint(self) -> str | None:
        """A sentence about the lens of the last frame, if it does not fit."""
        lens, hint = self._result
        return hint if lens is self._lens else None

    def update(self, stamp: float, tags: Sequence[Tag], lens: Lens | None) -> Callable[[], None] | None:
        """Take in a frame at a time, seconds, with tags of the same size, and its Lens, if it is known.

        Returns None or, if there are enough new views, a function that compares the errors. This takes some
        tenths of a second; it may be called in another thread, and changes the hint.
        """
        if lens is not self._lens:
            self._reset(lens)
        if lens is not None and self._checks == len(CHECKED) and self.hint:
            self._collect()  # a later check may withdraw the hint
        if lens is None or self._checks == len(CHECKED):
            return None
        ids = [tag.id for tag in tags]
        view = View({tag.id: np.asarray(tag.corners, np.float64) for tag in tags if ids.count(tag.id) == 1})
        before, self._before = self._before, None
        if 4 * len(view.points) < MIN_POINTS:
            return None
        kind = self._before = view.describe((lens.width, lens.height))
        if before is None or np.linalg.norm(kind - before) > STILL or 0 <= stamp - self._considered < EVERY_S:
            return None
        self._considered = stamp
        if any(np.linalg.norm(other - kind) < ALIKE for other in self._kinds):
            return None
        self._views.append(view)
        self._kinds.append(kind)
        if len(self._views) < CHECKED[self._checks]:
            return None
        self._checks += 1
        return partial(self._check, lens, list(self._views))

    def _check(self, lens: Lens, views: Sequence[View]) -> None:
        self._result = lens, hint_of(*misfit(lens, views))


def hint_of(with_lens: float, at_best: float) -> str | None:
    """A sentence for the user if these errors, pixels, show a wrong lens, or None: see misfit."""
    if with_lens < max(OFF_PX, FACTOR * at_best):
        return None
    off = 'The tags are off by %.1f px; a correct calibration would leave %.1f px.' % (with_lens, at_best) \
        if np.isfinite(with_lens) else 'With it, the tags could not be seen where they are.'
    return 'The calibration does not fit this camera, so poses are wrong. %s Calibrate it with ' \
           'calibrate_live.launch.' % off


def misfit(lens: Lens, views: Sequence[View]) -> tuple[float, float]:
    """By how many pixels tags in one plane are off: seen through the lens, and through any pinhole camera.

    The first number is inf if the lens cannot see most of the tags where they are.
    """
    straight = [{tag_id: lens.undistort(corners) for tag_id, corners in view.points.items()} for view in views]
    visible = [{tag_id: corners for tag_id, corners in view.items() if np.all(np.isfinite(corners))}
               for view in straight]
    if 2 * sum(map(len, visible)) < sum(map(len, straight)):
        return np.inf, 0.0
    layout = learn_layout([view for view in visible if view])
    errors = []
    for view, undistorted in zip(views, visible):
        ids = [tag_id for tag_id in undistorted if tag_id in layout]
        if ids:
            sheet = np.concatenate([layout[tag_id] for tag_id in ids])
            pixels, flat = (np.concatenate([points[tag_id] for tag_id in ids])
                            for points in (view.points, undistorted))
            seen = transform(np.asarray(cv2.findHomography(sheet, flat)[0], np.float64), sheet)
            errors.append((pose_error(lens, sheet, pixels),
                           np.sqrt(np.mean(np.sum((seen - flat)**2, axis=1)))))
    known = np.array([each for each in errors if np.all(np.isfinite(each))]).reshape(-1, 2)
    if 2 * len(known) < len(views):
        return np.inf, 0.0
    with_lens, at_best = np.median(known, axis=0)  # a few views may be blurred, or of tags that have moved
    return float(with_lens), float(at_best)
