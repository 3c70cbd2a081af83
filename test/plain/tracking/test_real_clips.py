"""Real clips, if they are beside the package: how well the area sticks, compared with a truth made for them."""
import os

import numpy as np
import pytest
from aruco_ar import Tracker
from benchmark.real_clips import clips as real
from benchmark.real_clips.truth import truth_of


@pytest.mark.clips
@pytest.mark.parametrize('name, least, rms, wobble', [
    ('board.mp4', 161, 0.40, 0.12), ('dark.mp4', 400, 0.35, 0.25)])
def test_the_area_sticks_and_is_never_wrong(name, least, rms, wobble):
    if not os.path.isdir(real.CLIPS):
        pytest.skip('the folder %s with clips is missing' % os.path.normpath(real.CLIPS))
    clip, = (clip for clip in real.clips_of(real.CLIPS) if os.path.basename(clip.path) == name)
    frames, rate = clip.frames()
    truth, _ = truth_of(frames, clip.dictionary, clip.ids, clip.lens(frames[0].shape[1::-1]))
    tracker, corners = Tracker(clip.dictionary, clip.ids), np.full((len(frames), 4, 2), np.nan)
    for number, frame in enumerate(frames):
        area = tracker.update(frame, number / rate)
        if area is not None:
            corners[number] = area.corners
    ours = real.summary(real.Found(np.zeros(len(frames)), corners), truth)
    assert ours['area'] >= least and ours['wrong'] == ours['turned'] == 0
    assert ours['rms'] < rms and ours['wobble'] < wobble
