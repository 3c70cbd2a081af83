#!/usr/bin/env python3
"""The rest is kept by bitwise_and, with the negative of the mask."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
DETECTOR = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())


def subtract_area(image):
    corners, ids, _ = DETECTOR.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    mask = np.zeros_like(image)
    if ids is not None and len(ids) == 4:
        c = np.array([quad[0].mean(axis=0) for quad in corners])
        left, right = np.split(c[np.argsort(c[:, 0])], 2)
        left, right = left[np.argsort(left[:, 1])], right[np.argsort(right[:, 1])]
        cv2.fillConvexPoly(mask, np.int32([left[0], right[0], right[1], left[1]]), (255, 255, 255))
    return mask, cv2.bitwise_and(image, cv2.bitwise_not(mask))


def main():
    rospy.init_node('my_exercise5_5')
    bridge = CvBridge()
    publishers = [rospy.Publisher(name, Image, queue_size=1) for name in ('~mask', '~image')]

    def callback(message):
        outputs = subtract_area(bridge.imgmsg_to_cv2(message, 'bgr8'))
        for publisher, output, encoding in zip(publishers, outputs, ('bgr8', 'bgr8')):
            result = bridge.cv2_to_imgmsg(output, encoding)
            result.header = message.header
            publisher.publish(result)

    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
