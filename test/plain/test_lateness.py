"""Which frames are too old to be shown: few, and only before a node that keeps up with its camera."""
from aruco_node.lateness import Lateness

PERIOD = 1 / 30


def ages(lateness, periods, missing=0):
    """Whether frames are too late, one a period of the camera, by how old they are, in periods."""
    return [lateness.is_late(number * PERIOD, (number + age) * PERIOD, missing)
            for number, age in enumerate(periods)]


def test_frames_in_time_are_shown():
    assert not any(ages(Lateness(), [0.5] * 100))


def test_one_that_is_older_than_the_others_is_not_shown():
    late = ages(Lateness(), [0.5] * 50 + [1.8] + [0.5] * 20 + [2.5, 1.9] + [0.5] * 20)
    assert [number for number, is_late in enumerate(late) if is_late] == [50, 71, 72]


def test_all_are_shown_where_the_node_is_too_slow_or_the_clocks_differ():
    assert not any(ages(Lateness(), [3, 4, 2, 10] * 50))
    assert not any(ages(Lateness(), [1e6] * 200))
    assert not any(ages(Lateness(), [-1e6] * 200))


def test_all_are_shown_soon_after_the_node_has_become_too_slow():
    late = ages(Lateness(), [0.5] * 100 + [3] * 100)
    assert any(late[100:110]) and not any(late[120:])


def test_frames_that_were_dropped_do_not_make_the_period_longer():
    lateness = Lateness()
    for number in range(0, 300, 3):
        assert not lateness.is_late(number * PERIOD, (number + 1) * PERIOD, 2)
    assert lateness.is_late(300 * PERIOD, 302 * PERIOD, 2)


def test_stamps_that_stand_still_or_go_back_are_no_reason():
    lateness = Lateness()
    assert not any(lateness.is_late(100, 100, 0) for _ in range(100))
    assert not any(lateness.is_late(100 - number, 100, 0) for number in range(100))
