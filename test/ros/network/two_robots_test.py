#!/usr/bin/env python3
"""Two robots with one master: each has its own wall, topics, TF frames, diagnostics and services."""
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from aruco_ar.base.files import package_folder
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.images import frame_from_image
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rig.nodes.case import change
from rig.nodes.topics import Diagnostics, Inbox, moments, until
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

ROBOTS = {'one': 'camera/rgb/image_raw', 'two': 'eye/image'}
COUNT = 10  # frames at a time


class TwoRobots(unittest.TestCase):
    def test_each_robot_paints_into_its_own_camera_frames(self):
        for robot, camera in ROBOTS.items():
            frames, answers = '/%s/%s' % (robot, camera), '/%s/exercise5_6/image' % robot

            def is_painted(moment):
                self.assertEqual(moment[answers].header.frame_id, robot + '/camera_rgb_optical_frame')
                frame, answer = (frame_from_image(moment[topic]).astype(float) for topic in (frames, answers))
                # JPEG changes a frame by less.
                return (np.abs(answer - frame) > 60).any(axis=2).mean() > 0.02
            until(lambda: any(map(is_painted, moments({frames: Image, answers: Image}, COUNT))))

    def test_tf_frames_are_separate_and_tags_are_where_they_hang(self):
        frames = set()

        def take(message):
            for each in message.transforms:
                frames.update([each.header.frame_id, each.child_frame_id])
        for topic in '/tf', '/tf_static':
            self.addCleanup(rospy.Subscriber(topic, TFMessage, take, queue_size=100).unregister)
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        self.addCleanup(listener.unregister)
        wall = load_wall(package_folder() + '/config/wall.yaml')
        for robot in ROBOTS:
            for tag in wall.tags:
                x, y = tag.corners.mean(axis=0)[:2]

                def is_near():
                    """The wall's x, to the right, is odometry's -y; its y, up, is z."""
                    try:
                        place = buffer.lookup_transform(robot + '/odom', '%s/tag_%d' % (robot, tag.id),
                                                        rospy.Time(0)).transform.translation
                    except tf2_ros.TransformException:
                        return False
                    return np.allclose([place.x, place.y, place.z], [0, -x, y], atol=0.03)
                until(is_near)
        self.assertEqual({frame for frame in frames if frame.partition('/')[0] not in ROBOTS}, set())
        for robot in ROBOTS:
            self.assertEqual({frame.partition('/')[2] for frame in frames if frame.startswith(robot + '/')},
                             {'odom', 'base_link', 'wall', 'camera_rgb_optical_frame'}
                             | {'tag_%d' % tag.id for tag in wall.tags})
        with self.assertRaises(tf2_ros.TransformException):
            buffer.lookup_transform('one/odom', 'two/odom', rospy.Time(0))

    def test_each_robot_knows_its_place_before_its_wall(self):
        for robot in ROBOTS:
            poses, odometry = '/%s/tag_poses/robot_pose' % robot, '/%s/odom' % robot

            def is_right(moment):
                self.assertEqual(moment[poses].header.frame_id, robot + '/wall')
                there, here = moment[odometry].pose.pose.position, moment[poses].pose.pose.position
                return np.allclose([-here.z, -here.x, here.y], [there.x, there.y, 0], atol=0.05)
            topics = {poses: PoseWithCovarianceStamped, odometry: Odometry}
            until(lambda: any(map(is_right, moments(topics, COUNT))))

    def test_diagnostics_parameters_and_services_are_separate(self):
        diagnostics = Diagnostics()
        self.addCleanup(diagnostics.subscriber.unregister)
        answers = {robot: Inbox('/%s/exercise5_6/image' % robot, Image) for robot in ROBOTS}
        for inbox in answers.values():
            self.addCleanup(inbox.subscriber.unregister)
        for robot in ROBOTS:
            diagnostics.wait_for_frames(robot + '/exercise5_6')
            diagnostics.wait_for_frames(robot + '/wall_camera')
        change('/one/exercise5_6', scale=0.5)
        self.addCleanup(change, '/one/exercise5_6', scale=1.0)
        for robot, width in ('one', 320), ('two', 640):
            until(lambda: answers[robot].next().width == width)
        self.assertEqual(rospy.get_param('/two/exercise5_6/scale'), 1.0)
        for robot in ROBOTS:
            self.assertTrue(rospy.ServiceProxy('/%s/tag_poses/reset' % robot, Trigger)().success)


if __name__ == '__main__':
    rospy.init_node('two_robots_test')
    rostest.rosrun('unit5', 'two_robots_test', TwoRobots)
