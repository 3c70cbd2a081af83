#!/usr/bin/env python3
"""The launch file of exercise 5.2 with a real photo."""
import glob
import unittest

import cv2
import numpy as np
import rospy
import rostest
from aruco_ar import Detector, mark_tags
from aruco_node.messages.images import frame_from_image
from rig.processes.skip import skip
from rig.processes.started import Started
from sensor_msgs.msg import Image

DOCS = '/usr/share/doc/opencv-doc'


class Photo(unittest.TestCase):
    def test_the_six_tags_are_outlined_and_numbered(self):
        # The package opencv-doc has it as JPEG or PNG, depending on its version.
        paths = [path for kind in ('jpg', 'png')
                 for path in glob.glob('%s/**/singlemarkersoriginal.%s' % (DOCS, kind), recursive=True)]
        if not paths:
            skip(self.id(), 'the photo singlemarkersoriginal is missing; it is in the package opencv-doc')
        camera = Started('rosrun', 'image_publisher', 'image_publisher', paths[0], '__name:=photo')
        self.addCleanup(camera.stop)
        photo = cv2.imread(paths[0])
        tags = Detector().detect(photo)
        self.assertEqual(sorted(tag.id for tag in tags), [23, 40, 62, 98, 124, 203])
        result = frame_from_image(rospy.wait_for_message('/exercise5_2/image', Image, 50))
        np.testing.assert_array_equal(result, mark_tags(photo, tags))
        for tag in tags:  # they are outlined on the photo itself, and numbered in the middle
            self.assertTrue(np.any(np.all(result == (0, 255, 0), axis=2)[box(tag.corners)]))
            self.assertTrue(np.any(np.all(result == (0, 255, 255), axis=2)[box(tag.corners)]))


def box(corners):
    left, top = np.int32(corners.min(axis=0))
    right, bottom = np.int32(corners.max(axis=0))
    return slice(top, bottom), slice(left, right)


if __name__ == '__main__':
    rospy.init_node('photo_test')
    rostest.rosrun('unit5', 'photo_test', Photo)
