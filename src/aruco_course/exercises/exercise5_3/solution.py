#!/usr/bin/env python3
"""Exercise 5.3: find the centers of the tags.

The center of a tag is the mean of its four corners. The polygon through the four
centers will be the area for a picture. For now its corners come as the tags were
found, so it usually crosses itself.
"""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def extract_centers(image):
    """The image, with the polygon through the centers of four tags, in the order in which they were found.

    image: an array of height x width x 3 numbers from 0 to 255: blue, green, red.
    """
    # Task 1: Find the tags, as in exercise 5.2. You can copy your lines. If there are not four tags, return
    # the image as it is.
    ### BEGIN SOLUTION
    detector = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    if ids is None or len(ids) != 4:
        return image
    ### END SOLUTION

    # Task 2: Make an array of shape (4, 2) of the centers. A center is the mean of a tag's four corners: the
    # mean of their x, and the mean of their y. The corners of a tag are an array of shape (1, 4, 2).
    ### BEGIN SOLUTION
    centers = np.array([quad[0].mean(axis=0) for quad in corners])
    ### END SOLUTION

    # Task 3: Fill the polygon through the centers with cv2.drawContours, as they come. It takes a list of
    # polygons, and their corners must be whole numbers, int32. A thickness of -1 fills.
    ### BEGIN SOLUTION
    cv2.drawContours(image, [centers.astype(np.int32)], -1, (255, 0, 150), -1)
    ### END SOLUTION
    return image


def main():
    """Listen to the camera, and publish what the function makes of each frame."""
    rospy.init_node('my_exercise5_3')
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        image = bridge.imgmsg_to_cv2(message, 'bgr8')
        result = bridge.cv2_to_imgmsg(extract_centers(image), 'bgr8')
        result.header = message.header  # when it was seen, and by which camera
        publisher.publish(result)

    # With one place in the queue, and room for whole frames, a slow callback gets the newest frame.
    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
