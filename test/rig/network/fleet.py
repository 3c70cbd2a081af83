"""A fleet: a base station and its robots, each on a host of its own, with the nodes that they run."""
import json
import os
import sys
import time
from contextlib import contextmanager

from rig.network.hosts import BASE, LOSS, hosts
from rig.processes.started import Started, stop_all

VIEWER = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'viewer.py')


class Fleet:
    """A base station with a roscore, and its robots, each with a simulated camera."""

    def __init__(self, made, radios):
        (self.base, *self.robots), self.radios, self.running = made, radios, []

    def start(self, of_robots, of_base):
        """Start everything; for the arguments see running_fleet."""
        self.running.append(Started(*self.base.command('roscore')))
        self.running[0].wait_for('started core service')
        for number, robot in enumerate(self.robots):
            names = ['ROS_NAMESPACE=' + robot.name]
            self.running += [
                Started(*robot.command(*names, 'roslaunch', 'unit5', 'robot.launch', 'sim:=true', *of_robots)),
                Started(*self.base.command(*names, 'roslaunch', 'unit5', 'base_station.launch',
                                           'port:=%d' % (8090 + number), *of_base))]

    def view(self, *exercises):
        """Start a viewer on the base station, which compares all robots' frames with the painted ones."""
        pairs = ['/%s/%s' % (robot.name, topic) for robot in self.robots for exercise in exercises
                 for topic in ('base_camera/image_raw', exercise + '/image')]
        self.running.append(Started(*self.base.command(sys.executable, VIEWER, *pairs)))
        return self.running[-1]

    def bytes_sent(self):
        """The number of bytes that the robots have sent so far."""
        return sum(robot.bytes_to(BASE) for robot in self.robots)


def frames_seen(viewer, after=0):
    """What a viewer has seen: (topic, stamp, age, painted share or None) of each frame."""
    return [json.loads(line) for line in viewer.lines[after:] if line.startswith('[')]


def observe(fleet, viewer, seconds):
    """The frames seen and the number of bytes sent within this many seconds."""
    seen, sent = len(viewer.lines), fleet.bytes_sent()
    time.sleep(seconds)
    return frames_seen(viewer, seen), fleet.bytes_sent() - sent


@contextmanager
def running_fleet(robots, of_robots=(), of_base=(), loss=LOSS):
    """A Fleet that runs during the block.

``of_robots``, ``of_base``: arguments of robot.launch and base_station.launch. Raises OSError or
CalledProcessError if hosts cannot be created.
"""
    with hosts(robots, loss) as (made, radios):
        found = Fleet(made, radios)
        try:
            found.start(of_robots, of_base)
            yield found
        finally:
            stop_all(reversed(found.running[1:]))
            stop_all(found.running)
