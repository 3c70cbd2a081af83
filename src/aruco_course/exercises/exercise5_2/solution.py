#!/usr/bin/env python3
"""Exercise 5.2: detect the tags.

A tag is a black square with a pattern of cells. The pattern stands for a number,
the tag's id. The detector finds the tags' corners and ids; this node draws them.
"""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def detect_tags(image):
    """The image, with each tag outlined, and its id written beside it.

    image: an array of height x width x 3 numbers from 0 to 255: blue, green, red.
    """
    # Task 1: Make the image gray with cv2.cvtColor. Make a cv2.aruco.ArucoDetector of the DICTIONARY and of
    # cv2.aruco.DetectorParameters(), and let it detectMarkers. It returns the corners, the ids, and
    # candidates that are no tags. If no tag is in sight, the ids are None; then return the image as it is.
    ### BEGIN SOLUTION
    detector = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    if ids is None:
        return image
    ### END SOLUTION

    # Task 2: Outline each tag: draw lines from corner to corner, and back to the first. The corners of a tag
    # are an array of shape (1, 4, 2), of fractions of pixels, while cv2.polylines takes whole numbers, int32.
    ### BEGIN SOLUTION
    for quad in corners:
        cv2.polylines(image, [np.round(quad[0]).astype(np.int32)], True, (0, 255, 0), 2)
    ### END SOLUTION

    # Task 3: Write each tag's id beside it with cv2.putText. The ids are an array of shape (n, 1).
    ### BEGIN SOLUTION
    for quad, tag_id in zip(corners, ids.ravel()):
        left, top = quad[0].min(axis=0)
        cv2.putText(image, str(tag_id), (int(left), int(top) - 6), 0, 0.6, (0, 0, 255), 2)
    ### END SOLUTION
    return image


def main():
    """Listen to the camera, and publish what the function makes of each frame."""
    rospy.init_node('my_exercise5_2')
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        image = bridge.imgmsg_to_cv2(message, 'bgr8')
        result = bridge.cv2_to_imgmsg(detect_tags(image), 'bgr8')
        result.header = message.header  # when it was seen, and by which camera
        publisher.publish(result)

    # With one place in the queue, and room for whole frames, a slow callback gets the newest frame.
    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
