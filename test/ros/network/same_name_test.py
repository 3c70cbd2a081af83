#!/usr/bin/env python3
"""Two cameras that see the same tags: the recipe, and what is said where it was not followed."""
import numpy as np
import rospy
import rostest
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import image_from_frame
from aruco_node.messages.wall_messages import camera_info
from rig.nodes.case import NodeTest, scene
from rig.nodes.topics import until
from rig.processes.started import Started
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

SIDES = {'left': scene(), 'right': np.roll(scene(), 20, axis=1)}


class SameName(NodeTest):
    def start_cameras(self):
        """Two cameras that publish frames and calibrations."""
        made = [(self.camera('/%s_camera/image_raw' % side)[0],
                 self.camera('/%s_camera/camera_info' % side, CameraInfo)[0], side) for side in SIDES]

        def show(event):
            for images, infos, side in made:
                header = Header(stamp=rospy.Time.now(), frame_id=side)
                infos.publish(camera_info(Camera(), header))
                images.publish(image_from_frame(SIDES[side], header))
        timer = rospy.Timer(rospy.Duration(0.1), show)
        self.addCleanup(timer.shutdown)

    def launch(self, *variables, camera):
        self.running.append(Started('env', *variables, 'roslaunch', 'unit5', 'tag_poses.launch',
                                    'camera:=' + camera))
        return self.running[-1]

    def test_with_a_namespace_each_both_cameras_have_frames_of_all_tags(self):
        self.start_cameras()
        frames = {}

        def take(message):
            frames.update((each.child_frame_id, each.header.frame_id) for each in message.transforms)
        self.running.append(rospy.Subscriber('/tf', TFMessage, take, queue_size=100))
        for side in SIDES:
            self.launch('ROS_NAMESPACE=' + side, camera='/%s_camera/image_raw' % side)
        wanted = {'%s/tag_%d' % (side, tag): side for side in SIDES for tag in (1, 2, 3, 4)}
        until(lambda: wanted.items() <= frames.items())

    def test_without_one_the_node_that_ends_says_what_to_do(self):
        first = self.launch(camera='/left_camera/image_raw')
        first.wait_for('Ready: /left_camera/image_raw')
        self.launch(camera='/right_camera/image_raw').wait_for('Ready: /right_camera/image_raw')
        first.wait_for('Another node has taken the name /tag_poses', 'ROS_NAMESPACE=left')


if __name__ == '__main__':
    rospy.init_node('same_name_test')
    rostest.rosrun('unit5', 'same_name_test', SameName)
