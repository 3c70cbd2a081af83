"""Driving by hand, with a dead man's switch."""
import asyncio
import math
import threading

import rospy
from geometry_msgs.msg import Twist

DEAD_MAN_S = 0.4  # the robot is stopped if the driver sends nothing for this time


class DriveControl:
    """Publishes cmd_vel for the browser that drives, and stops the robot when that browser goes away."""

    def __init__(self):
        self._speeds = 0.0, 0.0
        self._publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        self._driver, self._timer = None, None  # the connection that drives
        self._lock, self._closed = threading.Lock(), False
        rospy.on_shutdown(self._close)

    def set_speeds(self, settings):
        """Use the settings' speeds, ``linear`` in m/s and ``angular`` in rad/s, from the next command on."""
        self._speeds = settings.linear, settings.angular

    def has_listeners(self):
        """Whether anything listens to cmd_vel, such as a robot."""
        return self._publisher.get_num_connections() > 0

    def command(self, driver, forward, left):
        """Drive on behalf of a connection. ``forward``, ``left``: -1 to 1, as fractions of the speeds.

        0, 0 stops the robot. Values that are not numbers are ignored.
        """
        if not all(isinstance(part, (int, float)) and math.isfinite(part) for part in (forward, left)):
            return
        if forward == left == 0:
            self.release(driver)
            return
        self._cancel_timer()
        self._driver = driver
        self._timer = asyncio.get_event_loop().call_later(DEAD_MAN_S, self._halt)
        parts = [min(max(part, -1), 1) for part in (forward, left)]
        self._publish(*(part * speed for part, speed in zip(parts, self._speeds)))

    def release(self, driver):
        """Stop the robot, if it is this connection that drives."""
        if self._driver is driver and driver is not None:
            self._halt()

    def _halt(self):
        if self._driver is not None:
            self._cancel_timer()
            self._driver = None
            self._publish(0.0, 0.0)

    def _cancel_timer(self):
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _close(self):
        """Stop the robot, and publish nothing afterwards.

        Called in another thread, while commands may arrive.
        """
        with self._lock:
            self._closed = True
            if self._driver is not None:
                self._publisher.publish(Twist())

    def _publish(self, linear, angular):
        command = Twist()
        command.linear.x, command.angular.z = linear, angular
        with self._lock:
            if not self._closed:
                self._publisher.publish(command)
