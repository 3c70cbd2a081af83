#!/usr/bin/env python3
"""A camera is calibrated while it runs: the page shows the progress, and a service saves the result."""
import itertools
import os
import pathlib
import re
import tempfile

import rospy
import rostest
import yaml
from aruco_ar.calibration.calibrate import corners_apart
from aruco_node.messages.images import image_from_frame
from rig.accuracy.sheets import BARREL, frames_of, lens_of_file
from rig.nodes.case import CAMERA
from rig.nodes.topics import until
from rig.page.browser import BrowserTest
from rig.processes.started import WAIT_S, node
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger

TILE = '.tile[data-topic="/calibrate_live/image"]'
REPEATED = 4  # frames that the sheet is held still


class CalibrateLive(BrowserTest):
    tiles = 2

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = os.path.join(folder.name, 'camera_info', 'webcam.yaml')
        self.frames = list(frames_of(BARREL, pathlib.Path(folder.name, 'wall.yaml')))
        self.shown = self.frames[:3]
        self.publisher = rospy.Publisher(CAMERA, Image, queue_size=1)
        self.addCleanup(self.publisher.unregister)
        self.node = node('calibrate_live.py', '_file:=file://' + self.file, '_camera_name:=webcam')
        self.addCleanup(self.node.stop)
        rospy.wait_for_service('/calibrate_live/save', WAIT_S)
        numbers = itertools.count()

        def show(event):
            number = next(numbers)
            frame = self.shown[number // REPEATED % len(self.shown)]
            self.publisher.publish(image_from_frame(frame, Header(stamp=rospy.Time.now())))
        timer = rospy.Timer(rospy.Duration(1 / 15), show)
        self.addCleanup(timer.shutdown)
        super().setUp()

    def call(self, service):
        answer = rospy.ServiceProxy('/calibrate_live/' + service, Trigger)()
        return answer.success, answer.message

    def test_the_page_says_what_is_missing_until_the_lens_is_found_and_it_can_be_saved(self):
        self.assertEqual(self.page.locator('.tile .name').all_inner_texts(),
                         ['5.1 The wall with its tags', 'Calibration'])
        self.wait_for_text(TILE + ' .advice', '3 views')
        done, said = self.call('save')
        self.assertTrue(not done and said.startswith('Nothing is saved. Show the sheet'), said)
        self.shown = self.frames[:12]  # from which enough views are kept
        self.wait_for_text(TILE + ' .advice', 'To save it: rosservice call /calibrate_live/save')
        done, said = self.call('save')
        self.assertTrue(done and 'It is saved as %s.' % self.file in said, said)
        self.wait_for_text(TILE + ' .advice', 'It is saved as')
        lens = lens_of_file(self.file)
        self.assertAlmostEqual(lens.matrix[0, 0] / BARREL.matrix[0, 0], 1, delta=0.01)
        self.assertLess(corners_apart(lens, BARREL.lens).max(), 0.5)
        with open(self.file) as file:
            self.assertEqual(yaml.safe_load(file)['camera_name'], 'webcam')
        self.shown = self.frames  # more views tell other lenses, which are hardly better
        self.wait_for_text(TILE + ' .advice', 'It is saved as %s. Newer views move the corners of the image by '
                           '0.' % self.file)
        self.shown = self.frames[:1]
        self.assertEqual(self.call('reset'), (True, 'All views are forgotten.'))
        advice = self.page.locator(TILE + ' .advice')
        until(lambda: re.match(r'[12] views?, ', advice.inner_text()))  # an earlier frame may be late


if __name__ == '__main__':
    rospy.init_node('calibrate_live_test')
    rostest.rosrun('unit5', 'calibrate_live_test', CalibrateLive)
