#!/usr/bin/env python3
"""A node that cannot keep up drops frames; it neither falls behind nor publishes stale results."""
import os
import signal
import time

import cv2
import rospy
import rostest
from rig.nodes.case import BLANK, CAMERA, NodeTest, scene
from rig.nodes.topics import until
from unit5.msg import TagPoseArray

ALONE = 'it counts how many frames a node leaves out'  # read by script/test
FRAMES = 10  # the length of the camera's queue


class Overload(NodeTest):
    def test_an_exercise_answers_the_newest_frame_after_a_pause(self):
        self.assert_frames_are_dropped('exercise5_6')

    def test_the_poses_after_a_pause_are_those_of_the_newest_frame(self):
        self.assert_frames_are_dropped('tag_poses')

    def test_an_exercise_does_not_publish_a_stale_frame_if_a_newer_one_waits(self):
        self.assert_stale_frames_are_dropped('exercise5_6')

    def test_there_are_no_poses_of_a_stale_frame_if_a_newer_one_waits(self):
        self.publish_camera_info()
        self.assert_stale_frames_are_dropped('tag_poses', poses=TagPoseArray)

    def assert_stale_frames_are_dropped(self, name, **others):
        self.start_with_camera(name, **others)
        camera = self.listen(CAMERA)
        # On a busy machine the newer frame may reach the node's socket too late, which the test cannot see.
        self.assertTrue(any(self.drops_a_stale_frame(camera) for _ in range(5)))

    def drops_a_stale_frame(self, camera):
        """Whether the node publishes nothing of a stale frame. ``camera``: what arrives from it elsewhere."""
        now = time.time()
        for second in range(20):  # these frames are in time, since their stamps are in the future
            self.answer_to(scene(), *self._inboxes, stamp=rospy.Time(now + 100 + second))
        os.killpg(self.node.process.pid, signal.SIGSTOP)
        old = self.show(scene(), rospy.Time(now - 100))
        # This is more than the buffers hold, so the node has read the old frame before all of it arrives.
        self.show(cv2.resize(scene(), (4000, 3000)), rospy.Time(now + 200))
        new = self.show(scene(), rospy.Time(now + 201))
        while camera.next().header.stamp != new:
            pass
        os.killpg(self.node.process.pid, signal.SIGCONT)
        is_dropped = True
        for inbox in self._inboxes.values():
            stamp = None
            while stamp != new:
                stamp = inbox.next().header.stamp
                is_dropped &= stamp != old
        return is_dropped

    def assert_frames_are_dropped(self, name):
        self.start_with_camera(name)
        answers = self._inboxes['tags']
        self.answer_to(scene())
        os.killpg(self.node.process.pid, signal.SIGSTOP)
        connection, = self.publisher.impl.connections  # with a thread of its own, which sends the frames
        sent = connection.stat_num_msg
        stamps = [self.show(BLANK[:24, :32]) for _ in range(FRAMES)]  # all fit into the socket's buffer
        until(lambda: connection.stat_num_msg >= sent + FRAMES)
        os.killpg(self.node.process.pid, signal.SIGCONT)
        answered = [answers.next().header.stamp]
        while answered[-1] != stamps[-1]:
            answered.append(answers.next().header.stamp)
        self.assertLess(len(set(answered) & set(stamps)), FRAMES / 2)


if __name__ == '__main__':
    rospy.init_node('overload_test')
    rostest.rosrun('unit5', 'overload', Overload)
