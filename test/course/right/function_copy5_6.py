#!/usr/bin/env python3
"""The picture is warped, and copied where the mask is white. What it shows is drawn finer."""
import os

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

PICTURE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'images', 'earth.jpg')
DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
DETECTOR = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())


def paint_picture(image, picture):
    gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    corners, ids, _ = DETECTOR.detectMarkers(gray)
    if ids is None or len(ids) < 4:
        return image
    middle = np.float32([quad[0].mean(axis=0) for quad in corners[:4]])
    by_height = middle[middle[:, 1].argsort()]
    top, bottom = (half[half[:, 0].argsort()] for half in (by_height[:2], by_height[2:]))
    area = np.float32([top[0], top[1], bottom[1], bottom[0]])
    height, width = picture.shape[:2]
    edges = np.float32([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]])
    size = image.shape[1::-1]
    warped = cv2.warpPerspective(picture, cv2.getPerspectiveTransform(edges, area), size, flags=cv2.INTER_AREA)
    mask = cv2.fillConvexPoly(np.zeros(image.shape[:2], np.uint8), area.astype(int), 255)
    return np.where(mask[..., None] > 0, warped, image)


def main():
    rospy.init_node('my_exercise5_6')
    bridge = CvBridge()
    picture = cv2.imread(PICTURE)
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        result = bridge.cv2_to_imgmsg(paint_picture(bridge.imgmsg_to_cv2(message, 'bgr8'), picture), 'bgr8')
        result.header = message.header
        publisher.publish(result)

    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
