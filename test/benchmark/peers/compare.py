"""What each detector finds on the same frames, how exactly, and in which time."""
import os
from collections import Counter
from dataclasses import dataclass, field
from importlib import metadata

import cv2
import numpy as np
from aruco_ar.base.progress import progress, tell
from aruco_ar.tags.edges import side_of

from benchmark.real_clips.clips import CLIPS
from benchmark.simulated.search import PHOTOS
from benchmark.simulated.speed import timed

from .detectors import DEFAULT, detectors
from .scenes import DICTIONARIES, rendered, scenes_in

NEAR = 0.25       # times the mean side of a tag: it is found if no corner is farther off
MIN_SIGHTS = 3    # of a tag, for what is alike in all frames
MIN_TIMED = 20    # frames: those of smaller scenes are shown several times for the time
LINE = '%-19s%14s%10s%11s%11s%8s%8s%22s'
TEXT = '''Detectors on the same frames, in turns, on one thread: %s.
SUBPIX and APRILTAG are OpenCV's refinements of corners. AprilTag 3 is pupil-apriltags, with AprilTag's
defaults, and on the whole image instead of one of half the size. found: of the tags that are whole in the
frame; no corner may be off by more than a quarter of a side. other id: tags with ids that are not there.
elsewhere: tags with a right id in a wrong place, or found twice. Errors are those of corners, of tags that
OpenCV finds, too. steady: the same without what is alike for a corner in all frames. The time is the median.
'''


@dataclass
class Row:
    """The counts of a detector in a scene. ``errors``: a dict for each frame, see Judged."""

    took: list = field(default_factory=list)
    found: int = 0
    other_id: int = 0
    elsewhere: int = 0
    seen: int = 0
    errors: list = field(default_factory=list)


@dataclass
class Judged:
    """What a detector found in one frame.

    ``errors``: {number of the tag in the truth: (4, 2) pixels, or None where only the id is known}.
    """

    errors: dict
    other_id: int = 0
    elsewhere: int = 0


def whole(corners, frame):
    """Whether all of a tag is in the frame; a tag without known corners is."""
    return corners is None or bool(np.all((corners >= 0) & (corners <= np.array(frame.shape[1::-1]) - 1)))


def judge(found, truth, frame):
    """Judged: what was found in a frame, a list of (id, (4, 2) corners), against its Truth."""
    left, errors = list(found), {}
    for number, (tag_id, corners) in enumerate(truth.tags or ()):
        same = [(_error(corners, quad), index) for index, (other, quad) in enumerate(left) if other == tag_id]
        near = [(error, index) for error, index in same
                if corners is None or _lengths(error).max() <= NEAR * side_of(corners[None])[0]]
        if near:
            error, index = min(near, key=lambda each: 0 if corners is None else _lengths(each[0]).max())
            del left[index]
            if whole(corners, frame):
                errors[number] = error
    other_id = 0 if truth.ids is None else sum(tag_id not in truth.ids for tag_id, _ in left)
    return Judged(errors, other_id, 0 if truth.tags is None or truth.ids is None else len(left) - other_id)


def _error(corners, quad):
    """(4, 2) pixels: from each true corner to the nearest one of the quadrilateral, whose order may differ."""
    if corners is None:
        return None
    return quad[np.linalg.norm(corners[:, None] - quad, axis=2).argmin(axis=1)] - corners


def _lengths(errors):
    return np.linalg.norm(errors, axis=-1)


def measure(scene):
    """{detector: Row}, {detector: why there is none}, the number of tags, {by how many detectors: ids found}.

    The number of tags is None if nothing is known of them.
    """
    finders, missing = detectors(scene.dictionary)
    rows, tags, by_how_many = {name: Row() for name in finders}, 0, Counter()
    names, frames = list(finders), list(scene.frames)
    for find in finders.values():
        find(frames[0][0])  # what is prepared at the first call does not count
    for number, (frame, truth) in enumerate(progress(frames * -(-MIN_TIMED // len(frames)), scene.name)):
        seen = Counter()
        # Whoever comes first finds the frame outside of the cache.
        for name in names[number % len(names):] + names[:number % len(names)]:
            milliseconds, found = timed(finders[name], frame)
            row = rows[name]
            row.took.append(milliseconds)
            if number < len(frames):
                judged = judge(found, truth, frame)
                row.found += len(judged.errors)
                row.other_id += judged.other_id
                row.elsewhere += judged.elsewhere
                row.seen += len(found)
                row.errors.append(judged.errors)
                seen.update({tag_id for tag_id, _ in found})
        if number < len(frames):
            tags += sum(whole(corners, frame) for _, corners in truth.tags or ())
            by_how_many.update(seen.values())
    known = any(truth.tags is not None for _, truth in frames)
    return rows, missing, tags if known else None, by_how_many


def corner_errors(row, other):
    """{number of the tag: (n, 4, 2) pixels}: the errors of the corners where two Rows have both found it."""
    both = {}
    for errors, others in zip(row.errors, other.errors):
        for tag, error in errors.items():
            if tag in others and error is not None:
                both.setdefault(tag, []).append(error)
    return {tag: np.array(errors) for tag, errors in both.items()}


def _quantile(errors, part):
    return '%.2f' % np.quantile(np.concatenate([_lengths(each).ravel() for each in errors]), part) \
        if errors else '-'


def show(scene):
    """Print the lines of a scene."""
    rows, missing, tags, by_how_many = measure(scene)
    tell('\n%s, %s' % (scene.name, scene.dictionary))
    tell(LINE % ('', 'found', 'other id', 'elsewhere', 'median px', '95 %', 'steady', 'time'))
    default = np.median(rows[DEFAULT].took)
    for name, row in rows.items():
        errors = list(corner_errors(row, rows[DEFAULT]).values()) if scene.exact else []
        steady = [each - each.mean(axis=0) for each in errors if len(each) >= MIN_SIGHTS] if scene.plane else []
        took = np.median(row.took)
        counts = ('%d of %d' % (row.found, tags), row.other_id, row.elsewhere) if tags is not None else (
            row.seen, '-', '-')
        tell(LINE % ('  ' + name, *counts, _quantile(errors, 0.5), _quantile(errors, 0.95),
                     _quantile(steady, 0.5), '%.2f ms = %.2fx' % (took, took / default)))
    for name, why in missing.items():
        tell('%-19s%s' % ('  ' + name, why))
    if tags is None:
        tell('  ids found, by how many of the %d: %s' % (len(rows), ', '.join(
            '%d by %d' % (by_how_many[count], count) for count in sorted(by_how_many, reverse=True)) or 'none'))


def run(folders, dictionary):
    """Print the table of these folders, or of what is shared beside the package and what is simulated.

    ``dictionary``: of the tags in photos and clips without a NAME.yaml. Raises InputError.
    """
    cv2.setNumThreads(1)
    print(TEXT % _versions())
    for folder in folders or [each for each in (PHOTOS, CLIPS) if os.path.isdir(each)]:
        for scene in scenes_in(folder, dictionary):
            show(scene)
    if not folders:
        for each in DICTIONARIES:
            show(rendered(each))


def _versions():
    try:
        return 'OpenCV %s, pupil-apriltags %s' % (cv2.__version__, metadata.version('pupil-apriltags'))
    except metadata.PackageNotFoundError:
        return 'OpenCV %s' % cv2.__version__
