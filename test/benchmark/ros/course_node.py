"""A plain rospy node with the course's code, as a student would write it. Arguments: dictionary and ids."""
import os
import sys

import rospy
from aruco_ar import load_picture
from cv_bridge import CvBridge
from rig import PACKAGE
from sensor_msgs.msg import Image

from benchmark.course import Course


class CourseNode:
    def __init__(self, dictionary='DICT_6X6_250', *ids):
        self._course = Course(dictionary, load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg')),
                              tuple(map(int, ids)))
        self._bridge = CvBridge()
        self._publisher = rospy.Publisher('result', Image, queue_size=1)
        rospy.Subscriber('camera/rgb/image_raw', Image, self._on_image, queue_size=1, buff_size=1 << 26)

    def _on_image(self, message):
        frame = self._bridge.imgmsg_to_cv2(message, desired_encoding='bgr8')
        painted, _ = self._course.paint(frame)
        result = self._bridge.cv2_to_imgmsg(painted, 'bgr8')
        result.header = message.header
        self._publisher.publish(result)


rospy.init_node('course')
CourseNode(*sys.argv[1:])
rospy.spin()
