#!/usr/bin/env python3
"""A bag that is played in a loop, with its own clock and without: each round is processed like the first."""
import os
import tempfile
import threading

import numpy as np
import rospy
import rostest
from aruco_ar.base.files import package_folder
from aruco_node.messages.images import frame_from_image
from PIL import Image as PillowImage
from rig.nodes.case import NodeTest
from rig.nodes.topics import Diagnostics
from rig.processes.started import WAIT_S, Started
from sensor_msgs.msg import Image
from unit5.msg import TagPoseArray

COLORS = {'blue': (255, 0, 0), 'red': (0, 0, 255)}  # the colors of the clip, BGR
MIN_PX = 2000
ALL = {'blue', 'red', 'poses'}


class Rounds:
    """What each round of the bag gives: which colors are painted, and whether there are poses."""

    def __init__(self):
        self._found, self._changed = {}, threading.Condition()
        self._starts = {}
        self._subscribers = [
            rospy.Subscriber('/exercise5_6/image', Image, self._take, self._colors, queue_size=10,
                             buff_size=1 << 25),
            rospy.Subscriber('/tag_poses/poses', TagPoseArray, self._take, self._poses, queue_size=10)]

    def _take(self, message, look):
        with self._changed:
            number, last = self._starts.get(look, (0, message.header.stamp))
            number += (last - message.header.stamp).to_sec() > 4  # half of the bag's length
            self._starts[look] = number, message.header.stamp
            self._found.setdefault(number, set()).update(look(message))
            self._changed.notify_all()

    def _colors(self, message):
        image = frame_from_image(message)
        return [name for name, color in COLORS.items() if np.all(image == color, axis=2).sum() > MIN_PX]

    def _poses(self, message):
        return ['poses'] * any(tag.pose.pose.position.z > 0 for tag in message.tags)

    def wait(self, number):
        """Wait until that round has given everything."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._found.get(number) == ALL, 2 * WAIT_S):
                raise AssertionError('round %d is incomplete: %s' % (number, self._found))

    def unregister(self):
        for subscriber in self._subscribers:
            subscriber.unregister()


class BagLoops(NodeTest):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.clip = folder.name + '/clip.gif'
        first, *others = [PillowImage.new('RGB', (32, 32), color[::-1]) for color in COLORS.values()]
        first.save(self.clip, save_all=True, append_images=others, duration=500, loop=0)

    def play(self, simulated):
        rospy.set_param('/use_sim_time', simulated)
        self.addCleanup(rospy.delete_param, '/use_sim_time')
        diagnostics, rounds = Diagnostics(), Rounds()
        self.running += [diagnostics.subscriber, rounds]
        nodes = [self.start('exercise5_6.py', '_image_transport:=compressed', '_picture:=' + self.clip),
                 self.start('tag_poses.py', '_image_transport:=compressed')]
        bag = os.path.join(package_folder(), 'test/bags/drive_compressed.bag')
        self.running.append(Started('rosbag', 'play', '--quiet', '--loop', '--rate', '3', bag,
                                    *['--clock'] * simulated))
        for number in 1, 2:  # after the first jump back in time, and after the second
            rounds.wait(number)
            for node in 'exercise5_6', 'tag_poses':
                diagnostics.wait_for_frames(node)
        for node in nodes:
            self.assertFalse([line for line in node.lines if 'ERROR' in line or 'Traceback' in line])

    def test_with_the_clock_of_the_bag(self):
        self.play(True)

    def test_with_the_clock_of_the_machine(self):
        self.play(False)


if __name__ == '__main__':
    rospy.init_node('bag_loops_test')
    rostest.rosrun('unit5', 'bag_loops_test', BagLoops)
