#!/usr/bin/env python3
"""Killed nodes are started again, paint as before, and keep the parameters that were changed while they ran."""
import os
import signal
import tempfile
from xmlrpc.client import ServerProxy

import numpy as np
import rospy
import rostest
from rig.nodes.case import GRAY, INSIDE, NodeTest, change, picture_file, scene
from rig.processes.started import Started
from rosgraph import Master
from sensor_msgs.msg import Image
from unit5.msg import TagArray, TagPoseArray

BLUE = (255, 0, 0)


class Respawn(NodeTest):
    def launch(self, name, **others):
        """Launch a node with respawn in front of a camera; subscribe to its images, ~tags and ``others``."""
        self.publisher, self.connections = self.camera()
        self.launched = Started('roslaunch', 'unit5', name + '.launch', 'respawn:=true')
        self.running.append(self.launched)
        self.inboxes = {topic: self.listen('/%s/%s' % (name, topic), kind)
                        for topic, kind in dict(others, image=Image, tags=TagArray).items()}
        self.use_inboxes(self.inboxes)

    def kill(self, name):
        """Kill a node, and wait until it has been started again and answers frames."""
        uri = Master('/respawn_test').lookupNode('/' + name)
        code, _, pid = ServerProxy(uri).getPid('/respawn_test')
        self.assertEqual(code, 1)
        os.kill(pid, signal.SIGKILL)
        self.launched.wait_for('[%s-' % name, 'process has died')
        self.connections.wait(0)
        self.connections.wait(1)
        self.use_inboxes(self.inboxes)
        _, _, other = ServerProxy(Master('/respawn_test').lookupNode('/' + name)).getPid('/respawn_test')
        self.assertNotEqual(other, pid)

    def test_exercise5_6_paints_as_before(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.launch('exercise5_6')
        changed = change('/exercise5_6', picture=picture_file(folder.name, 'blue.png', np.full((8, 8, 3), BLUE,
                         np.uint8)), opacity=0.5, dictionary='DICT_5X5_100', ids='4,3,2,1', hold=1.5)
        frame = scene(dictionary='DICT_5X5_100')
        before = self.answer_to(frame)
        np.testing.assert_allclose(before[INSIDE].mean(axis=(0, 1)), np.array(BLUE) / 2 + GRAY / 2, atol=3)
        self.kill('exercise5_6')
        two = scene([1, 3], 'DICT_5X5_100')
        np.testing.assert_array_equal(self.answer_to(two), two)
        # Another kind of search found the tags, so they differ by thousandths of a pixel.
        np.testing.assert_allclose(self.answer_to(frame), before, rtol=0, atol=1.01)
        self.assertEqual(change('/exercise5_6'), changed)

    def test_the_poses_are_as_before(self):
        self.publish_camera_info()
        self.launch('tag_poses', poses=TagPoseArray)
        changed = change('/tag_poses', tag_size=0.3, tag_sizes='2: 0.1')
        before, = self.answer_to(scene(), 'poses')
        self.assertEqual(sorted((tag.id, tag.size) for tag in before.tags),
                         [(1, .3), (2, .1), (3, .3), (4, .3)])
        self.kill('tag_poses')
        after, = self.answer_to(scene(), 'poses')

        def places(message):
            return {tag.id: (tag.pose.pose.position.x, tag.pose.pose.position.y, tag.pose.pose.position.z)
                    for tag in message.tags}
        self.assertEqual(set(places(after)), {1, 2, 3, 4})
        for tag_id, place in places(after).items():
            np.testing.assert_allclose(place, places(before)[tag_id], rtol=0.02, atol=0.01)
        self.assertEqual(change('/tag_poses'), changed)


if __name__ == '__main__':
    rospy.init_node('respawn_test')
    rostest.rosrun('unit5', 'respawn_test', Respawn)
