"""The program whose instructions are counted: program.py track FOLDER FRAMES, or kernels FOLDER 0."""
import sys

import aruco_program  # noqa: F401  before NumPy and OpenCV
import cv2
import numpy as np
from aruco_ar import Area, Detector, Lens, PoseEstimator, Tracker, overlay
from aruco_ar.compiled import binding
from aruco_ar.looks.hidden_tags import HiddenTags

REPEATS = 3
POSES = 10  # frames, so that the wall is learned in the first ones


def track(frames):
    """The tracker alone."""
    tracker = Tracker()
    for number, frame in enumerate(frames):
        tracker.update(frame, number / 30)


def kernels(frames):
    """Each kernel in C that works on pixels, and the poses, some times each."""
    random = np.random.RandomState(1)
    picture = random.randint(0, 256, (240, 320, 3)).astype(np.uint8)
    frame = frames[0]
    height, width = size = frame.shape[:2]
    area = Area(np.float32([[0.2, 0.2], [0.7, 0.1], [0.8, 0.9], [0.3, 0.7]] * np.float32([width, height])))
    look, usable = frame.astype(np.float32), np.ones(size, bool)
    variance, whole = np.full(size, 4, np.float32), np.ones(3, np.float32)
    detector, estimator, hidden = Detector(), PoseEstimator(), HiddenTags()
    matrix = np.float64([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1]])
    lens = Lens(width, height, matrix, np.zeros(5))
    for _ in range(REPEATS):
        tags = detector.detect(frame)
        overlay(frame, picture, area)
        hidden.hide(frame, frame.copy(), area, tags, True, False)
        _, planes = binding.compare_wall(frame, look, whole, np.zeros_like(frame), variance, usable, 0.3, 2.5)
        binding.learn_wall(frame, whole, planes, usable, usable, 0.03, 30, 0.1, 0.1, look, variance,
                           np.ones(size, bool), np.ones(size, np.float32))
    for number in range(POSES):
        estimator.update(tags, lens, number / 30)


def main():
    cv2.setNumThreads(1)
    part, folder, count = sys.argv[1:]
    frames = np.load(folder + '/frames.npy')
    track(frames[:int(count)]) if part == 'track' else kernels(frames)


if __name__ == '__main__':
    main()
