"""Driving by hand, with a dead man's switch."""
import math
import threading
import time

import rospy
from geometry_msgs.msg import Twist

from aruco_node.health.faults import fault_barrier

DEAD_MAN_S = 0.4  # the robot is stopped if the driver sends nothing for this time


class DriveControl:
    """Publishes cmd_vel for the browser that drives, and stops the robot when that browser goes away.

    A thread of its own watches the driver. So the robot stops in time also while the server's event loop hangs,
    such as at a file system that does not answer.
    """

    def __init__(self):
        self._speeds = 0.0, 0.0
        self._publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        self._changed, self._closed = threading.Condition(), False
        self._driver, self._until = None, 0.0  # the connection that drives, and until when, monotonic seconds
        rospy.on_shutdown(self._close)
        threading.Thread(target=self._watch, name='dead man', daemon=True).start()

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
        parts = [min(max(part, -1), 1) for part in (forward, left)]
        with self._changed:
            self._driver, self._until = driver, time.monotonic() + DEAD_MAN_S
            self._changed.notify_all()
            self._publish(*(part * speed for part, speed in zip(parts, self._speeds)))

    def release(self, driver):
        """Stop the robot, if it is this connection that drives."""
        with self._changed:
            if self._driver is driver and driver is not None:
                self._halt()

    def _watch(self):
        """Stop the robot whenever its driver is late, until ROS shuts down."""
        with self._changed:
            while not self._closed:
                if self._driver is None:
                    self._changed.wait()
                elif time.monotonic() < self._until:
                    self._changed.wait(self._until - time.monotonic())
                else:
                    self._halt()

    @fault_barrier
    def _halt(self):
        self._driver = None
        self._publish(0.0, 0.0)

    def _close(self):
        """Stop the robot, and publish nothing afterwards."""
        with self._changed:
            if self._driver is not None:
                self._halt()
            self._closed = True
            self._changed.notify_all()

    def _publish(self, linear, angular):
        command = Twist()
        command.linear.x, command.angular.z = linear, angular
        if not self._closed:
            self._publisher.publish(command)
