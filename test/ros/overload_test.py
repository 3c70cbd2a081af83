#!/usr/bin/env python3
"""A node that cannot keep up leaves frames out; it does not fall behind."""
import os
import signal

import rospy
import rostest
from nodes import BLANK, CAMERA, NodeTest, scene

FRAMES = 10  # as many as the camera's queue holds


class Overload(NodeTest):
    def test_an_exercise_answers_the_newest_frame_after_a_pause(self):
        self.leaves_frames_out('exercise5_6')

    def test_the_poses_are_those_of_the_newest_frame_after_a_pause(self):
        self.leaves_frames_out('tag_poses')

    def leaves_frames_out(self, name):
        self.before_camera(name)
        camera, answers = self.listen(CAMERA), self._inboxes['tags']
        self.see(scene())
        os.killpg(self.node.process.pid, signal.SIGSTOP)
        stamps = [self.show(BLANK[:48, :64]) for _ in range(FRAMES)]
        while camera.next().header.stamp != stamps[-1]:
            pass  # until they are on their way to the node, too
        os.killpg(self.node.process.pid, signal.SIGCONT)
        answered = [answers.next().header.stamp]
        while answered[-1] != stamps[-1]:
            answered.append(answers.next().header.stamp)
        self.assertLess(len(set(answered) & set(stamps)), FRAMES / 2)


if __name__ == '__main__':
    rospy.init_node('overload_test')
    rostest.rosrun('unit5', 'overload', Overload)
