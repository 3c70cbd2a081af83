#!/usr/bin/env python3
"""Programs that are ended at random moments leave nothing behind; nodes do not mind who reads what they say."""
import random
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import rospy
import rostest
from hostile import kills
from rig.nodes import NODES, NodeTest, scene
from rig.started import Started
from sensor_msgs.msg import Image
from unit5.msg import TagArray

COUNT, AT_A_TIME, SEED = 12, 3, 1


class Signals(NodeTest):
    def test_nothing_is_left(self):
        ways = kills.kills(random.Random(SEED), (*NODES, *kills.TOOLS))
        with kills.camera(), ThreadPoolExecutor(AT_A_TIME) as pool:
            for _, found in pool.map(kills.strike, islice(ways, COUNT)):
                self.assertEqual(found, [])

    def test_a_node_goes_on_when_nobody_reads_what_it_says_and_when_that_cannot_be_written(self):
        self.publisher, self.connections = self.camera()
        for streams in '2>&1 | head -n 1', '> /dev/full 2>&1', '>&- 2>&- <&-':
            command = Started('bash', '-c', 'rosrun unit5 exercise5_6.py ' + streams)
            self.running.append(command)
            self.attend({'image': self.listen('/exercise5_6/image'),
                         'tags': self.listen('/exercise5_6/tags', TagArray)})
            for _ in range(3):
                self.publisher.publish(Image())  # of which it wants to say something
                self.assert_painted(self.see(scene()), scene())
            command.stop()
            self.assertFalse(any('Traceback' in line for line in command.lines), command.lines)


if __name__ == '__main__':
    rospy.init_node('signals_test')
    rostest.rosrun('unit5', 'signals_test', Signals)
