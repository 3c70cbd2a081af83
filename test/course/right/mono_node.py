#!/usr/bin/env python3
"""Exercise 5.4 in gray; the callback only keeps the newest frame, and a loop works on it."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

frames = []


def keep(message):
    frames[:] = [message]


def main():
    rospy.init_node('my_gray', anonymous=False)
    bridge = CvBridge()
    publisher = rospy.Publisher('~image', Image, queue_size=1)
    rospy.Subscriber('/camera/rgb/image_raw', Image, keep)
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250))
    rate = rospy.Rate(20)
    while not rospy.is_shutdown():
        for newest in frames:
            gray = bridge.imgmsg_to_cv2(newest, 'mono8').copy()
            corners, ids, _ = detector.detectMarkers(gray)
            if ids is not None and len(ids) == 4:
                x, y = np.transpose([quad[0].mean(axis=0) for quad in corners])
                order = [np.argmin(x + y), np.argmax(x - y), np.argmax(x + y), np.argmin(x - y)]
                points = np.stack([x[order], y[order]], axis=1).astype(int)
                cv2.fillConvexPoly(gray, points, 255, cv2.LINE_AA)
            publisher.publish(bridge.cv2_to_imgmsg(gray, 'mono8'))
        try:
            rate.sleep()
        except rospy.ROSInterruptException:
            break


if __name__ == '__main__':
    main()
