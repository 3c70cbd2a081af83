"""Driving by hand, with a dead man's handle."""
import asyncio
import math
import threading

import rospy
from geometry_msgs.msg import Twist

DEAD_MAN_S = 0.4  # without a word from who drives, the robot is stopped


class Driver:
    """Publishes /cmd_vel for who drives, and stops the robot when they go."""

    def __init__(self):
        self._speeds = 0.0, 0.0
        self._publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        self._who, self._timer = None, None
        self._lock, self._closed = threading.Lock(), False
        rospy.on_shutdown(self._close)

    def set_speeds(self, settings):
        """Drive at the settings' ``linear`` and ``angular``, m/s and rad/s, from the next command on."""
        self._speeds = settings.linear, settings.angular

    def command(self, who, forward, left):
        """Drive: each -1 to 1, in parts of the speeds; 0, 0 stops. What is no number is passed over."""
        if not all(isinstance(part, (int, float)) and math.isfinite(part) for part in (forward, left)):
            return
        if forward == left == 0:
            self.leave(who)
            return
        self._cancel_timer()
        self._who = who
        self._timer = asyncio.get_event_loop().call_later(DEAD_MAN_S, self._halt)
        parts = [min(max(part, -1), 1) for part in (forward, left)]
        self._publish(*(part * speed for part, speed in zip(parts, self._speeds)))

    def leave(self, who):
        """Stop, if it is they who drive."""
        if self._who is who and who is not None:
            self._halt()

    def _halt(self):
        if self._who is not None:
            self._cancel_timer()
            self._who = None
            self._publish(0.0, 0.0)

    def _cancel_timer(self):
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _close(self):
        """Stop, and publish nothing more: in another thread, while commands may come in still."""
        with self._lock:
            self._closed = True
            if self._who is not None:
                self._publisher.publish(Twist())

    def _publish(self, linear, angular):
        command = Twist()
        command.linear.x, command.angular.z = linear, angular
        with self._lock:
            if not self._closed:
                self._publisher.publish(command)
