"""What a node reports about its health, from the frames that arrived, were answered, and were dropped."""
import threading
from types import SimpleNamespace

import pytest
from aruco_node.health import diagnostics as health
from aruco_node.health.diagnostics import OK, WARN, FrameCount
from aruco_node.nodes import frame_node
from aruco_node.nodes.frame_node import FrameNode
from sensor_msgs.msg import Image


@pytest.fixture
def clock(monkeypatch):
    """A clock that only the test moves: a list with the time in seconds."""
    now = [1000.0]
    monkeypatch.setattr(health.time, 'monotonic', lambda: now[0])
    return now


def run_frames(count, clock, period, pipeline, numbers, tags=4, has_area=None):
    """Let these frames arrive, one each ``period``; each is answered after ``pipeline`` seconds.

    ``has_area``: None if it is so with tags alone.
    """
    count.forget_last_frames()
    for number in numbers:
        began = clock[0]
        missing = count.on_arrival(number)
        clock[0] += pipeline
        count.on_answer(began, None, missing, tags, tags > 0 if has_area is None else has_area)
        clock[0] += period - pipeline


def test_a_good_node_reports_its_frame_rate(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.02, range(30))
    level, sentence, values = count.report()
    assert (level, sentence) == (OK, '10.0 frames a second')
    assert (values['frames in'], values['frames out'], values['frames dropped']) == (30, 30, 0)
    assert (values['pipeline, median (ms)'], values['latency, median (ms)']) == ('20.0', 'unknown')
    assert (values['tags in sight'], values['area last seen (s ago)']) == (4, '0.1')


def test_a_node_that_takes_too_long_is_reported_as_slow(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.095, range(0, 90, 3))
    level, sentence, values = count.report()
    assert level == WARN and sentence.startswith('Slow: ') and '~scale' in sentence
    assert values['frames dropped'] == 2 * 29


def test_a_node_with_time_to_spare_is_not_reported_as_slow(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.005, range(0, 90, 3))
    level, sentence, _ = count.report()
    assert level == WARN and 'did not arrive' in sentence and 'Slow' not in sentence


@pytest.mark.parametrize('has_area, level', [(False, WARN), (True, OK)])
def test_missing_tags_are_reported_unless_the_wall_is_known_without_them(clock, has_area, level):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.02, range(150), tags=0, has_area=has_area)
    assert count.report()[0] == level and count.misses_tags != has_area


def test_frames_that_cannot_be_used_are_counted_and_told_while_they_come(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.005, range(10))
    assert 'frames not usable' not in count.report()[2]
    for number in range(10, 14):
        count.on_arrival(number)
        count.on_unusable('It is cut off.')
    level, sentence, values = count.report()
    assert (level, sentence) == (WARN, '4 of 14 frames within 5 s could not be used. It is cut off.')
    assert (values['frames not usable'], values['frames dropped'], values['frames out']) == (4, 0, 10)
    clock[0] += 6
    assert (count.report()[0], count.report()[2]['frames not usable']) == (OK, 4)


def test_another_camera_or_a_pause_is_not_reported_as_dropped_frames(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.005, [5, 6, 5000, 7, 8])
    run_frames(count, clock, 0.1, 0.005, [500, 501])
    assert count.report()[2]['frames dropped'] == 0


def test_a_long_time_without_tags_is_reported(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.005, range(120), tags=0)
    level, sentence, values = count.report()
    assert (level, values['tags in sight'], values['area last seen (s ago)']) == (WARN, 0, 'none seen')
    assert sentence.startswith('No tag has been in sight for 1')


def test_without_frames_the_rate_is_zero(clock):
    count = FrameCount()
    run_frames(count, clock, 0.1, 0.005, range(30))
    clock[0] += 6
    values = count.report()[2]
    assert (values['frame rate (Hz)'], values['tags in sight']) == ('0.0', 0)


class NodeOfASilentCamera(FrameNode):
    """What a FrameNode needs to tell of silence, without ROS. A frame arrives while it asks why, if wanted."""

    def __init__(self, frame_arrives):
        self._topic, self._message_class, self._processing = '/camera', Image, threading.Lock()
        self._silence = None
        self._frame_arrives = frame_arrives

    def _explain_no_frames(self):
        if self._frame_arrives:
            self._on_message(None)
        return 'Waiting for frames.', False


@pytest.mark.parametrize('frame_arrives', [False, True])
def test_silence_is_not_told_if_a_frame_arrives_while_its_reason_is_asked_for(monkeypatch, frame_arrives):
    told = []
    monkeypatch.setattr(frame_node, 'rospy', SimpleNamespace(logwarn=lambda *line: told.append(line)))
    node = NodeOfASilentCamera(frame_arrives)
    node._log_silence()
    assert told == ([] if frame_arrives else [('%s', 'Waiting for frames.')])
