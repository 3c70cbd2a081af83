"""Says whether the learner's function is slower than a camera."""
from __future__ import annotations

from aruco_course.check import Fault

from .trial import Trial

TIMES = 30     # how many times longer than OpenCV's search for tags it may take
SECONDS = 0.1  # and what no machine's camera minds


def fault_of_speed(trial: Trial) -> Fault | None:
    """A function that takes much longer than the camera needs for its next frame, or None."""
    seconds = trial.call_seconds
    if not trial.baseline_seconds or seconds <= SECONDS or seconds <= TIMES * trial.baseline_seconds:
        return None
    return Fault('it is right, but slower than the camera: a frame takes %.2f seconds, and OpenCV finds the '
                 'tags in %.3f. Leave out what waits (sleep, waitKey), and let NumPy or OpenCV do what a loop '
                 'over the pixels does.' % (seconds, trial.baseline_seconds))
