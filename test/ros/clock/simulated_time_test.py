#!/usr/bin/env python3
"""Nodes with a simulated clock that runs, stands still, or jumps back as in a bag that is played in a loop."""
import threading

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from rig.nodes.case import NODES, NodeTest, scene
from rig.nodes.topics import Diagnostics, until
from rig.processes.started import stop_all
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image
from tf2_msgs.msg import TFMessage
from unit5.msg import TagPoseArray

TICK_S = 0.05


class SimulatedClock:
    """A clock that stands still at a time, or runs from there."""

    def __init__(self):
        self._publisher = rospy.Publisher('/clock', Clock, queue_size=1, latch=True)
        self._stopped = None

    def set(self, seconds):
        self.stop()
        self._publisher.publish(Clock(rospy.Time(seconds)))

    def run(self, seconds):
        self.set(seconds)
        self._stopped = stopped = threading.Event()

        def tick():
            now = seconds
            while not stopped.wait(TICK_S):
                now += TICK_S
                self._publisher.publish(Clock(rospy.Time(now)))
        threading.Thread(target=tick, daemon=True).start()

    def stop(self):
        if self._stopped:
            self._stopped.set()
            self._stopped = None

    def unregister(self):
        self.stop()
        self._publisher.unregister()


class SimulatedTime(NodeTest):
    def setUp(self):
        super().setUp()
        self.clock, self.diagnostics = SimulatedClock(), Diagnostics()
        self.running += [self.clock, self.diagnostics.subscriber]

    def test_a_clock_that_stands_still_stops_no_diagnostics_and_nodes_can_end(self):
        nodes = self.start_all().values()  # before the clock has a time
        for seconds in None, 1000:
            if seconds:
                self.clock.set(seconds)
            for _ in range(2):
                for node in NODES:
                    self.diagnostics.wait(node)
        stop_all(nodes)
        self.assertEqual([node.ends() for node in nodes], [0] * len(NODES))

    def test_frames_are_answered_before_the_clock_has_a_time(self):
        self.start_with_camera('exercise5_6')
        for stamp in rospy.Time(0), rospy.Time(1000), rospy.Time(1000.1), rospy.Time(0):
            self.assert_painted(self.answer_to(scene(), stamp=stamp), scene())
        values = self.diagnostics.wait_for_frames('exercise5_6')
        self.assertEqual(values['latency, median (ms)'], 'unknown')

    def test_frames_are_answered_with_their_simulated_stamps(self):
        self.clock.set(1000)
        until(lambda: rospy.Time.now() == rospy.Time(1000))
        self.start_with_camera('exercise5_6')
        for seconds in 999.9, 999.95:
            self.assert_painted(self.answer_to(scene(), stamp=rospy.Time(seconds)), scene())
        values = self.diagnostics.wait_for_frames('exercise5_6')
        self.assertAlmostEqual(float(values['latency, 99 % (ms)']), 100, delta=1)

    def test_poses_and_transforms_have_the_stamps_of_their_frames(self):
        self.clock.set(1000)
        self.publish_camera_info()
        self.start_with_camera('tag_poses', poses=TagPoseArray)
        transforms = self.listen('/tf', TFMessage)
        until(transforms.subscriber.get_num_connections)
        for seconds in 1000.5, 1000.6, 500.0:  # back in time, as when the bag starts again
            stamp = rospy.Time(seconds)
            poses, = self.answer_to(scene(), 'poses', stamp=stamp)
            self.assertEqual(sorted(tag.id for tag in poses.tags), [1, 2, 3, 4])
            message = transforms.next()
            while message.transforms[0].header.stamp != stamp:
                message = transforms.next()
            self.assertEqual({(each.header.stamp, each.header.frame_id) for each in message.transforms},
                             {(stamp, 'eye')})
            self.assertEqual({each.child_frame_id for each in message.transforms},
                             {'tag_%d' % number for number in (1, 2, 3, 4)})

    def test_a_jump_back_in_time_stops_neither_nodes_nor_diagnostics(self):
        self.start_with_camera('exercise5_6')
        for _ in range(2):  # rounds of the bag
            for seconds, ids, is_painted in ((2000, [1, 3], False), (2000.1, [1, 2, 3, 4], True),
                                             (2000.2, [1, 3], True), (2000.2, [2, 4], True)):
                self.clock.set(seconds)
                frame = scene(ids)
                image = self.answer_to(frame, stamp=rospy.Time(seconds))
                if is_painted:
                    self.assert_painted(image, frame)
                else:
                    np.testing.assert_array_equal(image, frame)
            self.diagnostics.wait_for_frames('exercise5_6')

    def test_the_simulated_camera_continues_if_the_clock_jumps_or_waits(self):
        self.clock.run(1000)
        self.start('wall_camera.py', '_rate:=10')
        frames = self.listen('/camera/rgb/image_raw', Image)

        def is_after(seconds):
            return 0 <= (frames.next().header.stamp - rospy.Time(seconds)).to_sec() < 100
        for seconds in 1000, 3000, 500:
            self.clock.run(seconds)
            until(lambda: is_after(seconds))
        self.clock.stop()
        self.diagnostics.wait('wall_camera', 'Slow: 0.0 frames a second', level=DiagnosticStatus.WARN)
        self.clock.run(501)
        until(lambda: is_after(500))


if __name__ == '__main__':
    rospy.init_node('simulated_time_test')
    rostest.rosrun('unit5', 'simulated_time_test', SimulatedTime)
