#!/usr/bin/env python3
"""Right nodes pass the check as black boxes: our solutions, and nodes in other styles, also in C++."""
import os
import shutil
import subprocess
import tempfile
import unittest
from unittest import mock

import rospy
import rostest
from aruco_course.exercises import CHECKS
from aruco_course.learner.package import has_node, start
from aruco_node.black_box.node_check import Options, check_node
from rig import PACKAGE
from rig.nodes.learners import learners_node
from rig.processes.skip import skip

RIGHT = os.path.join(PACKAGE, 'test', 'course', 'right')
BAG = os.path.join(PACKAGE, 'test', 'bags', 'drive_compressed.bag')
LIBRARIES = 'roscpp', 'sensor_msgs', 'cv_bridge', 'opencv4'


class RightNodes(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = self._folder.name

    def assert_right(self, node, exercise='5.4', **options):
        verdict = check_node(Options(exercise, node, **options), is_shared=True)
        self.assertTrue(verdict.passed, verdict)
        return verdict

    def test_our_solutions_in_a_learners_package(self):
        package = start(os.path.join(self.folder, 'my_unit5'), CHECKS).package
        with mock.patch.dict(os.environ, ROS_PACKAGE_PATH='%s:%s' % (
                package.folder, os.environ.get('ROS_PACKAGE_PATH', ''))):
            for check in filter(has_node, CHECKS):
                learners_node(package.path('src'), check.name, number=check.number)
                verdict = self.assert_right('my_unit5/%s.py' % check.name, check.number)
                self.assertEqual(verdict.remarks, [])

    def test_a_solution_on_the_frames_of_a_bag(self):
        self.assert_right(learners_node(self.folder, 'solution'), bag=BAG)

    def test_a_class_that_shrinks_the_frames(self):
        self.assert_right(os.path.join(RIGHT, 'class_node.py'), image='/my/polygon')

    def test_message_filters(self):
        self.assert_right(os.path.join(RIGHT, 'filters_node.py'), image='/filtered/image')

    def test_gray_images_and_a_loop_that_works(self):
        self.assert_right(os.path.join(RIGHT, 'mono_node.py'), image='/my_gray/image')

    def test_numpy_without_cv_bridge(self):
        self.assert_right(os.path.join(RIGHT, 'numpy_node.py'), image='/plain/image')

    def test_our_own_nodes_by_package_and_type(self):
        rospy.set_param('/exercise5_6/upright', 'image')  # as the course has it
        for name in 'exercise5_5', 'exercise5_6':
            self.assert_right('unit5/%s.py' % name, name[-3:].replace('_', '.'), image='/%s/image' % name)

    def test_cpp(self):
        if not (shutil.which('g++') and shutil.which('pkg-config')):
            skip(self.id(), 'there is no g++ with pkg-config')
        flags = subprocess.run(['pkg-config', '--cflags', '--libs', *LIBRARIES], capture_output=True, text=True)
        if flags.returncode:
            skip(self.id(), 'headers for C++ are missing: ' + ' '.join(flags.stderr.split()))
        program = os.path.join(self.folder, 'cpp_node')
        source = os.path.join(RIGHT, 'cpp_node.cpp')
        subprocess.run(['g++', source, '-o', program, *flags.stdout.split()], check=True)
        self.assert_right(program, image='/cpp/image')


if __name__ == '__main__':
    rospy.init_node('right_nodes_test')
    rostest.rosrun('unit5', 'right_nodes_test', RightNodes)
