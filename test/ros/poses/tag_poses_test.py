#!/usr/bin/env python3
"""The poses that tag_poses publishes, compared with the truth while the simulated camera drives past."""
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from aruco_ar.base.files import package_folder
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.images import frame_from_image
from aruco_node.messages.pose_messages import from_transform
from geometry_msgs.msg import PoseWithCovarianceStamped, Transform
from nav_msgs.msg import Odometry
from rig.nodes.topics import Inbox, moments
from rig.processes.started import WAIT_S
from sensor_msgs.msg import Image
from unit5.msg import AreaPose, TagPoseArray
from visualization_msgs.msg import MarkerArray

TOPICS = {'/odom': Odometry, '/tag_poses/poses': TagPoseArray,
          '/tag_poses/camera_pose': PoseWithCovarianceStamped,
          '/tag_poses/robot_pose': PoseWithCovarianceStamped}
COUNT = 150
WALL = load_wall(package_folder() + '/config/wall.yaml')
TAGS = {tag.id: tag for tag in WALL.tags}


def from_pose(pose):
    """(rotation, translation) of a geometry_msgs/Pose."""
    return from_transform(Transform(translation=pose.position, rotation=pose.orientation))


def angle_between(one, other):
    """Degrees between two rotations."""
    return np.degrees(np.arccos(np.clip((np.trace(one.T @ other) - 1) / 2, -1, 1)))


class TagPoses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tf = tf2_ros.Buffer(rospy.Duration(3600))
        cls.listener = tf2_ros.TransformListener(cls.tf)
        cls.moments = moments(TOPICS, COUNT)

    def truth(self, moment):
        """(R, t) of the wall in the camera's optical frame at that moment."""
        pose = moment['/odom'].pose.pose
        heading = 2 * np.arctan2(pose.orientation.z, pose.orientation.w)
        return wall_to_camera(Pose(pose.position.x, pose.position.y, heading))

    def test_every_tag_has_its_true_pose(self):
        count = 0
        for moment in self.moments:
            rotation, translation = self.truth(moment)
            message = moment['/tag_poses/poses']
            self.assertEqual(message.header.frame_id, 'camera_rgb_optical_frame')
            for tag in message.tags:
                found = from_pose(tag.pose.pose)
                true = rotation @ np.array([TAGS[tag.id].x, TAGS[tag.id].y, 0]) + translation
                far = np.linalg.norm(true)
                self.assertLess(np.linalg.norm(found[1] - true), 0.002 + 0.01 * far)
                # The tags are upright, so their axes are those of the wall.
                self.assertLess(angle_between(found[0], rotation), 2.0)
                self.assertEqual(tag.size, 0.18)
                corners = np.array([(corner.x, corner.y) for corner in tag.corners])
                expected, _ = project(TAGS[tag.id].corners, rotation, translation, Camera())
                self.assertLess(np.abs(corners - expected).max(), 1.5)
                center, _ = project(TAGS[tag.id].on_wall([0], [0]), rotation, translation, Camera())
                self.assertLess(np.abs([tag.center.x, tag.center.y] - center[0]).max(), 0.5)
                covariance = np.array(tag.pose.covariance).reshape(6, 6)
                self.assertTrue(np.all(np.linalg.eigvalsh((covariance + covariance.T) / 2) > 0))
                self.assertTrue(0 <= tag.ambiguity <= 0.5)
                count += 1
        self.assertGreater(count, COUNT)

    def test_the_camera_and_the_robot_have_their_true_poses(self):
        for moment in self.moments:
            rotation, translation = self.truth(moment)
            message = moment['/tag_poses/camera_pose']
            self.assertEqual(message.header.frame_id, 'wall')
            found = from_pose(message.pose.pose)
            self.assertLess(np.linalg.norm(found[1] + rotation.T @ translation), 0.03)
            self.assertLess(angle_between(found[0], rotation.T), 1.0)
            # The wall's x is odometry's -y, and its z is odometry's -x.
            robot = from_pose(moment['/tag_poses/robot_pose'].pose.pose)[1]
            odometry = moment['/odom'].pose.pose.position
            self.assertLess(np.abs(robot - [-odometry.y, 0, -odometry.x]).max(), 0.03)

    def test_the_area_has_its_true_pose_and_size(self):
        for moment in moments({'/odom': Odometry, '/tag_poses/area': AreaPose}, COUNT // 3):
            rotation, translation = self.truth(moment)
            area = moment['/tag_poses/area']
            self.assertEqual(len(area.corners), 4)
            found = from_pose(area.pose.pose)
            true = rotation @ WALL.area_corners.mean(axis=0) + translation
            self.assertLess(np.linalg.norm(found[1] - true), 0.01 + 0.02 * np.linalg.norm(true))
            self.assertLess(angle_between(found[0], rotation), 2.0)
            self.assertLess(abs(area.width - 0.9) + abs(area.height - 0.6), 0.05)

    def test_tf_agrees_with_the_poses(self):
        count = 0
        for moment in self.moments[:-5]:
            message = moment['/tag_poses/poses']
            for tag in message.tags:
                found = self.tf.lookup_transform('camera_rgb_optical_frame', 'tag_%d' % tag.id,
                                                 message.header.stamp, rospy.Duration(WAIT_S))
                there = found.transform.translation
                position = tag.pose.pose.position
                np.testing.assert_allclose([there.x, there.y, there.z], [position.x, position.y, position.z],
                                           atol=1e-9)
                count += 1
        self.assertGreater(count, COUNT)

    def test_rviz_gets_a_plate_for_every_tag_and_for_the_area(self):
        inbox = Inbox('/tag_poses/markers', MarkerArray)
        ids = set()
        while ids < {'1', '2', '3', '4'} or 'area' not in ids:
            shown = inbox.next().markers
            ids |= {marker.text for marker in shown if marker.ns == 'ids'}
            ids |= {marker.ns for marker in shown if marker.ns == 'area' and len(marker.points) == 5}
            plates = [marker for marker in shown if marker.ns == 'tags']
            self.assertTrue(all(marker.scale.x == 0.18 for marker in plates))
        inbox.subscriber.unregister()

    def test_the_axes_are_drawn_on_the_frame(self):
        topics = {'/tag_poses/image': Image, '/tag_poses/poses': TagPoseArray}
        for moment in moments(topics, 30, keep=lambda each: each['/tag_poses/poses'].tags):
            self.assert_axes(frame_from_image(moment['/tag_poses/image']), moment['/tag_poses/poses'].tags)

    def assert_axes(self, seen, tags):
        for tag in tags:
            rotation, translation = from_pose(tag.pose.pose)
            for axis, color in ((0, (0, 0, 255)), (1, (0, 255, 0))):
                # Something else may cover a part of an axis: the axis toward the camera, or another tag's id.
                along = rotation[:, axis] * np.linspace(0.02, 0.12, 8)[:, None] + translation
                points, _ = project(along, np.eye(3), np.zeros(3), Camera())
                points = [(x, y) for x, y in np.round(points).astype(int) if 3 < x < 636 and 3 < y < 476]
                off = [np.abs(seen[y - 2:y + 3, x - 2:x + 3].astype(int) - color).sum(axis=2).min()
                       for x, y in points]
                self.assertTrue(not off or min(off) < 60, 'tag %d, axis %d: %s' % (tag.id, axis, off))


if __name__ == '__main__':
    rospy.init_node('tag_poses_test')
    rostest.rosrun('unit5', 'tag_poses_test', TagPoses)
