#!/usr/bin/env python3
"""The simulated camera: its messages agree with each other, and the robot drives."""
import threading
import unittest

import message_filters
import numpy as np
import rospy
import rostest
import tf2_ros
from aruco_ar import Detector, find_area
from aruco_node.messages.images import frame_from_image
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PolygonStamped, Twist
from nav_msgs.msg import Odometry
from rig.processes.started import WAIT_S
from sensor_msgs.msg import CameraInfo, Image
from unit5.msg import TagArray


class WallCamera(unittest.TestCase):
    def wait_for_moment(self):
        """Wait for (image, camera_info, tags, area) with the same stamp."""
        arrived = threading.Event()
        found = []

        def on_messages(*messages):
            found[:] = messages
            arrived.set()
        subscribers = [message_filters.Subscriber(topic, kind, buff_size=1 << 24) for topic, kind in (
            ('/camera/rgb/image_raw', Image), ('/camera/rgb/camera_info', CameraInfo),
            ('/wall_camera/tags', TagArray), ('/wall_camera/area', PolygonStamped))]
        message_filters.TimeSynchronizer(subscribers, 20).registerCallback(on_messages)
        self.assertTrue(arrived.wait(WAIT_S), 'no frame arrived with its truth')
        for subscriber in subscribers:
            subscriber.unregister()
        return found

    def test_the_frame_the_truth_and_the_camera_info_agree(self):
        image, info, truth, area = self.wait_for_moment()
        self.assertEqual((image.width, image.height, image.encoding), (640, 480, 'rgb8'))
        self.assertEqual(image.header.frame_id, 'camera_rgb_optical_frame')
        self.assertAlmostEqual(2 * np.arctan(info.width / 2 / info.K[0]), 1.047, places=6)
        tags = Detector().detect(frame_from_image(image))
        self.assertEqual(sorted(tag.id for tag in tags), sorted(tag.id for tag in truth.tags))
        for tag in tags:
            true = next(other for other in truth.tags if other.id == tag.id)
            np.testing.assert_allclose(tag.corners, [(p.x, p.y) for p in true.corners], atol=1.5)
        np.testing.assert_allclose(find_area(tags).corners, [(p.x, p.y) for p in area.polygon.points],
                                   atol=1.0)

        # The transforms and the camera's matrix project tag 1 to where the truth says.
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        found = buffer.lookup_transform('camera_rgb_optical_frame', 'wall', rospy.Time(0),
                                        rospy.Duration(WAIT_S)).transform
        x, y, z, w = (getattr(found.rotation, axis) for axis in 'xyzw')
        rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        place = np.array([found.translation.x, found.translation.y, found.translation.z])
        tag_1 = np.array([-0.45, 0.85, 0])  # config/wall.yaml
        pixel = np.reshape(info.K, (3, 3)) @ (rotation @ tag_1 + place)
        corner = area.polygon.points[0]
        np.testing.assert_allclose(pixel[:2] / pixel[2], [corner.x, corner.y], atol=0.01)

    def test_the_truth_includes_a_shaking_hand_and_a_rolling_shutter(self):
        client = Client('/wall_camera', timeout=WAIT_S)
        self.addCleanup(client.close)
        usual = {'hand': 0.0, 'shutter': 0.0, 'jpeg': 0.0, 'exposure': 1.0}
        self.addCleanup(client.update_configuration, usual)
        steady = [(p.x, p.y) for p in self.wait_for_moment()[3].polygon.points]
        client.update_configuration({'hand': 3.0, 'shutter': 30.0, 'jpeg': 80.0, 'exposure': 0.7})
        corners = None
        while corners is None or np.abs(corners - steady).max() < 2:
            image, _, _, area = self.wait_for_moment()
            corners = np.array([(p.x, p.y) for p in area.polygon.points])
            found = find_area(Detector().detect(frame_from_image(image)))
            np.testing.assert_allclose(found.corners, corners, atol=1.0)

    def test_noise_and_light_can_be_changed_and_nan_is_refused(self):
        client = Client('/wall_camera', timeout=WAIT_S)
        self.addCleanup(client.close)

        def brightness():
            message = rospy.wait_for_message('/camera/rgb/image_raw', Image, WAIT_S)
            frame = frame_from_image(message).astype(float)
            return frame[100:300, 600:].mean(), np.abs(np.diff(frame[400:, :], axis=1)).mean()
        light, noise = brightness()
        client.update_configuration({'falloff': 0.9, 'noise': 20.0})
        darker, noisier = brightness()
        self.assertLess(darker, 0.8 * light)
        self.assertGreater(noisier, 4 * noise)
        self.assertEqual(client.update_configuration({'falloff': float('nan')})['falloff'], 0.9)
        client.update_configuration({'falloff': 0.3, 'noise': 2.0})
        np.testing.assert_allclose(brightness(), (light, noise), rtol=0.05)

    def test_it_drives_by_cmd_vel_and_stops_without(self):
        moved, stopped = threading.Event(), threading.Event()
        start = rospy.wait_for_message('/odom', Odometry, WAIT_S).pose.pose.position

        def on_odometry(message):
            here = message.pose.pose.position
            if np.hypot(here.x - start.x, here.y - start.y) > 0.1:
                moved.set()
            if moved.is_set() and message.twist.twist.linear.x == 0:
                stopped.set()
        odometry = rospy.Subscriber('/odom', Odometry, on_odometry)
        publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
        command = Twist()
        command.linear.x, command.angular.z = 0.3, 0.1
        for _ in range(100):
            publisher.publish(command)
            if moved.wait(0.1):
                break
        self.assertTrue(moved.is_set(), 'the robot does not move')
        self.assertTrue(stopped.wait(WAIT_S), 'the robot does not stop without commands')
        odometry.unregister()


if __name__ == '__main__':
    rospy.init_node('wall_camera_test')
    rostest.rosrun('unit5', 'wall_camera_test', WallCamera)
