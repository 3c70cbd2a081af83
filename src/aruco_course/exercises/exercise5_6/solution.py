#!/usr/bin/env python3
"""Exercise 5.6: paint a picture into the area between the tags.

The picture is warped onto the area, and added where exercise 5.5 left black.
"""
import os

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
# The package's picture, wherever the node is started from.
PICTURE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'images', 'earth.jpg')


def paint_picture(image, picture):
    """The image, with the picture painted into the area between four tags.

    image, picture: arrays of height x width x 3 numbers from 0 to 255: blue, green, red. The two have different
    sizes.
    """
    # Task 1: Find the tags and their centers, and put them in order, as in exercise 5.4. You can copy your
    # lines. If there are not four tags, return the image as it is.
    ### BEGIN SOLUTION
    detector = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    if ids is None or len(ids) != 4:
        return image
    centers = np.array([quad[0].mean(axis=0) for quad in corners])
    total = centers[:, 0] + centers[:, 1]
    difference = centers[:, 1] - centers[:, 0]
    ordered = centers[[np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]]
    ### END SOLUTION

    # Task 2: Find the homography that takes the four corners of the picture to the four centers. List both in
    # the same order. A corner is (x, y): where is the bottom right one of a picture with that width and height?
    ### BEGIN SOLUTION
    height, width = picture.shape[:2]
    picture_corners = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    homography, _ = cv2.findHomography(picture_corners, ordered)
    ### END SOLUTION

    # Task 3: Warp the picture with it, to an image as large as the camera's. It is black outside of the area.
    ### BEGIN SOLUTION
    warped = cv2.warpPerspective(picture, homography, (image.shape[1], image.shape[0]))
    ### END SOLUTION

    # Task 4: Subtract the area from the image, as in exercise 5.5, and add the warped picture.
    ### BEGIN SOLUTION
    mask = np.zeros_like(image)
    cv2.fillConvexPoly(mask, ordered.astype(np.int32), (255, 255, 255))
    image = cv2.add(cv2.subtract(image, mask), warped)
    ### END SOLUTION
    return image


def main():
    """Listen to the camera, and publish what the function makes of each frame."""
    rospy.init_node('my_exercise5_6')
    picture = cv2.imread(PICTURE)  # once, not for each frame
    if picture is None:
        raise SystemExit('There is no picture ' + PICTURE)
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        image = bridge.imgmsg_to_cv2(message, 'bgr8')
        result = bridge.cv2_to_imgmsg(paint_picture(image, picture), 'bgr8')
        result.header = message.header  # when it was seen, and by which camera
        publisher.publish(result)

    # With one place in the queue, and room for whole frames, a slow callback gets the newest frame.
    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
