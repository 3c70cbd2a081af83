#!/usr/bin/env python3
"""Driving from the page in a real browser, and all ways of stopping."""
import os
import signal
import threading
from xmlrpc.client import ServerProxy

import rospy
import rostest
from aruco_node.messages.images import frame_from_image
from dynamic_reconfigure.msg import Config
from nav_msgs.msg import Odometry
from rig.page.browser import BrowserTest
from rig.processes.started import WAIT_S
from rosgraph import Master
from sensor_msgs.msg import Image


class Robot:
    """The robot's place and speed from /odom."""

    def __init__(self):
        self._changed = threading.Condition()
        self._message = None
        rospy.Subscriber('/odom', Odometry, self._take)

    def _take(self, message):
        with self._changed:
            self._message = message
            self._changed.notify_all()

    def wait(self, is_so):
        """Wait until ``is_so(x, forward, left)`` is true; returns x."""
        def true():
            return self._message and is_so(*self._values())
        with self._changed:
            if not self._changed.wait_for(true, WAIT_S):
                raise AssertionError('the robot is at %s' % (self._message and self._values(),))
            return self._values()[0]

    def _values(self):
        twist = self._message.twist.twist
        return self._message.pose.pose.position.x, twist.linear.x, twist.angular.z


class PageDriving(BrowserTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.robot = Robot()

    def test_an_arrow_key_drives_until_it_is_released(self):
        start = self.robot.wait(lambda x, forward, left: forward == left == 0)
        self.page.keyboard.down('ArrowUp')
        self.robot.wait(lambda x, forward, left: forward > 0.2 and x > start + 0.1)
        self.page.keyboard.up('ArrowUp')
        x = self.robot.wait(lambda x, forward, left: forward == 0)
        self.page.keyboard.down('ArrowDown')
        self.page.keyboard.down('ArrowLeft')
        self.robot.wait(lambda x, forward, left: forward < -0.2 and left > 0.5)
        self.page.keyboard.up('ArrowLeft')
        self.robot.wait(lambda now, forward, left: left == 0 and now < x - 0.05)
        self.page.keyboard.up('ArrowDown')
        self.robot.wait(lambda x, forward, left: forward == left == 0)
        self.turn_back()

    def turn_back(self):
        """Turn the robot back toward the wall."""
        heading = rospy.wait_for_message('/odom', Odometry, WAIT_S).pose.pose.orientation.z
        key = 'ArrowRight' if heading > 0 else 'ArrowLeft'
        self.page.keyboard.down(key)
        done = threading.Event()

        def look(message):
            if abs(message.pose.pose.orientation.z) < 0.03 or message.pose.pose.orientation.z * heading < 0:
                done.set()
        subscriber = rospy.Subscriber('/odom', Odometry, look)
        self.assertTrue(done.wait(WAIT_S))
        subscriber.unregister()
        self.page.keyboard.up(key)
        self.robot.wait(lambda x, forward, left: left == 0)

    def test_a_held_button_drives_by_mouse_and_by_keyboard(self):
        button = self.page.get_by_role('button', name='Backward')
        box = button.bounding_box()
        self.page.mouse.move(box['x'] + 5, box['y'] + 5)
        self.page.mouse.down()
        self.robot.wait(lambda x, forward, left: forward < -0.2)
        self.page.mouse.up()
        self.robot.wait(lambda x, forward, left: forward == 0)
        self.page.get_by_role('button', name='Forward').focus()
        self.page.keyboard.down('Space')
        self.robot.wait(lambda x, forward, left: forward > 0.2)
        self.page.keyboard.up('Space')
        self.robot.wait(lambda x, forward, left: forward == 0)

    def test_the_robot_stops_if_the_page_loses_focus_or_is_closed(self):
        def drive():
            self.page.keyboard.down('ArrowDown')
            self.robot.wait(lambda x, forward, left: forward < -0.2)
        drive()
        self.page.evaluate("window.dispatchEvent(new Event('blur'))")
        self.robot.wait(lambda x, forward, left: forward == 0)
        self.page.keyboard.up('ArrowDown')
        drive()
        self.page.context.set_offline(True)  # it prevents new connections; leaving the page closes the old one
        self.page.goto('about:blank')
        self.robot.wait(lambda x, forward, left: forward == 0)

    def test_arrow_keys_on_a_focused_slider_change_the_noise_and_do_not_drive(self):
        settings = []
        arrived = threading.Condition()

        def take(config):
            with arrived:
                settings.append({item.name: item.value for item in config.doubles}['noise'])
                arrived.notify_all()
        rospy.Subscriber('/wall_camera/parameter_updates', Config, take)
        slider = self.page.get_by_role('slider', name='Noise')
        before = float(slider.input_value())
        slider.focus()
        for _ in range(6):
            self.page.keyboard.press('ArrowUp')
        with arrived:
            self.assertTrue(arrived.wait_for(lambda: settings and settings[-1] == before + 6, WAIT_S), settings)
        self.robot.wait(lambda x, forward, left: forward == left == 0)
        slider.fill(str(int(before)))
        self.assertEqual(slider.evaluate('slider => slider === document.activeElement'), True)
        self.page.get_by_text('earth', exact=True).click()  # after a click on something else, arrow keys drive
        self.page.wait_for_function('() => document.activeElement === document.body')
        self.page.keyboard.down('ArrowDown')
        self.robot.wait(lambda x, forward, left: forward < 0)
        self.page.keyboard.up('ArrowDown')
        self.robot.wait(lambda x, forward, left: forward == 0)

    def test_z_killing_the_server_stops_the_robot_but_not_the_nodes(self):
        self.expected = 'ERR_CONNECTION'  # the browser logs every attempt to connect on its console
        self.page.keyboard.down('ArrowDown')
        self.robot.wait(lambda x, forward, left: forward < -0.2)
        page = ServerProxy(Master('/page_driving_test').lookupNode('/page'))
        code, _, pid = page.getPid('/page_driving_test')
        self.assertEqual(code, 1)
        os.kill(pid, signal.SIGKILL)
        self.robot.wait(lambda x, forward, left: forward == 0)
        self.wait_for_text('#status', 'does not answer')
        for number in range(2, 7):
            image = rospy.wait_for_message('/exercise5_%d/image' % number, Image, WAIT_S)
            self.assertGreater(frame_from_image(image).std(), 20)


if __name__ == '__main__':
    rospy.init_node('page_driving_test')
    rostest.rosrun('unit5', 'page_driving_test', PageDriving)
