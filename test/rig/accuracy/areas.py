"""The tracker on simulated drives, and how far off its area is."""
import numpy as np

USUAL = {'noise': 2.0, 'blur': 0.5, 'light': 0.3}


def later(frames, seconds):
    """The same frames, shifted to a later time."""
    return [frame._replace(stamp=frame.stamp + seconds) for frame in frames]


def follow(tracker, frames):
    """(n, 4) pixels: how far off each corner of the area is, or NaN without an area."""
    errors = []
    for frame in frames:
        area = tracker.update(frame.image, frame.stamp)
        errors.append(np.full(4, np.nan) if area is None
                      else np.linalg.norm(area.corners - frame.corners, axis=1))
    return np.array(errors)


def rms(errors):
    return np.sqrt(np.mean(errors**2))


def assert_never_wrong(errors, frames):
    """Assert that no corner is off by more than 5 % of the area's longer side."""
    for error, frame in zip(errors, frames):
        longer = np.linalg.norm(frame.corners - np.roll(frame.corners, 1, axis=0), axis=1).max()
        assert np.isnan(error[0]) or error.max() < 0.05 * longer
