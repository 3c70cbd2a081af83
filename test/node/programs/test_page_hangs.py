"""The page's server while something hangs: its event loop, or the file system that holds images/."""
import asyncio
import threading

import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_node.page import driving, remote
from page_server import shelf
from rig.processes.started import WAIT_S


@pytest.fixture
def published(monkeypatch):
    """Messages that are published, without a ROS master."""
    messages = []

    class Publisher:
        resolved_name = '/page/picture'

        def __init__(self, *_, **__):
            self.publish = messages.append

    class Absent:
        """A node that is not running, or what it offers."""

        def __init__(self, *_, **__):
            pass

        def get_num_connections(self):
            return 0
    for module in remote, driving:
        monkeypatch.setattr(module.rospy, 'Publisher', Publisher)
    monkeypatch.setattr(remote.rospy, 'Subscriber', Absent)
    monkeypatch.setattr(remote.rospy, 'ServiceProxy', Absent)
    monkeypatch.setattr(driving.rospy, 'on_shutdown', lambda work: None)
    return messages


class Robot:
    """Is told to stop."""

    def __init__(self):
        self.speeds, self.stopped = [], threading.Event()

    def append(self, command):
        self.speeds.append((command.linear.x, command.angular.z))
        if command.linear.x == command.angular.z == 0:
            self.stopped.set()


def test_the_robot_is_stopped_though_the_event_loop_hangs(published, monkeypatch):
    robot = Robot()
    monkeypatch.setattr(driving.rospy, 'Publisher', lambda *_, **__: type('', (), {'publish': robot.append}))
    control, driver = driving.DriveControl(), object()
    control._speeds = 0.3, 0.8

    async def drive(forward):
        control.command(driver, forward, 0)
        return robot.stopped.wait(WAIT_S)  # this hangs in the loop until the robot has stopped
    for forward in 1, -1:  # it drives again afterwards
        robot.stopped.clear()
        assert asyncio.run(drive(forward))
    assert robot.speeds == [(0.3, 0), (0, 0), (-0.3, 0), (0, 0)]
    control._close()
    control.command(driver, 1, 0)
    assert len(robot.speeds) == 4


def test_a_file_system_that_hangs_does_not_stop_the_page(published, monkeypatch):
    answers, scanned = threading.Event(), threading.Event()

    def scan(folder):
        scanned.set()
        assert answers.wait(WAIT_S)
        return ['late.png']
    monkeypatch.setattr(shelf, 'files_in', scan)
    monkeypatch.setattr(shelf, 'ANSWER_S', 0.05)
    changed = threading.Event()
    there = remote.NodeChoices(changed.set)
    assert there.state()['pictures'] == [] and scanned.wait(WAIT_S)
    assert there.state()['pictures'] == []  # it does not wait
    with pytest.raises(InputError, match='images/ cannot be read: its file system does not answer'):
        asyncio.run(there.choose('late.png'))
    answers.set()
    assert changed.wait(WAIT_S)  # the browsers are told
    assert there.state()['pictures'] == ['late.png']


def test_of_two_choices_the_later_one_counts_though_the_file_system_is_slow(published, monkeypatch):
    answers, painted = threading.Event(), []

    async def paint(node, picture):
        painted.append(picture)
    monkeypatch.setattr(shelf, 'files_in', lambda folder: answers.wait(WAIT_S) and ['slow.png'])
    monkeypatch.setattr(remote.RemoteParameters, 'set', paint)
    monkeypatch.setattr(remote.rospy.Time, 'now', remote.rospy.Time)
    there = remote.NodeChoices(lambda: None)

    async def choose_both():
        first = asyncio.ensure_future(there.choose('slow.png'))
        await asyncio.sleep(0)
        await there.drop([cv2.imencode('.png', np.zeros((2, 3, 3), np.uint8))[1].tobytes()])
        answers.set()
        await first
    asyncio.run(choose_both())
    assert painted == ['topic:/page/picture']
