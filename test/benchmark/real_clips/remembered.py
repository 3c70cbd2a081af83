"""A real wall that is remembered: its four tags are blacked out in a clip, and it has to be found again."""
import os
import tempfile
from dataclasses import replace

import cv2
import numpy as np
from aruco_ar import InputError, Tracker
from aruco_ar.base.progress import progress, tell
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.tracking.area_tracker import AreaTracker
from aruco_ar.tracking.tag_search import TagSearch
from aruco_ar.walls.remembered import load_remembered

from .clips import corners_by, errors_of
from .truth import truth_of

PAPER = 1.35       # width of what is blacked out, in sides of a tag
EVERY = 10         # the wall is saved in every so many frames; the last file counts
STARTS = 20        # times at which a tracker starts to search
FIND_S, RUN_S = 1.0, 3.0  # the time in which it should find the wall, and that for which it follows it


def teach(clip, frames, rate, folder):
    """Have a tracker learn the wall of a clip, and write it to a file.

    Only the four tags are remembered as tags: others that lie on the sheet are but texture. Returns the path of
    the file, the {id: (4, 2)} places of the four, and the corners of the area in each frame, (n, 4, 2), NaN if
    not known. The path is None if the wall's look was never known.
    """
    tracker, path, places = Tracker(clip.dictionary, clip.ids), None, {}
    corners = np.full((len(frames), 4, 2), np.nan)
    for number, frame in enumerate(frames):
        area = tracker.update(frame, number / rate)
        if area is not None:
            corners[number] = area.corners
        if number % EVERY and number < len(frames) - 1:
            continue
        try:
            learned = tracker.learned()
        except InputError:
            continue
        if learned.look is not None:
            places = {tag_id: learned.places[tag_id] for tag_id in learned.ids}
            path = os.path.join(folder, 'wall.npz')
            replace(learned, places=places).remembered(clip.dictionary, 1.0).save(path)
    return path, places, corners


def taken_down(frame, corners, places):
    """A copy of a frame in which tags are black. ``places``: {id: (4, 2)}.

    ``corners``: (4, 2), the area's. Whichever comes first, the same squares become black.
    """
    frame = frame.copy()
    for place in places.values():
        paper = transform(homography_to(corners), place.mean(axis=0) + PAPER * (place - place.mean(axis=0)))
        cv2.fillConvexPoly(frame, np.round(paper).astype(np.int32), (0, 0, 0))
    return frame


def without_tags(frames, corners, places):
    """The frames with black instead of their four tags, and which of them these are, (m,).

    ``corners``: (n, 4, 2), the area's, NaN if not known. Such frames are left out.
    """
    known = np.flatnonzero(~np.isnan(corners).any(axis=(1, 2)))
    return [taken_down(frames[number], corners[number], places) for number in known], known


class Searching:
    """A tracker that knows a wall from a file, and tells what each frame costs."""

    def __init__(self, clip, path):
        self._search = TagSearch(clip.dictionary)
        self._tracker = AreaTracker(clip.ids, wall=load_remembered(path, clip.dictionary, 1.0))

    def corners(self, frame, stamp):
        """(4, 2): the area's corners, NaN without an area."""
        return corners_by(self._tracker, self._search, frame, stamp)


def find_again(clip, path, frames, stamps, truth, starts=STARTS):
    """(found, errors): whether the wall was found in time after each start, and the errors, (n, 4) pixels."""
    found, errors = [], []
    for start in np.linspace(stamps[0], stamps[-1] - FIND_S, starts):
        searching = Searching(clip, path)
        numbers = np.flatnonzero((stamps >= start) & (stamps < start + RUN_S))
        corners = np.array([searching.corners(frames[number], stamps[number]) for number in numbers])
        is_shown = ~np.isnan(corners[:, 0, 0])
        found.append(is_shown[stamps[numbers] <= stamps[numbers[0]] + FIND_S].any())
        off = np.linalg.norm(errors_of(corners, truth[numbers]), axis=2)
        errors.append(off[~np.isnan(truth[numbers, 0, 0])])
    return found, np.concatenate(errors)


def measure(clip):
    """Print the row of a clip."""
    frames, rate = clip.frames()
    truth, _ = truth_of(frames, clip.dictionary, clip.ids, clip.lens(frames[0].shape[1::-1]))
    with tempfile.TemporaryDirectory() as folder:
        path, places, corners = teach(clip, frames, rate, folder)
        if path is None:
            tell('%-12s  its area is too small, or has too little texture' % os.path.basename(clip.path))
            return
        size = os.path.getsize(path) / 1024
        black, numbers = without_tags(frames, np.where(np.isnan(truth), corners, truth), places)
        found, errors = find_again(clip, path, black, numbers / rate, truth[numbers])
    known = ~np.isnan(errors[:, 0])
    tell('%-12s %4.0f %7d %8d %8.1f %% %6.2f %6.1f' % (
        os.path.basename(clip.path), size, len(found), sum(found),
        100 * known.mean(), np.sqrt(np.mean(errors[known]**2)), errors[known].max()))


def run(clips):
    """Print the table of some Clips."""
    print('\nA wall that is remembered: its four tags are black from the first frame on. The tracker starts\n'
          'at several times, and knows the wall from a file. Found: within %g s. Shown: in the %g s after a\n'
          'start, the search included. Errors are in pixels.\n\n%-12s %4s %7s %8s %10s %6s %6s'
          % (FIND_S, RUN_S, '', 'kB', 'starts', 'found', 'shown', 'rms', 'worst'))
    for clip in progress(clips, 'clips'):
        measure(clip)
