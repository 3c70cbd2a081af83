#!/usr/bin/env python3
"""What is wrong with a node as such is said in a sentence that names it."""
import tempfile
import unittest

import rospy
import rostest
from aruco_node.black_box.node_check import Options, check_node
from rig.nodes.learners import learners_node

PUBLISH = '        publisher.publish(result)\n'
PUBLISHER = "    publisher = rospy.Publisher('~image', Image, queue_size=1)\n"
RESULT = '        result = bridge'


class WrongNodes(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)

    def verdict(self, *changes, number='5.4', executable=True, **options):
        node = learners_node(self._folder.name, 'exercise', *changes, number=number, executable=executable)
        return check_node(Options(number, node, **options), is_shared=True)

    def assert_wrong(self, words, *changes, **options):
        verdict = self.verdict(*changes, **options)
        self.assertFalse(verdict.passed, verdict)
        self.assertIn(words, verdict.fault)
        return verdict

    def test_it_is_not_there(self):
        for node, words in ('unit5/nothing.py', 'There is no program unit5/nothing.py'), \
                ('no_such/node.py', 'ROS does not know the package "no_such"'):
            self.assertIn(words, check_node(Options('5.4', node), is_shared=True).fault)

    def test_it_is_not_executable(self):
        self.assert_wrong('exercise.py is not executable', executable=False)

    def test_its_first_line_names_no_program(self):
        self.assert_wrong('#!/usr/bin/env python3', ('#!/usr/bin/env python3\n', ''))
        self.assert_wrong('line ends of Windows', ('#!/usr/bin/env python3\n', '#!/usr/bin/env python3\r\n'))

    def test_it_dies_at_the_start(self):
        verdict = self.assert_wrong('getPredefinedDictionary', ('getPredefinedDictionary', 'Dictionary_get'))
        self.assertRegex(verdict.place, r'Line \d+')
        self.assert_wrong('missing at the end of this line', ('def main():', 'def main()'))

    def test_it_ends_by_itself(self):
        self.assert_wrong('the node ends by itself', ('    rospy.spin()\n', ''))

    def test_it_subscribes_to_another_camera(self):
        self.assert_wrong('the node subscribes to /usb_cam/image_raw, not to /camera/rgb/image_raw',
                          ('/camera/rgb/image_raw', '/usb_cam/image_raw'))

    def test_it_publishes_on_another_topic(self):
        self.assert_wrong('but on /polygon', ("'~image'", "'/polygon'"))

    def test_it_publishes_nothing(self):
        self.assert_wrong('nothing comes on /my_exercise5_4/image', (PUBLISH, ''))

    def test_its_publisher_is_made_in_the_callback(self):
        self.assert_wrong('is made in the callback', (PUBLISHER, ''), (PUBLISH, '    ' + PUBLISHER + PUBLISH))

    def test_its_encoding_does_not_fit(self):
        verdict = self.assert_wrong('encoding', ("(image), 'bgr8'", "(image), 'mono8'"))
        self.assertRegex(verdict.place, r'Line \d+')

    def test_its_colors_are_exchanged(self):
        self.assert_wrong('blue and red are exchanged', ("(message, 'bgr8')", "(message, 'rgb8')"))

    def test_it_opens_a_window(self):
        self.assert_wrong('screen', (PUBLISH, "        cv2.imshow('image', image)\n" + PUBLISH))

    def test_it_is_slower_than_the_camera(self):
        self.assert_wrong('slower than the camera', (RESULT, '        rospy.sleep(2)\n' + RESULT))

    def test_it_draws_what_is_wrong(self):
        verdict = self.assert_wrong('crosses itself', ('[ordered.astype', '[centers.astype'))
        self.assertRegex(verdict.place, r'Frame \d+')

    def test_a_missing_stamp_is_only_a_remark(self):
        verdict = self.verdict(('result.header = message.header', 'pass'))
        self.assertTrue(verdict.passed, verdict)
        self.assertIn('result.header = message.header', verdict.remarks[0])


if __name__ == '__main__':
    rospy.init_node('wrong_nodes_test')
    rostest.rosrun('unit5', 'wrong_nodes_test', WrongNodes)
