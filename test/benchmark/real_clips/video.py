"""Both methods on any video."""
import os

import cv2
import numpy as np
from aruco_ar import InputError, Tracker, load_picture, overlay
from aruco_ar.base.progress import progress
from rig import PACKAGE

from benchmark.course import Course
from benchmark.report.chart import draw, jitter
from benchmark.simulated.speed import timed

from . import clips

USUAL_FRAMES_PER_S = 30.0  # if a video does not say


def run(path, dictionary, ids, chart):
    """Measure both methods, print the results, and draw the chart. Raises InputError if it is not a video."""
    if ids:
        print(clips.HEAD)
        clips.measure(clips.Clip(path, dictionary, ids))
    cv2.setNumThreads(1)
    video = cv2.VideoCapture(path)
    if not video.isOpened():
        raise InputError('OpenCV cannot read "%s" as a video.' % path)
    rate = video.get(cv2.CAP_PROP_FPS)
    rate = rate if 1 <= rate <= 1000 else USUAL_FRAMES_PER_S
    picture = load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg'))
    course, tracker = Course(dictionary, picture, ids), Tracker(dictionary, ids)
    times, corners = {'course': [], 'ours': []}, {'course': [], 'ours': []}
    no_area = np.full((4, 2), np.nan)
    count = max(int(video.get(cv2.CAP_PROP_FRAME_COUNT)), 0)  # as the file says, which may be wrong
    for frame in progress(_frames(video), 'frames', count):
        took, (_, found) = timed(course.paint, frame)
        times['course'].append(took)
        corners['course'].append(no_area if found is None else found)
        tracking, area = timed(tracker.update, frame, len(corners['ours']) / rate)
        painting, _ = timed(overlay, frame, picture, area, frame)
        times['ours'].append(tracking + painting)
        corners['ours'].append(no_area if area is None else area.corners)
    if not times['ours']:
        raise InputError('The video "%s" has no frames.' % path)
    stamps = np.arange(len(times['ours'])) / rate
    corners = {name: np.float64(rows) for name, rows in corners.items()}
    print('\n%s: %d frames, %g per second\n\n%-8s %18s %16s %22s' % (
        path, len(stamps), rate, '', 'ms/frame, median', '99th percentile', 'frames with an area'))
    for name, took in times.items():
        has_area = ~np.isnan(corners[name][:, 0, 0])
        print('%-8s %18.2f %16.2f %20.1f %%' % (name, np.median(took),
                                                np.percentile(took, 99), 100 * has_area.mean()))
    both = ~np.isnan(corners['course'][:, 0, 0] + corners['ours'][:, 0, 0])
    if both.any():
        course, ours = (np.median(np.array(times[name])[both]) for name in ('course', 'ours'))
        print('where both find an area: %.2f and %.2f ms, %.1fx' % (course, ours, course / ours))
    print('\njitter (second difference of the corners, in pixels), mean and 95th percentile:')
    for name in times:
        moved = jitter(corners[name])
        moved = moved[~np.isnan(moved)]
        if len(moved):
            print('%-8s %.2f, %.2f over %d frames' % (name, moved.mean(), np.percentile(moved, 95), len(moved)))
        else:
            print('%-8s never finds the area in three frames in a row' % name)
    draw(chart, os.path.basename(path), stamps, corners['course'], corners['ours'])
    print('\nWrote %s' % chart)


def _frames(video):
    good, frame = video.read()
    while good:
        yield frame
        good, frame = video.read()
