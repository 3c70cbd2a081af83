#!/usr/bin/env python3
"""A gray mask; the area is set to black where it is white."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
DETECTOR = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())


def subtract_area(image):
    mask = np.zeros(image.shape[:2], np.uint8)
    corners, ids, _ = DETECTOR.detectMarkers(image)
    if ids is not None and len(ids) == 4:
        hull = cv2.convexHull(np.array([quad[0].mean(axis=0) for quad in corners]))
        cv2.fillPoly(mask, [np.int32(hull)], 255)
    image[mask == 255] = 0
    return mask, image


def main():
    rospy.init_node('my_exercise5_5')
    bridge = CvBridge()
    publishers = [rospy.Publisher(name, Image, queue_size=1) for name in ('~mask', '~image')]

    def callback(message):
        outputs = subtract_area(bridge.imgmsg_to_cv2(message, 'bgr8'))
        for publisher, output, encoding in zip(publishers, outputs, ('mono8', 'bgr8')):
            result = bridge.cv2_to_imgmsg(output, encoding)
            result.header = message.header
            publisher.publish(result)

    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
