"""Which frames are too old to be shown: few, and only if the node keeps up with its camera."""
import pytest
from aruco_ar.base.lateness import Lateness

PERIOD = 1 / 30


def stale_frames(lateness, ages, spent=0.4):
    """Whether each frame is stale. One arrives per period; its age and the time spent on it are in periods."""
    found = []
    for number, age in enumerate(ages):
        lateness.wait_for_next(number * PERIOD, (number + age - spent) * PERIOD, 0)
        found.append(lateness.is_stale((number + age) * PERIOD))
    return found


def test_frames_in_time_are_shown():
    assert not any(stale_frames(Lateness(), [0.5] * 100))


def test_a_stale_frame_is_not_shown():
    late = stale_frames(Lateness(), [0.5] * 50 + [1.8] + [0.5] * 20 + [2.5, 1.9] + [0.5] * 20)
    assert [number for number, is_stale in enumerate(late) if is_stale] == [50, 71, 72]


@pytest.mark.parametrize('ages', [[3, 4, 2, 10] * 50, [1e6] * 200, [-1e6] * 200])
def test_all_frames_are_shown_if_the_node_is_too_slow_or_the_clocks_differ(ages):
    assert not any(stale_frames(Lateness(), ages))


def test_all_frames_are_shown_soon_after_the_node_has_become_too_slow():
    late = stale_frames(Lateness(), [0.5] * 100 + [3] * 100)
    assert any(late[100:110]) and not any(late[120:])


def test_dropped_frames_do_not_lengthen_the_period():
    lateness = Lateness()
    for number in range(0, 300, 3):
        lateness.wait_for_next(number * PERIOD, (number + 0.5) * PERIOD, 2)
        assert not lateness.is_stale((number + 1) * PERIOD)
    lateness.wait_for_next(300 * PERIOD, 300.5 * PERIOD, 2)
    assert lateness.is_stale(302 * PERIOD)


def test_stamps_that_stand_still_or_go_back_make_no_frame_stale():
    for step in 0, -1:
        lateness = Lateness()
        for number in range(100):
            assert lateness.wait_for_next(100 + step * number, 100, 0) == 0
            assert not lateness.is_stale(100)


def test_a_busy_node_waits_for_the_next_frame_if_one_is_late():
    lateness = Lateness()
    stale_frames(lateness, [1.0] * 100, spent=0.9)
    assert lateness.wait_for_next(100 * PERIOD, 100.1 * PERIOD, 0) == 0
    assert lateness.wait_for_next(101 * PERIOD, 101.8 * PERIOD, 0) == pytest.approx(0.55 * PERIOD, rel=0.01)


def test_it_also_waits_if_all_frames_have_been_late_since_one_was_delayed():
    lateness = Lateness()
    stale_frames(lateness, [0.95] + [1.9] * 100, spent=0.95)
    assert lateness.wait_for_next(101 * PERIOD, 101.95 * PERIOD, 0) > 0


def test_it_does_not_wait_if_all_frames_arrive_late():
    lateness = Lateness()
    assert not any(stale_frames(lateness, [1.2] * 100, spent=0.5))
    assert lateness.wait_for_next(100 * PERIOD, 100.8 * PERIOD, 0) == 0


@pytest.mark.parametrize('ages, spent', [([0.5] * 100, 0.2), ([3.0] * 100, 2.5), ([1e6] * 100, 0.9)])
def test_a_node_with_time_to_spare_or_with_none_does_not_wait(ages, spent):
    lateness = Lateness()
    stale_frames(lateness, ages, spent)
    assert lateness.wait_for_next(100 * PERIOD, 100.8 * PERIOD, 0) == 0
