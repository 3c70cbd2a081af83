#!/usr/bin/env python3
"""The picture stays where it is while tags are covered, for as long as ~hold without any."""
import queue
import unittest

import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_image, image_from_frame
from rig.nodes import CENTERS, scene
from rig.started import WAIT_S
from sensor_msgs.msg import Image
from std_msgs.msg import Header

(LEFT, TOP), (RIGHT, BOTTOM) = CENTERS[1], CENTERS[3]


class Tracking(unittest.TestCase):
    def setUp(self):
        self._results = queue.Queue()
        self._subscriber = rospy.Subscriber('/exercise5_6/image', Image, self._results.put, buff_size=1 << 24)
        self._publisher = rospy.Publisher('/camera/rgb/image_raw', Image, queue_size=1)
        self._connected()

    def _connected(self):
        """Wait until a frame is answered: then the node listens."""
        end = rospy.Time.now() + rospy.Duration(WAIT_S)
        while rospy.Time.now() < end:
            self._publisher.publish(image_from_frame(scene([]), Header(stamp=rospy.Time(1))))
            try:
                self._results.get(timeout=0.2)
            except queue.Empty:
                continue
            while self._answered():  # earlier ones are on their way
                pass
            return
        self.fail('no frame is answered')

    def _answered(self):
        try:
            return self._results.get(timeout=1.0)
        except queue.Empty:
            return None

    def painted(self, frame, seconds):
        """Where the answer to a frame of that time differs from it, as a boolean mask."""
        stamp = rospy.Time(100) + rospy.Duration(seconds)
        self._publisher.publish(image_from_frame(frame, Header(stamp=stamp)))
        answer = self._results.get(timeout=WAIT_S)
        self.assertEqual(answer.header.stamp, stamp)
        return np.any(frame_from_image(answer) != frame, axis=2)

    def assert_painted(self, mask):
        """The area between the four centers, and nothing else, to a pixel or two."""
        self.assertTrue(mask[TOP + 2:BOTTOM - 1, LEFT + 2:RIGHT - 1].mean() > 0.99)
        mask[TOP - 1:BOTTOM + 2, LEFT - 1:RIGHT + 2] = False
        self.assertFalse(mask.any())

    def test_the_picture_stays_while_tags_are_covered(self):
        self.assert_painted(self.painted(scene(), 0.0))
        for count, ids in enumerate([(2, 3, 4), (1, 3), (4,), (1, 2, 3, 4)], start=1):
            self.assert_painted(self.painted(scene(ids), count / 30))

    def test_without_any_tag_it_stays_for_the_time_of_hold(self):
        self.assert_painted(self.painted(scene(), 10.0))
        for frame in range(1, 10):
            self.assert_painted(self.painted(scene([]), 10.0 + frame / 30))
        self.assertFalse(self.painted(scene([]), 10.35).any())
        self.assertFalse(self.painted(scene([]), 10.4).any())

    def test_where_time_goes_back_all_starts_afresh(self):
        self.assert_painted(self.painted(scene(), 30.0))
        self.assertFalse(self.painted(scene([1, 2, 3]), 5.0).any())
        self.assert_painted(self.painted(scene(), 5.1))


if __name__ == '__main__':
    rospy.init_node('tracking_test')
    rostest.rosrun('unit5', 'tracking_test', Tracking)
