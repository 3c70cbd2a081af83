"""The accuracy of the area, compared with the truth of a simulated camera of 640 x 480."""
from itertools import combinations
from multiprocessing import Pool

import cv2
import numpy as np
from aruco_ar import Tracker
from aruco_ar.base.progress import progress, tell
from rig.accuracy.drives import CYCLE, FAST, FRAMES_PER_S, LIVELY, SLOW, STILL, WALL, at_random, drive, in_turn

from benchmark.course import Course

WRONG = 0.05  # times the longer side of the area: if a corner is farther off, the area is wrong
USUAL = {'noise': 2.0, 'blur': 0.5, 'light': 0.3}


def _drive_with_covered(count):
    """A drive that covers each group of ``count`` tags, one group after the other."""
    groups = list(combinations(WALL.area, count))
    covered, counts = in_turn(groups)
    return drive(SLOW, 2 * CYCLE * len(groups), covered, counts, **USUAL)


# For each name, in the order of the table: a function that makes the frames, and the targets.
CASES = {
    'standing still, noise 5': (lambda: drive(STILL, 600, noise=5.0), 'spread 0.05, rms 0.30'),
    'driving 0.5 m/s, turning 0.5 rad/s': (lambda: drive(FAST, 1200, **USUAL), 'rms 0.70'),
    'one tag covered, 0.1 m/s': (lambda: _drive_with_covered(1), 'rms 0.60'),
    'two tags covered, 0.1 m/s': (lambda: _drive_with_covered(2), 'rms 1.20'),
    'three tags covered, 0.1 m/s': (lambda: _drive_with_covered(3), 'rms 5.00'),
    'each hidden 30 %, 0.1 m/s': (lambda: drive(SLOW, 1800, at_random(1800, 1), **USUAL), 'area 99.5 %'),
    'each hidden 30 %, lively drive': (lambda: drive(LIVELY, 1800, at_random(1800, 2), **USUAL), ''),
    'motion blur of 9 px': (lambda: drive(LIVELY, 420, noise=2.0, smear=9), 'area 99 %'),
    'light falling to a quarter': (lambda: drive(LIVELY, 420, noise=2.0, light=0.75), 'area 99 %'),
    'JPEG of quality 50': (lambda: drive(LIVELY, 420, noise=2.0, quality=50), 'area 99 %'),
    'blur, light and JPEG at once': (
        lambda: drive(LIVELY, 420, noise=2.0, smear=9, light=0.75, quality=50), 'area 99 %'),
}
CHART_CASE = 'each hidden 30 %, 0.1 m/s'


def follow(frames):
    """Track the area by both methods. Returns stamps, true corners, the course's corners, ours, and counts.

    Corners are (n, 4, 2), NaN without an area. See Frame for the counts.
    """
    tracker, course = Tracker(), Course('DICT_6X6_250', None)
    rows = []
    for frame in frames:
        area, corners = tracker.update(frame.image, frame.stamp), course.area(frame.image)
        no_area = np.full((4, 2), np.nan)
        rows.append((frame.stamp, frame.corners, no_area if corners is None else corners,
                     no_area if area is None else area.corners, frame.counts))
    return tuple(np.array(column, np.float64) for column in zip(*rows))


def summarize(stamps, truth, corners, counts):
    """A dict of what the table shows about one method in one case."""
    counts = counts > 0
    error = np.linalg.norm(corners - truth, axis=2)                      # (n, 4)
    found = ~np.isnan(error[:, 0])
    longer = np.linalg.norm(truth - np.roll(truth, 1, axis=1), axis=2).max(axis=1)
    result = {'frames': len(stamps), 'share': found[counts].mean(),
              'wrong': int(np.sum(error[found].max(axis=1) > WRONG * longer[found])),
              'rms': np.nan, 'spread': np.nan, 'lag': (np.nan, np.nan)}
    used = found & counts
    if used.any():
        result['rms'] = np.sqrt(np.mean(error[used]**2))
        result['spread'] = corners[used].std(axis=0).max()
        # By how many milliseconds the corners lag behind the truth, along its motion.
        speed = np.gradient(truth, 1 / FRAMES_PER_S, axis=0)
        behind = ((truth - corners) * speed).sum(axis=(1, 2)), (speed * speed).sum(axis=(1, 2))
        third = len(stamps) // 3
        result['lag'] = tuple(1000 * np.nansum(behind[0][part]) / max(np.sum(behind[1][part]), 1e-9)
                              for part in (slice(0, third), slice(-third, None)))
    return result


def measure(name):
    """Measure one case: (name, the course's summary, ours, series). Only CHART_CASE has a series."""
    cv2.setNumThreads(1)
    stamps, truth, course, ours, counts = follow(CASES[name][0]())
    series = (stamps, truth, course, ours) if name == CHART_CASE else None
    return (name, summarize(stamps, truth, course, counts), summarize(stamps, truth, ours, counts), series)


def run():
    """Measure all cases, and print the table. Returns the series of CHART_CASE."""
    print('\nSticking, 640 x 480: course | ours. Errors are in pixels, rms over the four corners. An area\n'
          'is wrong if a corner is off by more than 5 %% of its longer side.\n\n'
          '%-35s %-18s %7s   %-13s %-15s %-11s' % ('', 'at most / at least', 'frames', 'rms error',
                                                    'with an area', 'wrong'))
    series, total = None, {'frames': 0, 'course': 0, 'ours': 0}
    with Pool() as pool:
        for name, course, ours, case_series in progress(pool.imap(measure, CASES), 'sticking', len(CASES)):
            series = case_series or series
            total['frames'] += ours['frames']
            total['course'] += course['wrong']
            total['ours'] += ours['wrong']
            tell('%-35s %-18s %7d   %5s | %-5s %5.1f | %5.1f %%  %3d | %d' % (
                name, CASES[name][1], ours['frames'], _number(course['rms']), _number(ours['rms']),
                100 * course['share'], 100 * ours['share'], course['wrong'], ours['wrong']))
            if name.startswith('standing'):
                tell('%-35s %-18s %7s   %5s | %s' % ('  spread of the corners', '', '',
                                                    _number(course['spread']), _number(ours['spread'])))
            if name.startswith('driving'):
                tell('%-35s %-18s %7s   %s | %s ms' % (
                    '  lag, first and last third', '', '', '%.1f, %.1f' % course['lag'],
                    '%.1f, %.1f' % ours['lag']))
    print('%-35s %-18s %7d   %-13s %-15s %3d | %d' % ('all of the above', 'wrong 0', total['frames'], '',
                                                      '', total['course'], total['ours']))
    return series


def _number(value):
    return '-' if np.isnan(value) else '%.2f' % value
