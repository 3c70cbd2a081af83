#!/usr/bin/env python3
"""What /diagnostics reports about the nodes."""
import itertools

import numpy as np
import rospy
import rostest
from aruco_ar.painting.jpeg_file import jpeg_from_frame
from aruco_node.messages.images import frame_from_compressed, frame_from_image
from diagnostic_msgs.msg import DiagnosticStatus
from rig.nodes.case import BLANK, CAMERA, IMAGES, OUTSIDE, NodeTest, scene
from rig.nodes.topics import Diagnostics, until
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

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
        self.assertEqual(set(self.diagnostics.wait_for_frames('wall_camera')),
                         {'frames a second', 'frames left out'})
        page = self.diagnostics.wait('page', 'The page is served')
        self.assertEqual(page, {'connections': '0', 'pages open': '0', 'driving': 'on'})

    def test_frames_tags_and_dropped_frames_are_counted(self):
        self.start_with_camera('exercise5_6')
        before = self.diagnostics.wait_for_frames('exercise5_6')
        for _ in range(5):
            self.answer_to(scene())
        values = self.diagnostics.wait_for_frames('exercise5_6')
        for name, more in ('frames in', 5), ('frames out', 5), ('frames dropped', 0):
            self.assertEqual(int(values[name]), int(before[name]) + more)
        self.assertEqual(values['tags in sight'], '4')
        self.assertEqual(values['area'], 'Its tags show it.')
        for name in 'frame rate (Hz)', 'pipeline, median (ms)', 'pipeline, 99 % (ms)', 'area last seen (s ago)':
            self.assertGreaterEqual(float(values[name]), 0, name)
        self.assertEqual(values['latency, median (ms)'], 'unknown')  # the stamps of the frames are too old
        self.answer_to(scene(), stamp=rospy.Time.now())
        values = self.diagnostics.wait_for_frames('exercise5_6')
        self.assertGreater(float(values['latency, 99 % (ms)']), 0)
        self.publisher.impl.seq += 40  # as if 40 frames had been lost on their way
        self.answer_to(BLANK)
        values = self.diagnostics.wait('exercise5_6', '40 of', level=WARN)
        self.assertEqual(values['area'], 'Four tags have not been seen together.')  # this stamp is earlier
        for name, more in ('frames in', 7), ('frames out', 7), ('frames dropped', 40):
            self.assertEqual(int(values[name]), int(before[name]) + more)
        self.assertEqual(values['tags in sight'], '0')

    def test_a_missing_camera_unusable_frames_and_missing_subscribers_are_reported(self):
        node = self.start('exercise5_2.py')
        inbox = self.listen('/exercise5_2/image')
        self.diagnostics.wait('exercise5_2', 'nothing publishes it', 'Start a camera', level=ERROR)
        self.publisher, connections = self.camera()
        connections.wait(1)
        self.use_inboxes({'image': inbox})
        bad = []  # instead of good frames
        frames = rospy.Timer(rospy.Duration(0.3), lambda event: (
            self.publisher.publish(bad[-1]) if bad else self.show(scene())))
        self.addCleanup(frames.shutdown)
        self.diagnostics.wait('exercise5_2', 'frames a second')
        bad.append(Image(height=1, width=1, step=4, encoding='32FC1', data=b'1234'))
        values = self.diagnostics.wait('exercise5_2', '32FC1', 'Set the camera driver', level=ERROR)
        self.assertGreater(int(values['frames in']), int(values['frames out']))
        bad.clear()
        self.diagnostics.wait('exercise5_2', 'frames a second')
        bad.append(Image())
        self.diagnostics.wait('exercise5_2', '0 x 0', level=ERROR)
        self.assertEqual(len([line for line in node.lines if '32FC1' in line]), 1)
        frames.shutdown()
        inbox.subscriber.unregister()
        connections.wait(0)
        self.diagnostics.wait('exercise5_2', 'Nobody listens, so nothing is computed.')
        self.diagnostics.wait('exercise5_2', 'Nobody listens to /exercise5_2/image')

    def test_frames_that_are_read_otherwise_than_they_say_are_told(self):
        self.start_with_camera('exercise5_3')

        def show(encoding):
            header = Header(stamp=rospy.Time(next(self._seconds)))
            self.publisher.publish(Image(header=header, height=480, width=640, step=1920, encoding=encoding,
                                         data=scene().tobytes()))
        for _ in range(3):
            show('8UC3')
        values = until(lambda: show('8UC3') or self.encoding())
        self.assertIn('"8UC3" are read as bgr8', values)
        self.assertEqual(len([line for line in self.node.lines if '"8UC3" are read as bgr8' in line]), 1)
        until(lambda: show('bgr8') or not self.encoding())

    def encoding(self):
        return self.diagnostics.wait_for_frames('exercise5_3').get('encoding')

    def test_compressed_frames_that_are_cut_off_are_counted_and_told_once(self):
        self.publisher, connections = self.camera(CAMERA + '/compressed', CompressedImage)
        node = self.start('exercise5_2.py', '_image_transport:=compressed')
        inbox = self.listen('/exercise5_2/image')
        connections.wait(1)
        data = jpeg_from_frame(scene())
        sent = itertools.cycle([data[:len(data) // 2], data[:-2], data[:-2], data[:-2]])
        frames = rospy.Timer(rospy.Duration(0.1), lambda event: self.publisher.publish(
            CompressedImage(header=Header(stamp=rospy.Time.now()), data=next(sent))))
        self.addCleanup(frames.shutdown)
        values = self.diagnostics.wait('exercise5_2', 'frames within 5 s could not be used',
                                       'complete JPEG or PNG', level=WARN)
        self.assertGreater(int(values['frames not usable']), 0)
        np.testing.assert_array_equal(frame_from_image(inbox.next())[OUTSIDE],
                                      frame_from_compressed(CompressedImage(data=data))[OUTSIDE])
        node.wait_for('lack their end marker')
        frames.shutdown()
        for words in 'complete JPEG or PNG', 'lack their end marker':
            self.assertEqual(len([line for line in node.lines if words in line]), 1)

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
        self.start_with_camera('exercise5_3')
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
