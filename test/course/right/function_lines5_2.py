#!/usr/bin/env python3
"""Thin lines and plain text beside each tag, in a whole frame."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
DETECTOR = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())


def detect_tags(image):
    corners, ids, _ = DETECTOR.detectMarkers(image)
    if ids is None:
        return image
    for quad, tag_id in zip(corners, ids.ravel()):
        points = np.rint(quad[0]).astype(int)
        for a, b in zip(points, np.roll(points, -1, axis=0)):
            cv2.line(image, tuple(a.tolist()), tuple(b.tolist()), (255, 0, 255), 1)
        cv2.putText(image, f'id {tag_id}', points[0].tolist(), cv2.FONT_HERSHEY_PLAIN, 1.2, (0, 255, 255), 1)
    return image


def main():
    rospy.init_node('my_exercise5_2')
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        result = bridge.cv2_to_imgmsg(detect_tags(bridge.imgmsg_to_cv2(message, 'bgr8')), 'bgr8')
        result.header = message.header
        publisher.publish(result)

    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
