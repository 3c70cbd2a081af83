"""A calibration that becomes better while a camera runs, and what is still missing."""
from __future__ import annotations

import threading
from typing import Callable

import numpy as np

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.hints.other_tags import OF_NODES, OtherTags

from .calibrate import calibrate, corners_apart
from .calibrated import GOOD_CORNERS_PX, Calibrated
from .collection import FEW, Collection
from .sheets import CharucoBoard, TagSheet
from .views import View

SHOW = ('Show the sheet to the camera, in all parts of its image, tilted to all sides, and hold still now and '
        'then.')


class CalibrationProgress:
    """The views of a sheet so far, and the best lens that they have told.

    ``collection``: the Collection. ``found``: the Calibrated, or None. ``why``: why the newest views tell no
    lens, if so. ``saved``: the Calibrated that was written into a file, or None. It stays when newer views tell
    another one.
    """

    def __init__(self, size: tuple[int, int], sheet: TagSheet | CharucoBoard) -> None:
        """``size``: (width, height) of the frames."""
        self.collection = Collection(size, sheet.points)
        self.found: Calibrated | None = None
        self.saved: Calibrated | None = None
        self.why = self._path = ''
        self._sheet = sheet
        self._refused = ''  # why the newest view is not kept
        self._others = OtherTags(sheet.dictionary, (), words=OF_NODES._replace(border=None))
        self._lock = threading.Lock()

    def update(self, frame: Image, stamp: float, view: View) -> Callable[[], None] | None:
        """Take in a frame, (h, w, 3) BGR uint8, with its time, seconds, and its View.

        Returns a search for other tags, or None: see OtherTags.
        """
        self._refused = self.collection.offer(view)
        return self._others.update(frame, stamp, set(), bool(view.points))

    def forget_last_frames(self) -> None:
        """Forget what is true only of the last frames."""
        self._refused = ''
        self._others.reset()

    def solve(self, count: int, fisheye: bool) -> None:
        """Calibrate with the first views. It takes some seconds; it may be called in another thread."""
        try:
            found = calibrate(self.collection.views[:count], self.collection.size, fisheye, self._sheet.points)
        except InputError as error:
            self.why = str(error)  # what was found before is still good
            return
        with self._lock:
            self.found, self.why = found, ''

    def note_saved(self, found: Calibrated, path: str) -> None:
        """The lens of ``found``, perhaps no longer the newest one, has been written into a file."""
        with self._lock:
            self.saved, self._path = found, path

    def text(self, save: str, reset: str) -> str:
        """What there is so far, and what to do, in sentences. ``save``, ``reset``: the commands for these."""
        with self._lock:
            found, why, saved, path = self.found, self.why, self.saved, self._path
        count = len(self.collection.views)
        views = '%d view%s, %.0f %% of the image.' % (count, 's' * (count > 1), 100 * self.collection.coverage)
        if found is None:
            if self.collection.is_full:
                return _joined(views, why, 'To begin anew: ' + reset if why else '')
            missing = why or (self._others.hint if not count else None) or SHOW
            return _joined(views if count else '', missing, self._advice())
        newer, is_better = _compared(saved, found)
        if saved and not is_better:
            found = saved
        ready = '%s The focal length is %.1f px, and points are off by %.2f px (%.2f px in views held out).' % (
            views, found.lens.matrix[0, 0], found.rms, found.held_out)
        if saved:
            again = 'To save the better one: ' + save if is_better else ''
            return _joined(ready, 'It is saved as %s.' % path, newer, again)
        if self.collection.is_full and (found.lacks() or why):
            return '%s Save it (%s), or begin anew (%s).' % (ready, save, reset)
        if why:
            return '%s With the newest views there is no better one. To save it: %s' % (ready, save)
        if found.lacks():
            return _joined(ready, found.lacks(), self._advice())
        return '%s To save it: %s' % (ready, save)

    def _advice(self) -> str:
        """Why the newest view is not kept."""
        if self._refused == FEW:
            return '%s A view needs %s.' % (FEW, self._sheet.needs)
        return self._refused


def _compared(saved: Calibrated | None, found: Calibrated) -> tuple[str, bool]:
    """What a newer lens is like beside the saved one, in a sentence, and whether it is worth saving, too."""
    if saved is None or saved is found:
        return '', False
    apart = float(corners_apart(saved.lens, found.lens).max())
    if apart <= GOOD_CORNERS_PX:
        return 'Newer views move the corners of the image by %.2f px, too little to matter.' % apart, False
    if found.corners >= saved.corners:
        return 'Newer views tell no better lens.', False
    saved_one = '%.1f px away from it' % apart if np.isfinite(apart) else 'far off'
    return 'Newer views tell a better lens: at the corners of the image it may be off by %.1f px, and the ' \
           'saved one is %s.' % (found.corners, saved_one), True


def _joined(*sentences: str) -> str:
    return ' '.join(sentence for sentence in sentences if sentence)
