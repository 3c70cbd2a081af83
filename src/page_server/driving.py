"""Driving by hand, with a dead man's switch."""
import math
import threading
import time

import rospy
from geometry_msgs.msg import Twist

DEAD_MAN_S = 0.4  # the robot is stopped if the driver sends nothing for this time


class DriveControl:
    """Publishes cmd_vel for the browser that drives, and stops the robot when that browser goes away.

    The switch is a thread of its own. So the robot stops in time even if the server hangs, which a file system
    or a name server can cause.
    """

    def __init__(self):
        self._speeds = 0.0, 0.0
        self._publisher = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        # The connection that drives, and until when it may without another command, a monotonic time.
        self._driver, self._until = None, 0.0
        self._changed, self._closed = threading.Condition(), False
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
            if not self._closed:
                self._driver, self._until = driver, time.monotonic() + DEAD_MAN_S
                self._changed.notify()
                self._publish(*(part * speed for part, speed in zip(parts, self._speeds)))

    def release(self, driver):
        """Stop the robot, if it is this connection that drives."""
        with self._changed:
            if self._driver is driver:
                self._halt()

    def _watch(self):
        """Stop the robot whenever the driver has sent nothing for too long."""
        with self._changed:
            while not self._closed:
                left = self._until - time.monotonic()
                if self._driver is None:
                    self._changed.wait()
                elif left > 0:
                    self._changed.wait(left)
                else:
                    self._halt()

    def _halt(self):
        """Stop the robot if anybody drives. The caller holds the lock."""
        if self._driver is not None:
            self._driver = None
            self._publish(0.0, 0.0)

    def _close(self):
        """Stop the robot, and publish nothing afterwards."""
        with self._changed:
            self._halt()
            self._closed = True
            self._changed.notify()

    def _publish(self, linear, angular):
        command = Twist()
        command.linear.x, command.angular.z = linear, angular
        self._publisher.publish(command)
