"""Milliseconds a frame, one thread, both methods on the same frames in turn."""
import os
import time
from itertools import product

import cv2
import numpy as np
from aruco_ar import Tracker, load_picture, overlay
from aruco_ar.base.progress import progress, tell

from benchmark import PACKAGE
from benchmark.course import Course

from .drives import WIDE, drive

SIZES = {(640, 480): (90, 5), (1280, 720): (60, 8), (1920, 1080): (60, 10), (3840, 2160): (40, 8)}


def timed(work, *arguments):
    """(milliseconds, what it returns)."""
    start = time.perf_counter()
    result = work(*arguments)
    return 1000 * (time.perf_counter() - start), result


def measure(size, count, noise):
    """Milliseconds of each frame but the first, by name."""
    picture = load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg'))
    course, tracker = Course('DICT_6X6_250', picture), Tracker()
    times = []
    for frame in drive(WIDE, count, noise=noise, light=0.3, size=size):
        own = frame.image.copy()  # a node's frame is its own as well
        finding, _ = timed(course.area, frame.image)
        whole, _ = timed(course.paint, frame.image)
        tracking, area = timed(tracker.update, own, frame.stamp)
        painting, _ = timed(overlay, own, picture, area, own)
        times.append((whole, tracking + painting, finding, tracking))
    return np.array(times[1:]).T


def run():
    """Print the table."""
    cv2.setNumThreads(1)
    print('\nSpeed, one thread, milliseconds a frame (medians): course | ours. The picture is painted\n'
          'from a photo of 960 x 640.\n\n'
          '%-12s %-7s %8s   %-26s %-26s %s' % ('frame', 'noise', 'at least', 'frame in to painted out',
                                              'tags and area alone', 'ours, 99 % below'))
    for size, noise in progress(list(product(SIZES, (5.0, 2.0))), 'speed'):
        count, target = SIZES[size]
        whole, ours, finding, tracking = measure(size, count, noise)
        tell('%-12s %-7g %7dx   %6.2f | %5.2f = %5.1fx    %6.2f | %5.2f = %5.1fx    %6.2f' % (
            '%d x %d' % size, noise, target, np.median(whole), np.median(ours),
            np.median(whole) / np.median(ours), np.median(finding), np.median(tracking),
            np.median(finding) / np.median(tracking), np.percentile(ours, 99)))
