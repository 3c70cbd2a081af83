#!/usr/bin/env python3
"""Exercise 5.6, as the course's text has it, in today's OpenCV."""
import os

import cv2
import numpy as np
import rospy
from cv2 import aruco
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

EARTH = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'images', 'earth.jpg')


def order_coordinates(pts, var):
    coordinates = np.zeros((4, 2), dtype='int')
    s = pts.sum(axis=1)
    diff = np.diff(pts, axis=1)
    if var:  # row by row, for the homography
        coordinates[0] = pts[np.argmin(s)]
        coordinates[3] = pts[np.argmax(s)]
        coordinates[1] = pts[np.argmin(diff)]
        coordinates[2] = pts[np.argmax(diff)]
    else:  # around, for the polygon
        coordinates[0] = pts[np.argmin(s)]
        coordinates[2] = pts[np.argmax(s)]
        coordinates[1] = pts[np.argmin(diff)]
        coordinates[3] = pts[np.argmax(diff)]
    return coordinates


def paint_picture(image, picture):
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

    if len(params) >= 4:
        params = order_coordinates(params, False)
        params_2 = order_coordinates(params, True)

    # the corners of the picture, row by row
    paint = picture
    height, width = paint.shape[:2]
    coordinates = np.array([[0, 0], [width, 0], [0, height], [width, height]])

    # from the picture's corners to the centers
    hom, status = cv2.findHomography(coordinates, params_2)
    warped_image = cv2.warpPerspective(paint, hom, (int(w * 0.7), int(h * 0.7)))

    # black, and white in the area
    mask = np.zeros([int(h * 0.7), int(w * 0.7), 3], dtype=np.uint8)
    cv2.fillConvexPoly(mask, np.int32([params]), (255, 255, 255), cv2.LINE_AA)
    subtraction = cv2.subtract(image, mask)
    addition = cv2.add(warped_image, subtraction)
    return addition


class ArTags:

    def __init__(self):
        self.bridge = CvBridge()
        self.picture = cv2.imread(EARTH)
        self.publisher = rospy.Publisher('~image', Image, queue_size=1)
        self.subscriber = rospy.Subscriber('/camera/rgb/image_raw', Image, self.camera_callback, queue_size=1,
                                           buff_size=2**24)

    def camera_callback(self, data):
        image = self.bridge.imgmsg_to_cv2(data, desired_encoding='bgr8')
        result = self.bridge.cv2_to_imgmsg(paint_picture(image, self.picture), 'bgr8')
        result.header = data.header
        self.publisher.publish(result)


def main():
    rospy.init_node('my_exercise5_6')
    ArTags()
    rospy.spin()


if __name__ == '__main__':
    main()
