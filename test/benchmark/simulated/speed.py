"""Milliseconds per frame on one thread; both methods take turns on the same frames."""
import os
import time
from itertools import product

import cv2
import numpy as np
from aruco_ar import Tracker, load_picture, overlay
from aruco_ar.base.progress import progress, tell
from rig import PACKAGE
from rig.accuracy.drives import WIDE, drive

from benchmark.course import Course
from benchmark.looks import cost

# For each size of the frames: how many there are, and how many times faster ours should be.
SIZES = {(640, 480): (90, 5), (1280, 720): (60, 8), (1920, 1080): (60, 10), (3840, 2160): (40, 8)}


def timed(function, *arguments):
    """(milliseconds that the call took, what it returned)."""
    start = time.perf_counter()
    result = function(*arguments)
    return 1000 * (time.perf_counter() - start), result


def measure(size, count, noise):
    """Measure the milliseconds of each frame but the first.

    Returns four rows: the course's code, ours, and both again without painting.
    """
    picture = load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg'))
    course, tracker = Course('DICT_6X6_250', picture), Tracker()
    times = []
    for frame in drive(WIDE, count, noise=noise, light=0.3, size=size):
        own = frame.image.copy()  # ours paints in place, as in a node
        finding, _ = timed(course.area, frame.image)
        whole, _ = timed(course.paint, frame.image)
        tracking, area = timed(tracker.update, own, frame.stamp)
        painting, _ = timed(overlay, own, picture, area, own)
        times.append((whole, tracking + painting, finding, tracking))
    return np.array(times[1:]).T


def run():
    """Measure all sizes, and print the table."""
    cv2.setNumThreads(1)
    print('\nSpeed on one thread, milliseconds per frame (medians): course | ours. The picture is a photo\n'
          'of 960 x 640.\n\n'
          '%-12s %-7s %8s   %-26s %-26s %s' % ('frame', 'noise', 'at least', 'frame to painted frame',
                                              'tags and area only', 'ours, 99th percentile'))
    for size, noise in progress(list(product(SIZES, (5.0, 2.0))), 'speed'):
        count, target = SIZES[size]
        whole, ours, finding, tracking = measure(size, count, noise)
        tell('%-12s %-7g %7dx   %6.2f | %5.2f = %5.1fx    %6.2f | %5.2f = %5.1fx    %6.2f' % (
            '%d x %d' % size, noise, target, np.median(whole), np.median(ours),
            np.median(whole) / np.median(ours), np.median(finding), np.median(tracking),
            np.median(finding) / np.median(tracking), np.percentile(ours, 99)))
    cost.run()
