#!/usr/bin/env python3
"""The picture stays in place while tags are covered, and without any tag for the time of ~hold."""
import queue
import unittest

import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_image, image_from_frame
from rig.nodes.case import CENTERS, scene
from rig.processes.started import WAIT_S
from sensor_msgs.msg import Image
from std_msgs.msg import Header

(LEFT, TOP), (RIGHT, BOTTOM) = CENTERS[1], CENTERS[3]


class Tracking(unittest.TestCase):
    def setUp(self):
        self._results = queue.Queue()
        self._subscriber = rospy.Subscriber('/exercise5_6/image', Image, self._results.put, buff_size=1 << 24)
        self._publisher = rospy.Publisher('/camera/rgb/image_raw', Image, queue_size=1)
        self._wait_for_node()

    def _wait_for_node(self):
        """Wait until a frame is answered, which means that the node has subscribed."""
        end = rospy.Time.now() + rospy.Duration(WAIT_S)
        while rospy.Time.now() < end:
            self._publisher.publish(image_from_frame(scene([]), Header(stamp=rospy.Time(1))))
            try:
                self._results.get(timeout=0.2)
            except queue.Empty:
                continue
            return
        self.fail('no frame was answered')

    def changed_pixels(self, frame, seconds):
        """Where the answer to a frame with that stamp differs from the frame, as a boolean mask."""
        stamp = rospy.Time(100) + rospy.Duration(seconds)
        self._publisher.publish(image_from_frame(frame, Header(stamp=stamp)))
        answer = self._results.get(timeout=WAIT_S)
        while answer.header.stamp != stamp:  # there may be answers to earlier frames
            answer = self._results.get(timeout=WAIT_S)
        return np.any(frame_from_image(answer) != frame, axis=2)

    def assert_painted(self, mask):
        """Assert that the area between the four centers is painted, and nothing else, to a pixel or two."""
        self.assertTrue(mask[TOP + 2:BOTTOM - 1, LEFT + 2:RIGHT - 1].mean() > 0.99)
        mask[TOP - 1:BOTTOM + 2, LEFT - 1:RIGHT + 2] = False
        self.assertFalse(mask.any())

    def test_the_picture_stays_while_tags_are_covered(self):
        self.assert_painted(self.changed_pixels(scene(), 0.0))
        for count, ids in enumerate([(2, 3, 4), (1, 3), (4,), (1, 2, 3, 4)], start=1):
            self.assert_painted(self.changed_pixels(scene(ids), count / 30))

    def test_without_any_tag_the_picture_stays_for_the_time_of_hold(self):
        self.assert_painted(self.changed_pixels(scene(), 10.0))
        for frame in range(1, 10):
            self.assert_painted(self.changed_pixels(scene([]), 10.0 + frame / 30))
        self.assertFalse(self.changed_pixels(scene([]), 10.35).any())
        self.assertFalse(self.changed_pixels(scene([]), 10.4).any())

    def test_everything_is_forgotten_if_the_time_goes_back(self):
        self.assert_painted(self.changed_pixels(scene(), 30.0))
        self.assertFalse(self.changed_pixels(scene([1, 2, 3]), 5.0).any())
        self.assert_painted(self.changed_pixels(scene(), 5.1))


if __name__ == '__main__':
    rospy.init_node('tracking_test')
    rostest.rosrun('unit5', 'tracking_test', Tracking)
