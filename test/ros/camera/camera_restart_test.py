#!/usr/bin/env python3
"""The camera is killed and started again: the node answers its frames, and finds the area."""
import os
import signal

import rospy
import rostest
from aruco_node.messages.images import frame_from_image
from rig.nodes.case import CAMERA, NodeTest
from rig.processes.started import WAIT_S

WAITING, ARRIVES = 'Waiting for frames on ' + CAMERA, 'Frames arrive on ' + CAMERA
SILENT = 'has a publisher, but nothing arrives. Is the camera running?'
HINT = 'No tag has been in sight'


class CameraRestart(NodeTest):
    def kill(self):
        """Kill the camera in a way that the ROS master does not notice."""
        os.kill(self.eye.process.pid, signal.SIGKILL)
        self.eye.ends()

    def start_camera(self, *arguments):
        """Start the camera, and wait for an area in its frames."""
        self.eye = self.start('wall_camera.py', '_rate:=10', *arguments)
        self.wait_for_area()

    def wait_for_area(self):
        """Wait for an area in a frame that is taken from now on."""
        began = rospy.Time.now()
        mask = self.masks.next()
        while mask.header.stamp < began or not frame_from_image(mask).any():
            self.assertLess((rospy.Time.now() - began).to_sec(), WAIT_S)
            mask = self.masks.next()

    def of_frames(self, lines):
        """The lines that say whether frames come. All others are hints at why no area is found.

        On a slow computer, that may take so long. A line of any other kind is a failure.
        """
        said = [line for line in lines if WAITING in line or ARRIVES in line]
        self.assertEqual([line for line in lines if line not in said and HINT not in line], [])
        return said

    def test_frames_and_area_come_back_and_the_log_says_so_once(self):
        node = self.start('exercise5_5.py')
        self.masks = self.listen('/exercise5_5/mask')
        self.start_camera()
        line_count = len(node.lines)
        self.kill()
        self.start_camera()  # before anybody has noticed, unless the computer is slow
        if len(node.lines) > line_count:
            node.wait_for(ARRIVES, after=line_count)
        self.assertIn(len(self.of_frames(node.lines[line_count:])), (0, 2), node.lines)
        line_count = len(node.lines)
        self.kill()
        node.wait_for(SILENT, after=line_count)
        self.start_camera('__name:=another_camera')  # the dead camera is still registered beside it
        node.wait_for(ARRIVES, after=line_count)
        self.masks.subscriber.unregister()
        self.masks = self.listen('/exercise5_5/mask')
        self.wait_for_area()
        self.assertEqual(len(self.of_frames(node.lines[line_count:])), 2, node.lines)


if __name__ == '__main__':
    rospy.init_node('camera_restart_test')
    rostest.rosrun('unit5', 'camera_restart_test', CameraRestart)
