#!/usr/bin/env python3
"""The page in a real browser: pictures that move, driving, choosing what is painted."""
import os
import shutil
import signal
import socket
import sys
import threading
import unittest
from xmlrpc.client import ServerProxy

import cv2
import numpy as np
import rospy
import rostest
from aruco_ar import Area
from aruco_ar.messages import frame_from_image
from dynamic_reconfigure.msg import Config
from geometry_msgs.msg import PolygonStamped
from nav_msgs.msg import Odometry
from rosgraph import Master
from sensor_msgs.msg import Image
from started import WAIT_S, Started

BROWSERS = 'chromium', 'chromium-browser', 'google-chrome'
WAIT_MS = 1000 * WAIT_S
OPTIONS = ['--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--disable-component-update', '--disable-sync']
PAINTED = '.tile[data-topic="/exercise5_6/image"]'


class Robot:
    """What /odom says."""

    def __init__(self):
        self._changed = threading.Condition()
        self._message = None
        rospy.Subscriber('/odom', Odometry, self._take)

    def _take(self, message):
        with self._changed:
            self._message = message
            self._changed.notify_all()

    def wait(self, is_so):
        """Wait until is_so(x, forward, left) is true; x."""
        def true():
            return self._message and is_so(*self._values())
        with self._changed:
            if not self._changed.wait_for(true, WAIT_S):
                raise AssertionError('the robot is at %s' % (self._message and self._values(),))
            return self._values()[0]

    def _values(self):
        twist = self._message.twist.twist
        return self._message.pose.pose.position.x, twist.linear.x, twist.angular.z


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        path = next(filter(None, map(shutil.which, BROWSERS)), None)
        if path is None:
            raise unittest.SkipTest('no Chromium here')
        from playwright.sync_api import sync_playwright
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            cls.port = probe.getsockname()[1]
        cls.server = Started('roslaunch', 'unit5', 'page.launch', 'port:=%d' % cls.port)
        cls.server.wait_for('The page is at')
        cls.robot = Robot()
        cls.playwright = sync_playwright().start()
        sandbox = ['--no-sandbox'] if os.getuid() == 0 else []
        cls.browser = cls.playwright.chromium.launch(executable_path=path, args=OPTIONS + sandbox)

    @classmethod
    def tearDownClass(cls):
        if hasattr(cls, 'browser'):
            cls.browser.close()
            cls.playwright.stop()
            cls.server.stop()

    def setUp(self):
        self.page = self.browser.new_page(viewport={'width': 1400, 'height': 900})
        self.page.set_default_timeout(WAIT_MS)
        self.wrong, self.asked, self.expected = [], [], ''
        self.page.on('pageerror', lambda error: self.wrong.append(str(error)))
        self.page.on('console', lambda line: self.wrong.append(line.text) if line.type == 'error' else None)
        self.page.on('request', lambda request: self.asked.append(request.url))
        self.page.goto('http://localhost:%d/' % self.port)
        self.page.wait_for_function("() => document.querySelectorAll('.tile .why[hidden]').length == 6 && "
                                    "[...document.querySelectorAll('.latency')].every((text) => /^[0-9]/.test(text.textContent))")

    def tearDown(self):
        self.assertEqual([wrong for wrong in self.wrong if not self.expected or self.expected not in wrong], [])
        self.page.close()

    def shot(self, selector):
        """A screenshot of an element, (h, w, 3) BGR."""
        png = self.page.locator(selector).screenshot()
        return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)

    def painted(self):
        """What 5.6 shows on the page, as large as it is, and the true area in it."""
        corners = rospy.wait_for_message('/wall_camera/area', PolygonStamped, WAIT_S).polygon.points
        shot = cv2.resize(self.shot(PAINTED + ' canvas'), (640, 480))
        return shot, Area(np.float32([(point.x, point.y) for point in corners]))

    def wait_for_color(self, color):
        """Wait until the middle of what 5.6 shows has about that color, (blue, green, red)."""
        self.page.wait_for_function(
            """([selector, x, y, [blue, green, red]]) => {
                 const [r, g, b] = document.querySelector(selector).getContext('2d').getImageData(x, y, 1, 1).data;
                 return Math.abs(r - red) + Math.abs(g - green) + Math.abs(b - blue) < 60;
               }""", arg=[PAINTED + ' canvas', *self.middle(), list(color)])

    def middle(self):
        return [int(value) for value in self.painted()[1].corners.mean(axis=0)]

    def test_the_pictures_move_and_the_earth_has_its_colors(self):
        for tile in self.page.locator('.tile').all():
            topic = tile.get_attribute('data-topic')
            selector = '.tile[data-topic="%s"] canvas' % topic
            first = self.shot(selector)
            self.assertGreater(first.std(), 20, topic)
            self.until(lambda: np.any(self.shot(selector) != first))
        shot, area = self.painted()
        homography = area.homography(960, 640)

        def color(x, y):
            seen = homography @ [x, y, 1]
            x, y = np.int32(np.round(seen[:2] / seen[2]))
            return shot[y - 1:y + 2, x - 1:x + 2].mean(axis=(0, 1))
        blue, _, red = color(330, 330)      # the Atlantic
        self.assertGreater(blue, red + 25)
        blue, green, red = color(430, 270)  # the Sahara
        self.assertTrue(red > green > blue and red > 130, (blue, green, red))
        self.assertLess(color(60, 320).max(), 70)

    def until(self, true):
        for _ in range(50):
            if true():
                return
        self.fail('it never came true')

    def test_rate_latency_and_tags_are_beside_each_picture_and_nothing_comes_from_elsewhere(self):
        for tile in self.page.locator('.tile').all():
            self.assertRegex(tile.locator('.rate').inner_text(), r'^\d+ fps$')
            self.assertRegex(tile.locator('.latency').inner_text(), r'^\d+ ms$')
            self.assertEqual(tile.locator('.tags').inner_text(), 'tags 1 2 3 4')
        own = 'http://localhost:%d/' % self.port
        self.assertEqual([url for url in self.asked if not url.startswith((own, 'data:', 'ws' + own[4:]))], [])

    def test_everything_has_a_name_for_a_screen_reader(self):
        nameless = self.page.evaluate(
            """[...document.querySelectorAll('button, input, canvas, section, select')].filter((element) =>
                 !element.ariaLabel && !element.getAttribute('aria-labelledby')
                 && !element.closest('label')?.textContent.trim()).map((element) => element.outerHTML)""")
        self.assertEqual(nameless, [])
        for name in ('Forward', 'Backward', 'Turn left', 'Turn right', '5.6 A picture in its place: enlarge'):
            self.assertEqual(self.page.get_by_role('button', name=name).count(), 1, name)
        self.assertEqual(self.page.get_by_role('radio', name='earth', exact=True).count(), 1)
        self.assertEqual(self.page.get_by_role('slider', name='Noise').count(), 1)
        self.assertEqual(self.page.get_by_role('status').inner_text(), 'Live')

    def test_a_click_makes_a_picture_large_and_the_others_rest(self):
        small = self.shot(PAINTED)
        self.page.get_by_role('button', name='5.6 A picture in its place').click()
        self.assertGreater(self.shot(PAINTED).shape[1], 2 * small.shape[1])
        # Now only 5.6 is looked at: the other nodes are left alone.
        self.until_connected(['/exercise5_6/image/compressed'])
        self.page.keyboard.press('Escape')
        self.assertEqual(self.shot(PAINTED).shape[1], small.shape[1])
        self.until_connected(['/exercise5_%d/image/compressed' % number for number in range(2, 7)])

    def until_connected(self, topics):
        """Wait until these and no others of the exercises' pictures are subscribed to."""
        self.until_of_master(lambda listened: sorted(
            topic for topic, nodes in listened if topic.endswith('image/compressed') and '/page' in nodes
            and topic.startswith('/exercise')) == topics)

    def until_of_master(self, true):
        rate = rospy.Rate(10)
        for _ in range(10 * WAIT_S):
            if true(rospy.get_master().getSystemState()[2][1]):
                return
            rate.sleep()
        self.fail('it never came true')

    def test_an_arrow_key_drives_and_letting_go_stops(self):
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
        """Toward the wall again, as far as it was turned away."""
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

    def test_the_robot_stops_when_the_page_loses_focus_or_is_gone(self):
        def drive():
            self.page.keyboard.down('ArrowDown')
            self.robot.wait(lambda x, forward, left: forward < -0.2)
        drive()
        self.page.evaluate("window.dispatchEvent(new Event('blur'))")
        self.robot.wait(lambda x, forward, left: forward == 0)
        self.page.keyboard.up('ArrowDown')
        drive()
        self.page.context.set_offline(True)  # holds back new connections; the old one is cut by going elsewhere
        self.page.goto('about:blank')
        self.robot.wait(lambda x, forward, left: forward == 0)

    def test_arrow_keys_on_a_slider_do_not_drive_but_change_the_noise(self):
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

    def test_choosing_a_picture_changes_what_is_painted(self):
        self.page.get_by_text('turning earth').click()
        self.page.wait_for_function("() => document.querySelector('input[value=\"turning_earth.mp4\"]').checked")
        x, y = self.middle()
        turned = [self.shot(PAINTED + ' canvas')]
        self.until(lambda: turned.append(self.shot(PAINTED + ' canvas')) or
                   np.abs(turned[-1].astype(int) - turned[0]).max() > 60)
        png = cv2.imencode('.png', np.full((20, 30, 3), (10, 200, 30), np.uint8))[1].tobytes()
        self.page.locator('#file').set_input_files({'name': 'green.png', 'mimeType': 'image/png', 'buffer': png})
        self.wait_for_color((10, 200, 30))
        self.assertEqual(self.page.get_by_role('status').inner_text(), 'green.png is painted.')
        blue = cv2.imencode('.png', np.full((20, 30, 3), (220, 30, 10), np.uint8))[1].tolist()
        self.page.evaluate(
            """(bytes) => {
                 const dataTransfer = new DataTransfer();
                 dataTransfer.items.add(new File([new Uint8Array(bytes)], 'blue.png', { type: 'image/png' }));
                 document.querySelector('h1').dispatchEvent(new DragEvent('drop', { bubbles: true, cancelable: true, dataTransfer }));
               }""", np.ravel(blue).tolist())
        self.wait_for_color((220, 30, 10))
        self.expected = '422'  # the browser tells its console of answers that are none
        self.page.locator('#file').set_input_files({'name': 'no.png', 'mimeType': 'image/png', 'buffer': b'no'})
        self.page.wait_for_function("() => document.getElementById('status').textContent.includes('That is no picture')")
        self.wait_for_color((220, 30, 10))
        self.page.get_by_text('earth', exact=True).click()
        self.page.wait_for_function("() => document.querySelector('input[value=\"earth.jpg\"]').checked")

    def test_on_a_phone_nothing_is_wider_than_the_screen(self):
        self.page.set_viewport_size({'width': 360, 'height': 740})
        self.assertEqual(self.page.evaluate('document.documentElement.scrollWidth'), 360)
        self.assertTrue(self.page.get_by_role('button', name='Forward').is_visible())
        columns = {round(tile.bounding_box()['x']) for tile in self.page.locator('.tile').all()}
        self.assertEqual(len(columns), 2)

    def test_z_killing_the_server_stops_the_robot_and_leaves_the_nodes_alive(self):
        self.expected = 'ERR_CONNECTION'  # the browser tells its console of every attempt
        self.page.keyboard.down('ArrowDown')
        self.robot.wait(lambda x, forward, left: forward < -0.2)
        code, _, pid = ServerProxy(Master('/page_test').lookupNode('/page')).getPid('/page_test')
        self.assertEqual(code, 1)
        os.kill(pid, signal.SIGKILL)
        self.robot.wait(lambda x, forward, left: forward == 0)
        self.page.wait_for_function("() => document.getElementById('status').textContent.includes('does not answer')")
        for number in range(2, 7):
            image = rospy.wait_for_message('/exercise5_%d/image' % number, Image, WAIT_S)
            self.assertGreater(frame_from_image(image).std(), 20)


if __name__ == '__main__':
    sys.stdout.reconfigure(line_buffering=True)
    rospy.init_node('page_test')
    rostest.rosrun('unit5', 'page_test', Page)
