#!/usr/bin/env python3
"""Wrong parameters are refused with one sentence each, and the nodes continue as before."""
import os
import tempfile

import numpy as np
import rospy
import rostest
import yaml
from aruco_ar import InputError
from aruco_ar.settings.declaration import parameters_of
from aruco_node.parameters.reconfigure import Reconfigurer
from aruco_node.parameters.settings import TagSettings
from dynamic_reconfigure.srv import Reconfigure
from geometry_msgs.msg import PoseWithCovarianceStamped
from hostile.parameters import validation, values
from hostile.parameters.configs import GROUPS, NAMES, REFUSED, config_with, set_parameter, values_of
from rig.nodes.case import CAMERA, CENTERS, IMAGES, INSIDE, NodeTest, change, scene
from rig.nodes.topics import until
from std_srvs.srv import Trigger

EACH = 3  # wrong values per parameter


def wrong_values(kind, name, parameter, random):
    """Some values that the parameter must not have."""
    given = values.typed(values.values(parameter, random))
    found = []
    while len(found) < EACH:
        value = given[random.randint(len(given))]
        try:
            validation.read_with(kind, name, value)
        except InputError:
            found.append(value)
    return found


class HostileParameters(NodeTest):
    def refusals(self, node, count):
        """Wait until a node has refused that many changes; returns its sentences."""
        def said():
            return [line.partition(']: ')[2].partition(REFUSED)[0] for line in node.lines if REFUSED in line]
        until(lambda: len(said()) >= count)
        return said()

    def test_every_node_refuses_wrong_values_and_continues_as_before(self):
        nodes = self.start_all()  # wall_camera is the camera of the others
        random = np.random.RandomState(1)
        for name, node in nodes.items():
            kind = validation.settings_of(name)
            reconfigure = rospy.ServiceProxy('/%s/set_parameters' % name, Reconfigure, persistent=True)
            before, sent = change('/' + name), []
            for parameter, each in parameters_of(kind).items():
                for value in wrong_values(kind, parameter, each, random) if each.live else ['raw']:
                    sent.append('~' + parameter)
                    config = config_with(parameter, value)
                    self.assertEqual(values_of(reconfigure(config).config), before, sent[-1])
            for config in GROUPS + NAMES if name == 'page' else []:
                sent += ['cannot be changed while the node runs'] * (config in NAMES)
                self.assertEqual(values_of(reconfigure(config).config), before)
            reconfigure.close()
            sentences = self.refusals(node, len(sent))
            self.assertEqual(len(sentences), len(sent))
            for sentence, parameter in zip(sentences, sent):
                self.assertIn(parameter, sentence)
                self.assertIsNone(validation.fault_of(sentence), sentence)
            self.assertFalse(any('Traceback' in line for line in node.lines), node.lines)
        for topic in [CAMERA, *IMAGES.values()]:
            self.listen(topic).next()

    def test_the_limits_of_the_parameters_are_accepted(self):
        self.start_with_camera('exercise5_6')
        narrow = {'scale': 1.0, 'min_side': 10000.0, 'hold': 60.0, 'confidence': 1.0, 'correction': 0.0}
        for sent, size in (({'scale': 0.01}, (5, 6)), ({'scale': 4.0}, (1920, 2560)), (narrow, (480, 640))):
            taken = change('/exercise5_6', **sent)
            self.assertEqual(taken, dict(taken, **sent))
            self.assertEqual(self.answer_to(scene()).shape[:2], size)
        change('/exercise5_6', min_side=0.0, confidence=0.5, opacity=0.0)
        np.testing.assert_array_equal(self.answer_to(scene())[INSIDE], scene()[INSIDE])
        change('/exercise5_6', opacity=1.0)
        self.assert_painted(self.answer_to(scene()), scene())

    def test_a_fault_during_a_change_only_refuses_the_change(self):
        calls = []

        def fail(settings):
            calls.append(settings)
            raise ZeroDivisionError('nobody thought of that')
        Reconfigurer(TagSettings(), fail)
        before = change(rospy.get_name())
        self.assertEqual(change(rospy.get_name(), scale=0.5), before)
        self.assertEqual(change(rospy.get_name(), scale=1.0), before)
        self.assertEqual([settings.scale for settings in calls], [0.5])

    def test_a_reset_does_not_need_the_file_of_the_wall(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        wall = folder.name + '/wall.yaml'
        with open(wall, 'w') as file:  # the wall of scene(), whose tags are 80 pixels wide
            yaml.dump({'tags': [{'id': tag_id, 'x': 0.18 * x / 80, 'y': -0.18 * y / 80, 'side': 0.18}
                                for tag_id, (x, y) in CENTERS.items()]}, file)
        self.publish_camera_info()
        self.start_with_camera('tag_poses', '_wall:=' + wall, camera_pose=PoseWithCovarianceStamped)
        os.unlink(wall)
        for _ in range(2):
            pose, = self.answer_to(scene(), 'camera_pose')
            self.assertEqual(pose.header.frame_id, 'wall')
            self.assertTrue(rospy.ServiceProxy('/tag_poses/reset', Trigger)().success)
        self.assertEqual(change('/tag_poses', tag_size=0.25)['tag_size'], 0.25)
        kept = change('/tag_poses', scale=0.5)
        self.assertEqual(change('/tag_poses', wall=wall + '.not'), kept)
        self.assertEqual(self.answer_to(scene(), 'camera_pose')[0].header.frame_id, 'wall')
        self.assertFalse(any('Traceback' in line for line in self.node.lines), self.node.lines)

    def test_a_name_or_value_that_ros_refuses_ends_a_node_with_a_sentence(self):
        self.assertTrue(set_parameter('/exercise5_2/scale', 10**30))
        nodes = [(words, self.start('exercise5_2.py', *arguments)) for words, *arguments in (
            ('Set it again: rosparam set /exercise5_2/scale VALUE',),
            ('not a valid ROS name', CAMERA[1:] + ':=//bad name'),
            ('not a valid ROS name', '__name:=bad name'), ('cannot start', '_scale:=[1, 2', '__name:=one'),
            ('cannot start', '_scale:=99999999999', '__name:=two'))]
        for words, node in nodes:
            self.assertEqual(node.ends(), 1, words)
            self.assertEqual(len(node.lines), 1, node.lines)
            self.assertIn(words, node.lines[0])

    def test_a_wrong_use_sim_time_is_reported(self):
        self.addCleanup(rospy.delete_param, '/use_sim_time')
        rospy.set_param('/use_sim_time', 'no')
        node = self.start('exercise5_2.py')
        node.wait_for('/use_sim_time is "no"', 'takes it for true', 'must be true or false')


if __name__ == '__main__':
    rospy.init_node('hostile_parameters_test')
    rostest.rosrun('unit5', 'hostile_parameters_test', HostileParameters)
