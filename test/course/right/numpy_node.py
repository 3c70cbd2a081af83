#!/usr/bin/env python3
"""Exercise 5.4 without cv_bridge, and with nothing of OpenCV but its search for tags; the image has alpha."""
import cv2
import numpy as np
import rospy
from sensor_msgs.msg import Image


def inside(corners, height, width):
    """The pixels to the right of all sides of a convex polygon that goes around clockwise."""
    y, x = np.mgrid[:height, :width]
    mask = np.ones((height, width), bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0)):
        mask &= (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) >= 0
    return mask


def on_image(message):
    pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    rgb = pixels[:, :3 * message.width].reshape(message.height, message.width, 3)
    found, ids, _ = detector.detectMarkers(np.ascontiguousarray(rgb[..., 1]))
    rgba = np.dstack([rgb, np.full(rgb.shape[:2], 255, np.uint8)])
    if ids is not None and len(ids) == 4:
        centers = np.concatenate(found).mean(axis=1)
        offsets = centers - centers.mean(axis=0)
        around = centers[np.argsort(np.arctan2(offsets[:, 1], offsets[:, 0]))]
        rgba[inside(around, *rgb.shape[:2])] = 0, 90, 0, 255
    publisher.publish(Image(header=message.header, height=message.height, width=message.width, encoding='rgba8',
                            step=4 * message.width, data=rgba.tobytes()))


if __name__ == '__main__':
    rospy.init_node('without_bridge')
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250))
    publisher = rospy.Publisher('/plain/image', Image, queue_size=1)
    rospy.Subscriber('/camera/rgb/image_raw', Image, on_image, queue_size=1, buff_size=1 << 24)
    rospy.spin()
