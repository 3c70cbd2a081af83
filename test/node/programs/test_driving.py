"""The dead man's switch stops the robot whatever the server does."""
from queue import Queue
from types import SimpleNamespace

import pytest
import rospy
from page_server.driving import DriveControl
from rig.processes.started import WAIT_S


@pytest.fixture
def driving(monkeypatch):
    """(DriveControl, Queue of the speeds that it publishes)."""
    commands = Queue()

    def publish(command):
        commands.put((command.linear.x, command.angular.z))
    monkeypatch.setattr(rospy, 'Publisher', lambda *_, **__: SimpleNamespace(publish=publish))
    hooks = []
    monkeypatch.setattr(rospy, 'on_shutdown', hooks.append)
    control = DriveControl()
    control.set_speeds(SimpleNamespace(linear=0.5, angular=2.0))
    yield control, commands
    hooks[0]()


def test_the_robot_stops_though_the_server_hangs(driving):
    control, commands = driving
    for _ in range(2):
        control.command('browser', 1, -0.5)
        assert commands.get(timeout=WAIT_S) == (0.5, -1.0)
        assert commands.get(timeout=WAIT_S) == (0.0, 0.0)  # nothing else runs in this thread meanwhile


def test_only_the_driver_stops_the_robot_and_only_once(driving):
    control, commands = driving
    control.command('browser', 1, 0)
    control.release('another')
    control.release('browser')
    control.release('browser')
    control.command('browser', 0, 0)
    control.command('browser', 0, 1)
    assert [commands.get(timeout=WAIT_S) for _ in range(4)] == [(0.5, 0), (0, 0), (0, 2.0), (0, 0)]
    assert commands.empty()


def test_nothing_is_published_after_the_end(driving):
    control, commands = driving
    control.command('browser', 1, 0)
    control._close()
    control.command('browser', 1, 0)
    assert [commands.get(timeout=WAIT_S) for _ in range(2)] == [(0.5, 0), (0, 0)]
    assert commands.empty()
