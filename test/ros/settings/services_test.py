#!/usr/bin/env python3
"""~snapshot saves a frame and its result, ~reset forgets what was learned, and ~save_wall keeps it."""
import itertools
import os
import re
import tempfile
import threading
import time

import cv2
import numpy as np
import rospy
import rostest
from rig.accuracy.drives import PAINTING, SLOW, drive
from rig.nodes.case import CAMERA, GRAY, NodeTest, change, picture_file, scene
from rig.processes.started import WAIT_S
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger


class Services(NodeTest):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name + '/made/for/it'

    def call(self, name):
        rospy.wait_for_service(name, WAIT_S)
        return rospy.ServiceProxy(name, Trigger)()

    def pictures(self, answer, *names):
        """{name: pixels} of the pictures that a snapshot wrote; its folder must contain no others."""
        self.assertTrue(answer.success, answer.message)
        paths = {path: os.path.join(self.folder, path) for path in os.listdir(self.folder)}
        self.assertEqual(answer.message, 'Wrote ' + ', '.join(sorted(paths.values())))
        found = {path[path.rindex('_') + 1:-len('.png')]: cv2.imread(full) for path, full in paths.items()}
        self.assertEqual(set(found), set(names))
        return found

    def call_while_showing(self, name):
        """Call a service while frames are shown; returns its answer."""
        answers = []
        calling = threading.Thread(target=lambda: answers.append(self.call(name)))
        calling.start()
        number = 0
        while calling.is_alive():
            number += 1
            self.show(np.where(scene() == GRAY, np.uint8(100 + number % 100), scene()))
            calling.join(0.1)
        return answers[0]

    def test_a_snapshot_has_one_frame_and_its_result_even_without_subscribers(self):
        self.publisher, connections = self.camera()
        self.start('exercise5_6.py', '_folder:=' + self.folder)
        found = self.pictures(self.call_while_showing('/exercise5_6/snapshot'), 'frame', 'image')
        gray = found['frame'][0, 0, 0]
        self.assertTrue(100 <= gray < 200)
        np.testing.assert_array_equal(found['frame'], np.where(scene() == GRAY, gray, scene()))
        self.assert_painted(found['image'], found['frame'])
        connections.wait(0)  # it unsubscribes from the camera again

    def test_a_snapshot_has_the_same_result_as_the_subscribers_get(self):
        self.start_with_camera('exercise5_5', '_folder:=file://' + self.folder, topics=['mask', 'image'])
        self.answer_to(scene())  # by then the earlier frames are answered
        images = []

        def answer(message):
            images.append(message)
        for topic in 'mask', 'image':
            self.running.append(rospy.Subscriber('/exercise5_5/' + topic, Image, answer, buff_size=1 << 24))
        found = self.pictures(self.call_while_showing('/exercise5_5/snapshot'), 'frame', 'image', 'mask')
        shown = [np.frombuffer(message.data, np.uint8).reshape(480, 640, 3) for message in images]
        for name in 'image', 'mask':
            self.assertTrue(any(np.array_equal(found[name], each) for each in shown), name)
        self.assertEqual(found['mask'][240, 320].tolist(), [255, 255, 255])
        self.assertEqual(found['mask'][20, 20].tolist(), [0, 0, 0])
        np.testing.assert_array_equal(found['image'], cv2.subtract(found['frame'], found['mask']))

    def test_the_folder_can_be_changed_and_an_unwritable_one_is_reported(self):
        self.start_with_camera('exercise5_2', '_folder:=/dev/null/pictures')
        refused = self.call_while_showing('/exercise5_2/snapshot')
        self.assertFalse(refused.success)
        self.assertRegex(refused.message, 'Cannot write "/dev/null/pictures/.*Choose another place')
        change('/exercise5_2', folder=self.folder)
        found = self.pictures(self.call_while_showing('/exercise5_2/snapshot'), 'frame', 'image')
        self.assertTrue(np.any(found['frame'] != found['image']))
        self.assertFalse(any('Traceback' in line for line in self.node.lines), self.node.lines)

    def test_without_a_camera_or_with_a_broken_one_it_says_why(self):
        self.start('tag_poses.py', '_folder:=' + self.folder)
        answer = self.call('/tag_poses/snapshot')
        self.assertFalse(answer.success)
        self.assertIn('No frame arrived within 5 s. Waiting for frames on %s: nothing publishes it' % CAMERA,
                      answer.message)
        self.publisher, connections = self.camera()
        answers = []
        calling = threading.Thread(target=lambda: answers.append(self.call('/tag_poses/snapshot')))
        calling.start()
        connections.wait(1)
        end = time.monotonic() + WAIT_S
        while calling.is_alive() and time.monotonic() < end:
            self.publisher.publish(Image())
            calling.join(0.2)
        self.assertFalse(answers[0].success)
        self.assertIn('A frame of 0 x 0 pixels', answers[0].message)
        self.assertFalse(os.path.exists(self.folder))

    def test_after_a_reset_the_area_is_gone_until_four_tags_are_seen_together(self):
        for name in 'exercise5_5', 'exercise5_6':
            self.start_with_camera(name)
            two = scene([1, 3])
            self.assert_painted(self.answer_to(scene()), scene())
            self.assert_painted(self.answer_to(two), two)
            self.assertTrue(self.call('/%s/reset' % name).success)
            for frame in (two, scene([1, 2, 3]), two):
                np.testing.assert_array_equal(self.answer_to(frame), frame)
            self.assert_painted(self.answer_to(scene()), scene())
            self.assert_painted(self.answer_to(two), two)

    def test_a_saved_wall_is_known_without_its_tags(self):
        os.makedirs(self.folder)
        red = picture_file(self.folder, 'red.png', np.full((30, 40, 3), (0, 0, 255), np.uint8))
        self.start_with_camera('exercise5_6', '_folder:=' + self.folder, '_picture:=' + red)
        refused = self.call('/exercise5_6/save_wall')
        self.assertFalse(refused.success)
        self.assertIn('Show all four tags', refused.message)
        for frame in drive(SLOW, 75, wall=PAINTING, noise=1.0):
            self.answer_to(frame.image)
        answer = self.call('/exercise5_6/save_wall')
        self.assertTrue(answer.success, answer.message)
        path, again = re.fullmatch('Wrote (.*). With wall:=(.*), the area is found by any of its tags, and '
                                   'also without them.', answer.message).groups()
        self.assertTrue(path == again and os.path.dirname(path) == self.folder, answer.message)
        self.assertEqual(change('/exercise5_6', wall=path + '.gone')['wall'], 'learn')
        self.node.wait_for('wall.npz.gone" cannot be read')
        self.assertTrue(self.call('/exercise5_6/reset').success)
        without = list(drive(SLOW, 30, lambda number: PAINTING.area, wall=PAINTING, noise=1.0))
        for frame in without:
            np.testing.assert_array_equal(self.answer_to(frame.image), frame.image)
        self.assertEqual(change('/exercise5_6', wall=path)['wall'], path)
        for frame in itertools.islice(itertools.cycle([*without, *without[::-1]]), 1000):
            image = self.answer_to(frame.image)  # the search takes some frames
            if np.any(image != frame.image):
                break
        area = cv2.fillConvexPoly(np.zeros((480, 640), np.uint8), np.int32(np.round(frame.corners)), (1,))
        inside, near = cv2.erode(area, np.ones((9, 9))) > 0, cv2.dilate(area, np.ones((9, 9))) > 0
        np.testing.assert_array_equal(image[inside], np.broadcast_to((0, 0, 255), image[inside].shape))
        np.testing.assert_array_equal(image[~near], frame.image[~near])


if __name__ == '__main__':
    rospy.init_node('services_test')
    rostest.rosrun('unit5', 'services_test', Services)
