#!/usr/bin/env python3
"""Exercise 5.4 with message_filters: it takes a frame together with the camera's calibration."""
import cv2
import message_filters
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import CameraInfo, Image

bridge = CvBridge()
dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)


def callback(image_message, info_message):
    frame = bridge.imgmsg_to_cv2(image_message, 'rgb8').copy()
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary).detectMarkers(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY))
    if ids is not None and ids.size == 4:
        centers = np.array([np.mean(each[0], axis=0) for each in corners], np.int32)
        cv2.fillPoly(frame, [cv2.convexHull(centers)], (120, 30, 200))
    answer = bridge.cv2_to_imgmsg(frame, encoding='rgb8')
    answer.header.stamp = rospy.Time.now()
    publisher.publish(answer)


rospy.init_node('with_filters')
publisher = rospy.Publisher('/filtered/image', Image, queue_size=1)
inputs = [message_filters.Subscriber('/camera/rgb/image_raw', Image),
          message_filters.Subscriber('/camera/rgb/camera_info', CameraInfo)]
synchronizer = message_filters.ApproximateTimeSynchronizer(inputs, 10, 0.05)
synchronizer.registerCallback(callback)
rospy.spin()
