"""Which frames are too old to be shown: few, and only before a node that keeps up with its camera."""
import pytest
from aruco_ar.lateness import Lateness

PERIOD = 1 / 30


def lates(lateness, ages, spent=0.4):
    """Whether frames are too late, one a period, so many periods old when so many were spent on each."""
    found = []
    for number, age in enumerate(ages):
        lateness.wait_for_next(number * PERIOD, (number + age - spent) * PERIOD, 0)
        found.append(lateness.is_stale((number + age) * PERIOD))
    return found


def test_frames_in_time_are_shown():
    assert not any(lates(Lateness(), [0.5] * 100))


def test_one_that_is_older_than_the_others_is_not_shown():
    late = lates(Lateness(), [0.5] * 50 + [1.8] + [0.5] * 20 + [2.5, 1.9] + [0.5] * 20)
    assert [number for number, is_stale in enumerate(late) if is_stale] == [50, 71, 72]


@pytest.mark.parametrize('ages', [[3, 4, 2, 10] * 50, [1e6] * 200, [-1e6] * 200])
def test_all_are_shown_where_the_node_is_too_slow_or_the_clocks_differ(ages):
    assert not any(lates(Lateness(), ages))


def test_all_are_shown_soon_after_the_node_has_become_too_slow():
    late = lates(Lateness(), [0.5] * 100 + [3] * 100)
    assert any(late[100:110]) and not any(late[120:])


def test_frames_that_were_dropped_do_not_make_the_period_longer():
    lateness = Lateness()
    for number in range(0, 300, 3):
        lateness.wait_for_next(number * PERIOD, (number + 0.5) * PERIOD, 2)
        assert not lateness.is_stale((number + 1) * PERIOD)
    lateness.wait_for_next(300 * PERIOD, 300.5 * PERIOD, 2)
    assert lateness.is_stale(302 * PERIOD)


def test_stamps_that_stand_still_or_go_back_are_no_reason():
    for step in 0, -1:
        lateness = Lateness()
        for number in range(100):
            assert lateness.wait_for_next(100 + step * number, 100, 0) == 0
            assert not lateness.is_stale(100)


def test_a_busy_node_waits_for_the_next_frame_where_one_comes_late():
    lateness = Lateness()
    lates(lateness, [1.0] * 100, spent=0.9)
    assert lateness.wait_for_next(100 * PERIOD, 100.1 * PERIOD, 0) == 0
    assert lateness.wait_for_next(101 * PERIOD, 101.8 * PERIOD, 0) == pytest.approx(0.55 * PERIOD, rel=0.01)


def test_also_where_all_frames_have_come_late_since_one_was_held_up():
    lateness = Lateness()
    lates(lateness, [0.95] + [1.9] * 100, spent=0.95)
    assert lateness.wait_for_next(101 * PERIOD, 101.95 * PERIOD, 0) > 0


def test_where_all_frames_are_long_on_their_way_none_is_waited_for():
    lateness = Lateness()
    assert not any(lates(lateness, [1.2] * 100, spent=0.5))
    assert lateness.wait_for_next(100 * PERIOD, 100.8 * PERIOD, 0) == 0


@pytest.mark.parametrize('ages, spent', [([0.5] * 100, 0.2), ([3.0] * 100, 2.5), ([1e6] * 100, 0.9)])
def test_one_with_time_to_spare_or_with_none_at_all_does_not_wait(ages, spent):
    lateness = Lateness()
    lates(lateness, ages, spent)
    assert lateness.wait_for_next(100 * PERIOD, 100.8 * PERIOD, 0) == 0
