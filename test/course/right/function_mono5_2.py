#!/usr/bin/env python3
"""Drawn on the gray image."""
import cv2
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
DETECTOR = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())


def detect_tags(image):
    gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    corners, ids, _ = DETECTOR.detectMarkers(gray)
    return cv2.aruco.drawDetectedMarkers(gray, corners, ids, 255)


def main():
    rospy.init_node('my_exercise5_2')
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        result = bridge.cv2_to_imgmsg(detect_tags(bridge.imgmsg_to_cv2(message, 'bgr8')), 'mono8')
        result.header = message.header
        publisher.publish(result)

    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
