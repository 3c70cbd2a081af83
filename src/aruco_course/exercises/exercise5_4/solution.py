#!/usr/bin/env python3
"""Exercise 5.4: put the centers in order.

The polygon of exercise 5.3 usually crosses itself. In the order top left, top
right, bottom right, bottom left, it goes around and does not.
"""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def order_centers(image):
    """The image, with the polygon through the centers of four tags, in order.

    image: an array of height x width x 3 numbers from 0 to 255: blue, green, red.
    """
    # Task 1: Find the tags and their centers, as in exercise 5.3. You can copy your lines. If there are not
    # four tags, return the image as it is.
    ### BEGIN SOLUTION
    detector = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    if ids is None or len(ids) != 4:
        return image
    centers = np.array([quad[0].mean(axis=0) for quad in corners])
    ### END SOLUTION

    # Task 2: Put the centers in order. In an image, x grows to the right and y grows down. At which corner is
    # x + y least, and at which is it greatest? What does y - x say?
    ### BEGIN SOLUTION
    total = centers[:, 0] + centers[:, 1]
    difference = centers[:, 1] - centers[:, 0]
    ordered = centers[[np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]]
    ### END SOLUTION

    # Task 3: Fill the polygon through the centers in their order, as in exercise 5.3.
    ### BEGIN SOLUTION
    cv2.drawContours(image, [ordered.astype(np.int32)], -1, (255, 0, 150), -1)
    ### END SOLUTION
    return image


def main():
    """Listen to the camera, and publish what the function makes of each frame."""
    rospy.init_node('my_exercise5_4')
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        image = bridge.imgmsg_to_cv2(message, 'bgr8')
        result = bridge.cv2_to_imgmsg(order_centers(image), 'bgr8')
        result.header = message.header  # when it was seen, and by which camera
        publisher.publish(result)

    # With one place in the queue, and room for whole frames, a slow callback gets the newest frame.
    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
