#!/usr/bin/env python3
"""What /diagnostics reports about the nodes."""
import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from rig.nodes.case import BLANK, CAMERA, IMAGES, NodeTest, scene
from rig.nodes.topics import Diagnostics
from sensor_msgs.msg import Image

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
OF_TAGS = {'tags in sight', 'area last seen (s ago)'}
WITH_AREA, OF_AREA = ('exercise5_5', 'exercise5_6', 'tag_poses'), {'area'}
FIGURES = OF_TAGS | {'frames in', 'frames out', 'frames dropped', 'frame rate (Hz)', 'pipeline, median (ms)',
                     'pipeline, 99 % (ms)', 'latency, median (ms)', 'latency, 99 % (ms)'}


class NodeDiagnostics(NodeTest):
    def setUp(self):
        super().setUp()
        self.diagnostics = Diagnostics()
        self.running.append(self.diagnostics.subscriber)

    def test_every_node_is_ok_while_nobody_subscribes(self):
        self.start_all()
        for node in IMAGES:
            self.assertEqual(set(self.diagnostics.wait(node, 'Nobody listens')),
                             FIGURES - OF_TAGS if node == 'camera_relay' else
                             FIGURES - OF_TAGS | {'calibration'} if node == 'calibrate_live' else
                             FIGURES | OF_AREA if node in WITH_AREA else FIGURES)
        self.assertEqual(set(self.diagnostics.wait('wall_camera', 'frames a second')),
                         {'frames a second', 'frames left out'})
        page = self.diagnostics.wait('page', 'The page is served')
        self.assertEqual(page, {'connections': '0', 'pages open': '0', 'driving': 'on'})

    def test_frames_tags_and_dropped_frames_are_counted(self):
        self.start_before_camera('exercise5_6')
        before = self.diagnostics.wait('exercise5_6', 'frames a second')
        for _ in range(5):
            self.answer_to(scene())
        values = self.diagnostics.wait('exercise5_6', 'frames a second')
        for name in 'frames in', 'frames out':
            self.assertEqual(int(values[name]), int(before[name]) + 5)
        self.assertEqual((values['frames dropped'], values['tags in sight']), ('0', '4'))
        self.assertEqual(values['area'], 'Its tags show it.')
        for name in 'frame rate (Hz)', 'pipeline, median (ms)', 'pipeline, 99 % (ms)', 'area last seen (s ago)':
            self.assertGreaterEqual(float(values[name]), 0, name)
        self.assertEqual(values['latency, median (ms)'], 'unknown')  # the stamps of the frames are too old
        self.answer_to(scene(), stamp=rospy.Time.now())
        values = self.diagnostics.wait('exercise5_6', 'frames a second')
        self.assertGreater(float(values['latency, 99 % (ms)']), 0)
        self.publisher.impl.seq += 40  # as if 40 frames had been lost on their way
        self.answer_to(BLANK)
        values = self.diagnostics.wait('exercise5_6', '40 of', level=WARN)
        self.assertEqual(values['area'], 'Four tags have not been seen together.')  # this stamp is earlier
        self.assertEqual((int(values['frames in']), int(values['frames out']), values['frames dropped'],
                          values['tags in sight']), (int(before['frames in']) + 7,
                                                     int(before['frames out']) + 7, '40', '0'))

    def test_a_missing_camera_unusable_frames_and_missing_subscribers_are_reported(self):
        node = self.start('exercise5_2.py')
        inbox = self.listen('/exercise5_2/image')
        self.diagnostics.wait('exercise5_2', 'nothing publishes it', 'Start a camera', level=ERROR)
        self.publisher, connections = self.camera()
        connections.wait(1)
        self.use_inboxes({'image': inbox})
        self.diagnostics.wait('exercise5_2', 'frames a second')
        self.publisher.publish(Image(height=1, width=1, step=4, encoding='32FC1', data=b'1234'))
        node.wait_for('32FC1')
        values = self.diagnostics.wait('exercise5_2', '32FC1', 'Set the camera driver', level=ERROR)
        self.assertEqual(int(values['frames in']), int(values['frames out']) + 1)
        self.answer_to(scene())
        self.diagnostics.wait('exercise5_2', 'frames a second')
        self.publisher.publish(Image())
        self.diagnostics.wait('exercise5_2', '0 x 0', level=ERROR)
        inbox.subscriber.unregister()
        connections.wait(0)
        self.diagnostics.wait('exercise5_2', 'Nobody listens, so nothing is computed.')
        self.diagnostics.wait('exercise5_2', 'Nobody listens to /exercise5_2/image')

    def test_a_hint_is_reported_only_while_frames_arrive(self):
        node = self.start('exercise5_3.py')
        inbox = self.listen('/exercise5_3/image')
        self.publisher, connections = self.camera()
        others = scene(dictionary='DICT_4X4_50')
        frames = rospy.Timer(rospy.Duration(0.1), lambda event: self.show(others))
        self.addCleanup(frames.shutdown)
        remedy = 'Give dictionary:=DICT_4X4_50.'
        self.assertIn('hint', self.diagnostics.wait('exercise5_3', remedy, level=WARN))
        node.wait_for(remedy)
        inbox.subscriber.unregister()
        connections.wait(0)
        self.assertNotIn('hint', self.diagnostics.wait('exercise5_3', 'Nobody listens'))
        inbox = self.listen('/exercise5_3/image')
        self.diagnostics.wait('exercise5_3', 'frames a second')  # the hint must be earned anew
        self.diagnostics.wait('exercise5_3', remedy, level=WARN)
        frames.shutdown()
        self.assertNotIn('hint', self.diagnostics.wait(
            'exercise5_3', 'nothing arrives. Is the camera running?', level=ERROR))

    def test_a_long_time_without_tags_and_then_without_frames_is_reported(self):
        self.start_before_camera('exercise5_3')
        self.answer_to(scene())
        shown = [BLANK]
        frames = rospy.Timer(rospy.Duration(0.5), lambda event: self.show(shown[0]))
        self.addCleanup(frames.shutdown)
        values = self.diagnostics.wait('exercise5_3', 'No tag has been in sight for 1', level=WARN)
        self.node.wait_for('No tag has been in sight for 10 s.')
        self.assertEqual((values['tags in sight'], values['area last seen (s ago)']), ('0', 'none seen'))
        shown[0] = np.zeros_like(BLANK)
        self.diagnostics.wait('exercise5_3', 'The image is almost black', 'raise the exposure', level=WARN)
        self.answer_to(scene())
        self.diagnostics.wait('exercise5_3', 'frames a second')
        frames.shutdown()
        self.publisher.publish(Image())
        self.diagnostics.wait('exercise5_3', '0 x 0', level=ERROR)
        self.diagnostics.wait('exercise5_3', CAMERA, 'nothing arrives. Is the camera running?', level=ERROR)


if __name__ == '__main__':
    rospy.init_node('diagnostics_test')
    rostest.rosrun('unit5', 'diagnostics_test', NodeDiagnostics)
