#!/usr/bin/env python3
"""Exercise 5.4 as a class, at 0.7 of the size, with circles; angles put the centers in order."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image


class Polygon:
    def __init__(self):
        self.bridge = CvBridge()
        self.detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250))
        self.publisher = rospy.Publisher('/my/polygon', Image, queue_size=10)
        self.subscriber = rospy.Subscriber('/camera/rgb/image_raw', Image, self.on_image)

    def on_image(self, message):
        try:
            image = self.bridge.imgmsg_to_cv2(message, desired_encoding='bgr8')
        except CvBridgeError as error:
            rospy.logerr(error)
            return
        image = cv2.resize(image, None, fx=0.7, fy=0.7)
        corners, ids, _ = self.detector.detectMarkers(image)
        if ids is not None and len(ids) == 4:
            centers = self.around([quad.reshape(4, 2).mean(axis=0) for quad in corners])
            cv2.fillPoly(image, [np.int32(centers)], (0, 200, 255))
            for x, y in np.int32(centers):
                cv2.circle(image, (int(x), int(y)), 4, (0, 0, 255), -1)
        self.publisher.publish(self.bridge.cv2_to_imgmsg(image, 'bgr8'))

    @staticmethod
    def around(centers):
        middle = np.mean(centers, axis=0)
        return sorted(centers, key=lambda center: np.arctan2(*(center - middle)))


if __name__ == '__main__':
    rospy.init_node('polygon', anonymous=True)
    Polygon()
    rospy.spin()
