"""Both methods on real clips, compared with a truth that does not depend on the four tags of the area."""
import glob
import os
from dataclasses import dataclass
from typing import Optional

import cv2
import numpy as np
from aruco_ar import InputError, Tracker
from aruco_ar.base.files import yaml_entries
from aruco_ar.base.progress import progress, tell
from aruco_ar.settings.settings import HOLD_S
from aruco_ar.tracking.tag_search import FrameSearch
from aruco_ar.tracking.tracker import see_areas
from rig import PACKAGE

from benchmark.course import Course
from benchmark.simulated.speed import timed

from .jerks import with_jerks
from .truth import Camera, truth_of

CLIPS = os.path.join(PACKAGE, '..', 'shared', 'videos')
KNOWN = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'known')  # YAML files of published clips
CLIP_ENDINGS = '.mp4', '.avi', '.mov', '.mkv', '.webm'
USUAL_FRAMES_PER_S = 30.0  # if a video does not say
JERKED_FRAMES_PER_S = 15    # of a clip with jerks, about
WRONG = 0.05               # times the longer side of the area: if a corner is farther off, the area is wrong


@dataclass(frozen=True)
class Clip:
    """A video, and the four tags that span the area.

    ``camera``: its calibration, as in the YAML file. ``all_ids``: of all tags in it, () if not known.
    """

    path: str
    dictionary: str
    ids: tuple
    camera: Optional[dict] = None
    all_ids: tuple = ()

    def frames(self):
        """A list of all frames, (h, w, 3) BGR, and the frames per second. Raises InputError."""
        video = cv2.VideoCapture(self.path)
        rate = video.get(cv2.CAP_PROP_FPS)
        frames = []
        good, frame = video.read()
        while good:
            frames.append(frame)
            good, frame = video.read()
        if not frames:
            raise InputError('OpenCV cannot read "%s" as a video.' % self.path)
        return frames, rate if 1 <= rate <= 1000 else USUAL_FRAMES_PER_S

    def lens(self, size):
        """The Camera for frames of that size, (width, height) pixels, or None without a calibration."""
        if self.camera is None:
            return None
        scale = size[0] / self.camera['size'][0]
        fx, fy, cx, cy = (scale * number for number in self.camera['matrix'])
        return Camera(np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.float64(self.camera['distortion']))


@dataclass(frozen=True)
class Found:
    """The result of a method for the frames of a clip.

    ``took``: (n,) milliseconds. ``corners``: (n, 4, 2), NaN without an area.
    """

    took: np.ndarray
    corners: np.ndarray


def description_of(path):
    """The path of the NAME.yaml of a clip or photo, in its folder or in KNOWN; None if there is none."""
    name = os.path.splitext(os.path.basename(path))[0] + '.yaml'
    places = (os.path.join(folder, name) for folder in (os.path.dirname(path), KNOWN))
    return next((place for place in places if os.path.isfile(place)), None)


def clip_from(path, entries, ids):
    """The Clip of a path and the entries of its NAME.yaml. ``ids``: of the four tags that span the area."""
    return Clip(path, str(entries['dictionary']), tuple(ids), entries.get('camera'),
                tuple(map(int, entries.get('all_ids', ()))))


def clips_of(folder):
    """The Clips of a folder: the videos for which there is a NAME.yaml, in the folder or in KNOWN."""
    if not os.path.isdir(folder):
        raise InputError('There is no folder "%s" with clips.' % folder)
    found = []
    for path in sorted(glob.glob(os.path.join(folder, '*'))):
        description = description_of(path)
        if path.lower().endswith(CLIP_ENDINGS) and description:
            with yaml_entries(description) as entries:
                found.append(clip_from(path, entries, entries['ids']))
    if not found:
        raise InputError('The folder "%s" has no video with a NAME.yaml that gives its dictionary and ids.'
                         % folder)
    return found


def follow(clip, frames, rate):
    """Find the area by both methods. Returns Found of the course's and of ours."""
    cv2.setNumThreads(1)
    course, tracker = Course(clip.dictionary, None, clip.ids), Tracker(clip.dictionary, clip.ids)
    found, no_area = ([], []), np.full((4, 2), np.nan)
    for number, frame in enumerate(frames):
        took, corners = timed(course.area, frame)
        found[0].append((took, no_area if corners is None else corners))
        took, area = timed(tracker.update, frame, number / rate)
        found[1].append((took, no_area if area is None else area.corners))
    return tuple(Found(np.array([took for took, _ in each]), np.float64([corners for _, corners in each]))
                 for each in found)


def turned(corners, truth):
    """(n,): the quarter turns from the truth to the corners; NaN where either is unknown."""
    off = [np.linalg.norm(np.roll(corners, turn, axis=1) - truth, axis=2).sum(axis=1) for turn in range(4)]
    known = ~np.isnan(off[0])
    return np.where(known, np.argmin(np.nan_to_num(off), axis=0), np.nan)


def corners_by(tracker, search, frame, stamp):
    """(4, 2): the area's corners in a frame, by an AreaTracker with its TagSearch; NaN without an area."""
    seen, = see_areas([tracker], [HOLD_S], FrameSearch(search, frame, None), stamp)
    return np.full((4, 2), np.nan) if seen.area is None else seen.area.corners


def errors_of(corners, truth):
    """(n, 4, 2) pixels: the errors of the corners, whichever of them comes first."""
    turns = np.nan_to_num(turned(corners, truth)).astype(int)
    return np.array([np.roll(quad, turn, axis=0) for quad, turn in zip(corners, turns)]) - truth


def summary(found, truth, size):
    """A dict of what the table shows about one method.

    ``found``: Found. ``size``: of the frames, (width, height) pixels.
    """
    error = errors_of(found.corners, truth)
    length = np.linalg.norm(error, axis=2)                               # (n, 4)
    known = ~np.isnan(length[:, 0])
    inside = known[:, None] & np.all((truth >= 0) & (truth <= np.array(size) - 1), axis=2)
    longer = np.linalg.norm(truth - np.roll(truth, 1, axis=1), axis=2).max(axis=1)
    changes = np.linalg.norm(np.diff(error, axis=0), axis=2)
    changes = changes[~np.isnan(changes)]
    turns = turned(found.corners, truth)
    turns = turns[~np.isnan(turns)]
    return {'area': int((~np.isnan(found.corners[:, 0, 0])).sum()), 'compared': int(known.sum()),
            'rms': _rms(length[known]), 'inside': _rms(length[inside]),
            'wobble': _rms(changes),
            'worst': length[known].max() if known.any() else np.nan,
            'wrong': int(np.sum(length[known].max(axis=1) > WRONG * longer[known])),
            'turned': int(np.sum(np.diff(turns) != 0)), 'ms': float(np.median(found.took))}


def _rms(lengths):
    return np.sqrt(np.mean(lengths**2)) if lengths.size else np.nan


HEAD = '%-42s %-9s %5s %8s %6s %6s %6s %6s %6s %6s %7s' % (
    '', '', 'area', 'compared', 'rms', 'inside', 'wobble', 'worst', 'wrong', 'turned', 'ms')


def measure(clip, chart=None):
    """Measure both methods on a clip, and print its lines of the table. ``chart``: the PNG to draw, or None."""
    frames, rate = clip.frames()
    height, width = frames[0].shape[:2]
    truth, by = truth_of(frames, clip.dictionary, clip.ids, clip.lens((width, height)))
    course, ours = follow(clip, frames, rate)
    name = '%s, %d x %d, %d frames, by %s' % (os.path.basename(clip.path), width, height, len(frames), by)
    rows = _print_rows(name, (width, height), truth, course, ours)
    _print_rows('  with jerks of the camera', (width, height), *_with_jerks(clip, frames, truth, rate))
    if chart is not None:
        from benchmark.report.chart import draw  # needs matplotlib, which nothing else here does
        stamps = np.arange(len(frames)) / rate
        draw(chart, os.path.basename(clip.path), stamps, course.corners, ours.corners, truth)
    return rows


def _with_jerks(clip, frames, truth, rate):
    """The truth, and what both methods find, if the camera jerks; see jerks.py. Only smeared frames count."""
    step = max(round(rate / JERKED_FRAMES_PER_S), 1)
    jerked, corners, smeared = with_jerks(frames[::step], truth[::step])
    found = follow(clip, jerked, rate / step)
    return (np.where(smeared[:, None, None], corners, np.nan), *found)


def _print_rows(name, size, truth, course, ours):
    """Print the lines of both methods, and return what they show. ``size``: see summary."""
    rows = {'course': summary(course, truth, size), 'ours': summary(ours, truth, size)}
    for method, row in rows.items():
        tell('%-42s %-9s %5d %8d %6.2f %6.2f %6.2f %6.1f %6d %6d %7.2f%s' % (
            name if method == 'course' else '', method, row['area'], row['compared'], row['rms'], row['inside'],
            row['wobble'], row['worst'], row['wrong'], row['turned'], row['ms'],
            ' = 1/%.1f' % (rows['course']['ms'] / row['ms']) if method == 'ours' else ''))
    return rows


def run(folder, chart):
    """Print the table of all clips in a folder, and draw a chart of each.

    Returns the paths of the charts. Raises InputError.
    """
    clips = clips_of(folder)
    print('\nReal clips: tags and area, on one thread. Errors are in pixels. The truth does not depend on the\n'
          'four tags: it comes from the other tags of the plane, or from its texture. inside: the rms of\n'
          'the corners within the frame: nobody sees the others. wobble: the change of the error from\n'
          'frame to frame. wrong: a corner is off by more than 5 %% of the longer side.\n'
          'turned: the picture jumps by a quarter turn. With jerks: in each 16th frame, some 15 a second, the\n'
          'camera turns by 4.7 %% of the width in two frames, which smears them; only these are compared.\n\n%s'
          % HEAD)
    base, suffix = os.path.splitext(chart)
    charts = ['%s-%s%s' % (base, os.path.splitext(os.path.basename(clip.path))[0], suffix) for clip in clips]
    for clip, path in progress(list(zip(clips, charts)), 'clips'):
        measure(clip, path)
    return charts
