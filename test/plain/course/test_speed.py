"""What is said of a function that is slower than the camera."""
import pytest
from aruco_course.trial import Trial, fault_of_speed


@pytest.mark.parametrize('seconds, baseline, is_slow', [
    (0.01, 0.004, False),
    (0.5, 0.004, True),
    (0.5, 0.03, False),    # a slow machine: finding the tags takes long, too
    (0.09, 0.001, False),  # no camera minds
    (0.5, 0.0, False),     # it is not known how fast the machine is
])
def test_only_what_waits_is_slow_whatever_the_machine(seconds, baseline, is_slow):
    fault = fault_of_speed(Trial(seconds=[seconds, seconds, 9.0], baseline_seconds=baseline))
    assert (fault is not None) == is_slow
    if is_slow:
        assert 'it is right, but slower than the camera' in str(fault).lower()
