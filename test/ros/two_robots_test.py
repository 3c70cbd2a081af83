#!/usr/bin/env python3
"""Two robots before one master: each with its own wall, topics, TF frames, diagnostics and services."""
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from aruco_ar.files import package_folder
from aruco_ar.wall import load_wall
from aruco_node.messages import frame_from_image
from geometry_msgs.msg import PoseWithCovarianceStamped
from listening import Diagnoses, Inbox, until
from nav_msgs.msg import Odometry
from nodes import change
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

ROBOTS = {'one': 'camera/rgb/image_raw', 'two': 'eye/image'}


class TwoRobots(unittest.TestCase):
    def listen(self, topic, kind):
        inbox = Inbox(topic, kind)
        self.addCleanup(inbox.subscriber.unregister)
        return inbox

    def test_each_paints_what_its_own_camera_sees(self):
        for robot, camera in ROBOTS.items():
            frames = self.listen('/%s/%s' % (robot, camera), Image)
            answers = self.listen('/%s/exercise5_6/image' % robot, Image)
            shown = {}

            def painted():
                answer = answers.next()
                while answer.header.stamp not in shown:
                    frame = frames.next()
                    shown[frame.header.stamp] = frame_from_image(frame)
                    if frame.header.stamp > answer.header.stamp:
                        break
                self.assertEqual(answer.header.frame_id, robot + '/camera_rgb_optical_frame')
                frame = shown.get(answer.header.stamp)
                # What JPEG makes of a frame is not much.
                return frame is not None and \
                    (np.abs(frame_from_image(answer) - frame.astype(float)) > 60).any(axis=2).mean() > 0.02
            until(painted)

    def test_frames_are_told_apart_and_tags_are_where_they_hang(self):
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
                    """The wall's x to the right is odometry's -y, its y up is z."""
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

    def test_each_knows_where_it_is_before_its_wall(self):
        for robot in ROBOTS:
            poses = self.listen('/%s/tag_poses/robot_pose' % robot, PoseWithCovarianceStamped)
            truth, odometry = {}, self.listen('/%s/odom' % robot, Odometry)

            def is_right():
                said = poses.next()
                self.assertEqual(said.header.frame_id, robot + '/wall')
                while not odometry.empty() or said.header.stamp not in truth:
                    message = odometry.next()
                    truth[message.header.stamp] = message.pose.pose.position
                    if message.header.stamp > said.header.stamp:
                        break
                if said.header.stamp not in truth:
                    return False
                there, here = truth[said.header.stamp], said.pose.pose.position
                return np.allclose([-here.z, -here.x, here.y], [there.x, there.y, 0], atol=0.05)
            until(is_right)

    def test_diagnostics_parameters_and_services_are_apart(self):
        diagnoses = Diagnoses()
        self.addCleanup(diagnoses.subscriber.unregister)
        answers = {robot: self.listen('/%s/exercise5_6/image' % robot, Image) for robot in ROBOTS}
        for robot in ROBOTS:
            diagnoses.wait(robot + '/exercise5_6', 'frames a second')
            diagnoses.wait(robot + '/wall_camera', 'frames a second')
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
