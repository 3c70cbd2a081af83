#!/usr/bin/env python3
"""Subscribers that send nothing, or do not read, neither delay others nor cost memory."""
import psutil
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from rig.nodes.case import NodeTest, change, scene
from rig.nodes.stalled import HalfOpen, Stalled
from rig.nodes.topics import Diagnostics
from rosgraph import Master
from sensor_msgs.msg import CompressedImage, Image
from unit5.msg import TagArray

IMAGE = '/exercise5_6/image'
TOPICS = {IMAGE: Image, IMAGE + '/compressed': CompressedImage, '/exercise5_6/tags': TagArray,
          '/diagnostics': DiagnosticArray}
FRAMES = 90         # 83 MB of ~image
KEPT = 40           # at most this many of them fit into the kernel's buffers
GROWTH_BYTES = 20e6


class StalledListener(NodeTest):
    def test_a_stalled_subscriber_does_not_disturb_others(self):
        diagnostics = Diagnostics()
        self.running.append(diagnostics.subscriber)
        self.start_with_camera('exercise5_6')
        dropped = diagnostics.wait_for_frames('exercise5_6')['frames dropped']  # at the start, if it was slow
        uri = Master('/test').lookupNode('/exercise5_6')
        stalled = {topic: Stalled(uri, topic, kind) for topic, kind in TOPICS.items()}
        self.running += stalled.values()
        process, frame = psutil.Process(self.node.process.pid), scene()
        for number in range(FRAMES):
            self.assert_painted(self.answer_to(frame), frame)
            if number == FRAMES // 3:
                size = process.memory_info().rss
        self.assertLess(process.memory_info().rss, size + GROWTH_BYTES)
        self.assertEqual(diagnostics.wait_for_frames('exercise5_6')['frames dropped'], dropped)
        stamp = self.show(frame)
        stamps = {}
        for topic in (topic for topic in TOPICS if topic != '/diagnostics'):
            stamps[topic] = [stalled[topic].read().header.stamp]
            while stamps[topic][-1] != stamp:
                stamps[topic].append(stalled[topic].read().header.stamp)
            self.assertEqual(stamps[topic], sorted(set(stamps[topic])), topic)
        self.assertLess(len(stamps[IMAGE]), KEPT)

    def test_silent_connections_do_not_lock_out_others(self):
        self.publisher, _ = self.camera()
        self.start_all(['exercise5_6'])
        uri = Master('/test').lookupNode('/exercise5_6')
        self.running += [HalfOpen(uri, IMAGE) for _ in range(3)]
        self.use_inboxes({'image': self.listen(IMAGE)})
        self.assert_painted(self.answer_to(scene()), scene())
        self.assertEqual(change('/exercise5_6', opacity=0.5)['opacity'], 0.5)


if __name__ == '__main__':
    rospy.init_node('stalled_listener_test')
    rostest.rosrun('unit5', 'stalled_listener_test', StalledListener)
