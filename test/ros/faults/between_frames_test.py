#!/usr/bin/env python3
"""What frames are processed with is changed a thousand times while frames flow: a node has no fault from it."""
import itertools
import queue
import threading

import numpy as np
import rospy
import rostest
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.wall_messages import camera_info
from rig.nodes.case import NodeTest, change, scene
from rig.processes.started import WAIT_S
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from std_srvs.srv import Trigger

RESETS = 1000
SHIFTS = (0, 0), (6, 9), (12, 4), (5, -7), (0, 3), (40, 30)
FRAMES = [np.roll(scene(), shift, axis=(0, 1)) for shift in SHIFTS]
CALIBRATIONS = [camera_info(Camera(distortion=[k1, 0.0, 0.0, 0.0, 0.0]), Header()) for k1 in (-0.2, 0.0)]
# For each node: its arguments, and the changes that are made in turn.
NODES = {'exercise5_6': (['_foreground:=keep', '_light:=match', '_tags:=hide'],
                         [{'light': 'full'}, {'light': 'match', 'hold': 0.5}, {'search': 'fast'},
                          {'search': 'normal', 'upright': 'image'}, {'scale': 0.5}, {'scale': 1.0}]),
         'tag_poses': ([], [{'hold': 0.5}, {'tag_size': 0.1}, {'search': 'fast'}, {'scale': 0.5},
                            {'scale': 1.0, 'tag_size': 0.18}])}


class BetweenFrames(NodeTest):
    def check(self, name):
        arguments, changes = NODES[name]
        self.start_with_camera(name, *arguments)
        infos, _ = self.camera('/camera/rgb/camera_info', CameraInfo)
        done = threading.Event()

        def flow():
            for frame in itertools.cycle(FRAMES):
                if done.is_set():
                    return
                self.show(frame)
                try:  # the next one when this one has been answered
                    self._inboxes['image'].get(timeout=1.0)
                except queue.Empty:
                    pass
        flowing = threading.Thread(target=flow)
        flowing.start()
        self.addCleanup(done.set)
        reset = rospy.ServiceProxy('/%s/reset' % name, Trigger, persistent=True)
        for number in range(RESETS):
            self.assertTrue(reset().success)
            infos.publish(CALIBRATIONS[number % 2])
            if number % 20 == 0:
                change('/' + name, **changes[number // 20 % len(changes)])
        done.set()
        flowing.join(WAIT_S)
        self.assertIsNone(self.node.process.poll())
        self.assertEqual([line for line in self.node.lines if 'fault' in line or 'Error' in line], [])

    def test_a_picture_is_painted(self):
        self.check('exercise5_6')

    def test_poses_are_estimated(self):
        self.check('tag_poses')


if __name__ == '__main__':
    rospy.init_node('between_frames_test')
    rostest.rosrun('unit5', 'between_frames_test', BetweenFrames)
