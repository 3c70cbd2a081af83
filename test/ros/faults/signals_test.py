#!/usr/bin/env python3
"""Programs that are killed at random moments leave nothing behind; nodes run even if their output is lost."""
import random
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import rospy
import rostest
from hostile import kills
from rig.nodes.case import NODES, NodeTest, scene
from rig.processes.started import Started
from sensor_msgs.msg import Image
from unit5.msg import TagArray

COUNT, AT_A_TIME, SEED = 12, 3, 1


class Signals(NodeTest):
    def test_killed_programs_leave_nothing_behind(self):
        ways = kills.kills(random.Random(SEED), (*NODES, *kills.TOOLS))
        with kills.camera(), ThreadPoolExecutor(AT_A_TIME) as pool:
            for _, found in pool.map(kills.strike, islice(ways, COUNT)):
                self.assertEqual(found, [])

    def test_a_node_continues_if_its_output_cannot_be_written(self):
        self.publisher, self.connections = self.camera()
        for streams in '2>&1 | head -n 1', '> /dev/full 2>&1', '>&- 2>&- <&-':
            command = Started('bash', '-c', 'rosrun unit5 exercise5_6.py ' + streams)
            self.running.append(command)
            self.use_inboxes({'image': self.listen('/exercise5_6/image'),
                         'tags': self.listen('/exercise5_6/tags', TagArray)})
            for _ in range(3):
                self.publisher.publish(Image())  # the node logs a line about this
                self.assert_painted(self.answer_to(scene()), scene())
            command.stop()
            self.assertFalse(any('Traceback' in line for line in command.lines), command.lines)


if __name__ == '__main__':
    rospy.init_node('signals_test')
    rostest.rosrun('unit5', 'signals_test', Signals)
