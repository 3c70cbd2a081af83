#!/usr/bin/env python3
"""Exercise 5.3, as the course's text has it, in today's OpenCV."""
import cv2
import numpy as np
import rospy
from cv2 import aruco
from cv_bridge import CvBridge
from sensor_msgs.msg import Image


def extract_centers(image):
    h, w = image.shape[:2]
    image = cv2.resize(image, (int(w * 0.7), int(h * 0.7)))
    gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)

    # find the corners and ids of all tags
    aruco_dict = aruco.getPredefinedDictionary(aruco.DICT_6X6_250)
    parameters = aruco.DetectorParameters()
    corners, ids, rejected = aruco.ArucoDetector(aruco_dict, parameters).detectMarkers(gray)

    params = []
    for i in range(len(ids)):
        # the corners of this tag
        c = corners[i][0]
        # a circle at its center, which is kept
        cv2.circle(image, (int(c[:, 0].mean()), int(c[:, 1].mean())), 3, (255, 255, 0), -1)
        params.append((int(c[:, 0].mean()), int(c[:, 1].mean())))
    params = np.array(params)

    # the polygon through the centers, as they come
    cv2.drawContours(image, [params], -1, (255, 0, 150), -1)
    return image


class ArTags:

    def __init__(self):
        self.bridge = CvBridge()
        self.publisher = rospy.Publisher('~image', Image, queue_size=1)
        self.subscriber = rospy.Subscriber('/camera/rgb/image_raw', Image, self.camera_callback, queue_size=1,
                                           buff_size=2**24)

    def camera_callback(self, data):
        image = self.bridge.imgmsg_to_cv2(data, desired_encoding='bgr8')
        result = self.bridge.cv2_to_imgmsg(extract_centers(image), 'bgr8')
        result.header = data.header
        self.publisher.publish(result)


def main():
    rospy.init_node('my_exercise5_3')
    ArTags()
    rospy.spin()


if __name__ == '__main__':
    main()
