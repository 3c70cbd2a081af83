#!/usr/bin/env python3
"""Exercise 5.5: subtract the area between the tags.

A mask is an image that is white in the area, and black elsewhere. Where it is
subtracted from the camera's image, the area becomes black.
"""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def subtract_area(image):
    """The mask of the area between four tags, and the image without this area.

    image: an array of height x width x 3 numbers from 0 to 255: blue, green, red. The mask has the same shape.
    """
    mask = np.zeros_like(image)  # black
    # Task 1: Find the tags and their centers, and put them in order, as in exercise 5.4. You can copy your
    # lines. If there are not four tags, return the black mask, and the image as it is.
    ### BEGIN SOLUTION
    detector = cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters())
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    if ids is None or len(ids) != 4:
        return mask, image
    centers = np.array([quad[0].mean(axis=0) for quad in corners])
    total = centers[:, 0] + centers[:, 1]
    difference = centers[:, 1] - centers[:, 0]
    ordered = centers[[np.argmin(total), np.argmin(difference), np.argmax(total), np.argmax(difference)]]
    ### END SOLUTION

    # Task 2: Fill the area in the mask with white, which is 255 in each of blue, green and red. Draw on the
    # mask, not on the image.
    ### BEGIN SOLUTION
    cv2.fillConvexPoly(mask, ordered.astype(np.int32), (255, 255, 255))
    ### END SOLUTION

    # Task 3: Subtract the mask from the image. What becomes of a pixel if 255 is subtracted, what if 0 is? And
    # which subtraction stops at 0: that of cv2, or that of NumPy?
    ### BEGIN SOLUTION
    image = cv2.subtract(image, mask)
    ### END SOLUTION
    return mask, image


def main():
    """Listen to the camera, and publish what the function makes of each frame."""
    rospy.init_node('my_exercise5_5')
    bridge = CvBridge()
    mask_publisher = rospy.Publisher('~mask', Image, queue_size=1)
    publisher = rospy.Publisher('~image', Image, queue_size=1)

    def callback(message):
        image = bridge.imgmsg_to_cv2(message, 'bgr8')
        mask, result = subtract_area(image)
        for array, to in (mask, mask_publisher), (result, publisher):
            answer = bridge.cv2_to_imgmsg(array, 'bgr8' if array.ndim == 3 else 'mono8')
            answer.header = message.header  # when it was seen, and by which camera
            to.publish(answer)

    # With one place in the queue, and room for whole frames, a slow callback gets the newest frame.
    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, buff_size=2**24)
    rospy.spin()


if __name__ == '__main__':
    main()
