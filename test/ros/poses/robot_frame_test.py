#!/usr/bin/env python3
"""The robot's pose: by which TF frame, and at which time, the camera is mounted on the robot."""
import numpy as np
import rospy
import rostest
import tf2_ros
from aruco_ar.base.files import package_folder
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.pose_messages import from_transform
from aruco_node.messages.wall_messages import camera_info
from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion, Transform, TransformStamped, Vector3
from rig.nodes.case import NodeTest
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

WALL = package_folder() + '/config/wall.yaml'
VIEW = wall_to_camera(Pose(-1.8, 0.0, 0.1))
FRAME = WallRenderer(load_wall(WALL), Camera(), noise=1.0).render(*VIEW)
CAMERA = VIEW[0].T, -VIEW[0].T @ VIEW[1]  # its pose relative to the wall


def mounting(robot_frame, stamp, x, turn=0.0):
    """The TransformStamped of a camera x meters right of a robot's frame, turned about its y axis."""
    return TransformStamped(Header(stamp=stamp, frame_id=robot_frame), 'eye', Transform(
        Vector3(x, 0, 0), Quaternion(0, np.sin(turn / 2), 0, np.cos(turn / 2))))


class RobotFrame(NodeTest):
    def start_poses(self):
        self.publisher, connections = self.camera('/eye/image')
        infos, _ = self.camera('/eye/camera_info', CameraInfo)
        self.node = self.start('tag_poses.py', '__ns:=robot1', 'camera/rgb/image_raw:=/eye/image',
                               '_wall:=' + WALL)
        self.poses = self.listen('/robot1/tag_poses/robot_pose', PoseWithCovarianceStamped)
        connections.wait(1)
        timer = rospy.Timer(rospy.Duration(0.1), lambda event: infos.publish(camera_info(Camera(), Header())))
        self.addCleanup(timer.shutdown)

    def show_until_answered(self, stamp=None):
        """Show frames, with one stamp or with rising ones, until a pose of one arrives; returns it, (R, t)."""
        timer = rospy.Timer(rospy.Duration(0.1), lambda event: self.show(FRAME, stamp))
        try:
            message = self.poses.next()
            while stamp not in (None, message.header.stamp):  # of a frame that was shown before
                message = self.poses.next()
        finally:
            timer.shutdown()
        pose = message.pose.pose
        return from_transform(Transform(pose.position, pose.orientation))

    def test_a_frame_without_the_namespace_is_taken_if_only_that_one_exists(self):
        self.start_poses()
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.running.append(broadcaster.pub_tf)
        broadcaster.sendTransform(mounting('base_link', rospy.Time(1), 0.3))
        place = self.show_until_answered()[1]
        np.testing.assert_allclose(place, CAMERA[0] @ [-0.3, 0, 0] + CAMERA[1], atol=0.02)
        self.node.wait_for('TF joins base_link to the camera, and not robot1/base_link')

    def test_the_frames_that_exist_are_named_if_the_robots_does_not(self):
        self.start_poses()
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.running.append(broadcaster.pub_tf)
        broadcaster.sendTransform(mounting('chassis', rospy.Time(1), 0.3))
        timer = rospy.Timer(rospy.Duration(0.1), lambda event: self.show(FRAME))
        self.addCleanup(timer.shutdown)
        self.node.wait_for('TF does not join robot1/base_link to eye', 'the TF frames that there are: ', 'eye')

    def test_a_camera_that_pans_looked_where_it_did_at_the_time_of_the_frame(self):
        self.start_poses()
        broadcaster = tf2_ros.TransformBroadcaster()
        self.running.append(broadcaster.pub_tf)

        def pan(event):
            # In one message: of some of them, the node would take the newest for a later frame.
            broadcaster.sendTransform([  # TF is known from 100 to 102 s
                mounting('robot1/base_link', rospy.Time(100 + 0.1 * number), 0, 0.05 * number)
                for number in range(21)])
        timer = rospy.Timer(rospy.Duration(0.2), pan)
        self.addCleanup(timer.shutdown)
        for stamp, turn in (101.0, 0.5), (101.5, 0.75):
            turned = self.show_until_answered(rospy.Time(stamp))[0]
            expected = CAMERA[0] @ from_transform(mounting('', rospy.Time(), 0, -turn).transform)[0]
            angle = np.arccos(np.clip((np.trace(turned.T @ expected) - 1) / 2, -1, 1))
            self.assertLess(angle, 0.03)


if __name__ == '__main__':
    rospy.init_node('robot_frame_test')
    rostest.rosrun('unit5', 'robot_frame_test', RobotFrame)
