"""Real clips, where they are shared beside the package: how the area sticks, against a truth of its own."""
import os

import pytest
import real


@pytest.mark.parametrize('name, least, rms, wobble', [
    ('board.mp4', 161, 0.40, 0.12), ('dark.mp4', 400, 0.35, 0.25)])
def test_it_sticks_and_is_never_wrong(name, least, rms, wobble):
    if not os.path.isdir(real.CLIPS):
        pytest.skip('no folder %s with clips' % os.path.normpath(real.CLIPS))
    clip, = (clip for clip in real.clips_of(real.CLIPS) if os.path.basename(clip.path) == name)
    ours = real.measure(clip)['ours']
    assert ours['area'] >= least and ours['wrong'] == ours['turned'] == 0
    assert ours['rms'] < rms and ours['wobble'] < wobble
