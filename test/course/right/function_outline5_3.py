#!/usr/bin/env python3
"""Centers where the diagonals cross, an outline, and a number beside each center."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
DETECTOR = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())


def crossing(quad):
    a, b, c, d = np.hstack([quad, np.ones((4, 1))])
    x, y, w = np.cross(np.cross(a, c), np.cross(b, d))
    return x / w, y / w


def extract_centers(image):
    corners, _, _ = DETECTOR.detectMarkers(image)
    points = np.array([crossing(quad[0]) for quad in corners]).round().astype(int)
    if len(points):
        cv2.polylines(image, [points], True, (0, 200, 255), 3, cv2.LINE_AA)
    for number, (x, y) in enumerate(points):
        cv2.putText(image, str(number), (int(x) + 5, int(y) - 5), cv2.FONT_HERSHEY_PLAIN, 1, (255, 255, 255), 1)
    return image


def main():
    rospy.init_node('my_exercise5_3')
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        result = bridge.cv2_to_imgmsg(extract_centers(bridge.imgmsg_to_cv2(message, 'bgr8')), 'bgr8')
        result.header = message.header
        publisher.publish(result)

    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
