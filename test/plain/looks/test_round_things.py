"""Things that stand on a sheet from the first frame on come in front while the camera goes round it."""
import numpy as np
import pytest
from benchmark.looks import standing
from benchmark.looks.painter import Painter

pytestmark = pytest.mark.long


def shares_from(begin_s, ground, motion, things):
    """The shares that are kept of the things, and painted of the wall, in all frames from a time on."""
    painter = Painter(np.full((60, 90, 3), standing.PAINT, np.uint8), foreground='keep')
    sums = np.zeros(8)
    for moment in standing.moments(ground, motion, things):
        image = painter.paint(moment.frame, moment.stamp)[1]
        if moment.stamp >= begin_s:
            sums += standing.judge(moment, image)
    return sums[0] / sums[1], sums[2] / sums[3]


@pytest.mark.parametrize('ground, things, least_kept, least_painted', [
    ('plain', ('red box', 'gray stone', 'dark case'), 0.97, 0.98),
    ('wallpaper', ('red box',), 0.93, 0.98)])
def test_what_stands_there_is_in_front_once_the_camera_has_gone_half_round(ground, things, least_kept,
                                                                         least_painted):
    kept, painted = shares_from(5.0, ground, 'stills', things)
    assert kept > least_kept
    assert painted > least_painted


@pytest.mark.parametrize('ground', standing.GROUNDS)
def test_where_nothing_stands_all_of_a_sheet_is_painted_from_all_sides(ground):
    painter = Painter(np.full((60, 90, 3), standing.PAINT, np.uint8), foreground='keep')
    for moment in standing.moments(ground, 'stills', ()):
        image = painter.paint(moment.frame, moment.stamp)[1]
        assert np.mean(np.abs(image[moment.inside].astype(int) - standing.PAINT).max(axis=1) < 25) > 0.99
