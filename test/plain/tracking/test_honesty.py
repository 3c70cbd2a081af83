"""How well the tracker claims to know the area's corners, compared with how far off they are.

A corner may be off by three times the deviation that the tracker claims, and by TRUTH_PX.
"""
import numpy as np
import pytest
from aruco_ar import Tracker
from rig.accuracy.areas import USUAL
from rig.accuracy.drives import FAST, LIVELY, SLOW, at_random, drive
from rig.accuracy.stills import IDS, stills

pytestmark = pytest.mark.long
TRUTH_PX = 0.3


def judged(tracker, frames):
    """(errors, claims), (n, 4) pixels each, of the frames with an area. ``frames``: (image, stamp, truth)."""
    errors, claims = [], []
    for image, stamp, truth in frames:
        area = tracker.update(image, stamp)
        if area is not None and truth is not None:
            errors.append(np.linalg.norm(area.corners - truth, axis=1))
            claims.append(tracker.deviation)
    return np.array(errors), np.array(claims)


@pytest.mark.parametrize('rim', [False, True], ids=['4 tags', '20 tags'])
def test_all_tags_in_sight_show_the_area_however_far_the_camera_has_moved(rim):
    lost, count = [], 0
    for seed in range(2):
        tracker, has_begun = Tracker(ids=IDS), False
        for frame, stamp, truth in stills(rim, seed):
            area = tracker.update(frame, stamp)
            has_begun |= area is not None
            if truth is None or not has_begun:
                continue
            count += 1
            if area is None:
                lost.append((seed, stamp, tracker.explanation))
                continue
            error = np.linalg.norm(area.corners - truth, axis=1)
            assert error.max() < 3
            assert np.all(error < 3 * tracker.deviation + TRUTH_PX)
    assert lost == [] and count > 50


@pytest.mark.parametrize('path, covered, look', [
    (SLOW, at_random(300, 1), USUAL), (LIVELY, at_random(300, 2), USUAL), (FAST, at_random(300, 3), USUAL),
    (FAST, lambda number: (), USUAL), (LIVELY, at_random(300, 4), {'hand': 1.0, **USUAL}),
    (SLOW, lambda number: [1, 2, 3] if number > 60 else (), USUAL)],
    ids=['slow', 'lively', 'fast', 'fast, all in sight', 'by hand', 'one tag'])
def test_a_corner_is_rarely_off_by_more_than_it_is_said_to_be(path, covered, look):
    frames = ((frame.image, frame.stamp, frame.corners) for frame in drive(path, 200, covered, **look))
    errors, claims = judged(Tracker(), frames)
    assert len(errors) > 180
    assert np.mean(np.any(errors > 3 * claims + TRUTH_PX, axis=1)) < 0.01


def test_tags_that_are_blurred_by_motion_are_known_less_exactly():
    drives = [drive(LIVELY, 60, noise=2.0, smear=smear) for smear in (1, 9)]
    sharp, blurred = [judged(Tracker(), ((frame.image, frame.stamp, frame.corners) for frame in frames))
                      for frames in drives]
    assert np.median(blurred[1]) > 2 * np.median(sharp[1])
    assert np.mean(np.any(blurred[0] > 3 * blurred[1] + TRUTH_PX, axis=1)) < 0.1
