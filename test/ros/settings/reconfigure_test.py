#!/usr/bin/env python3
"""dynamic_reconfigure: what it offers, and that a change is refused or applies to the very next frame."""
import asyncio
import json
import subprocess
import tempfile

import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_image
from dynamic_reconfigure.msg import ConfigDescription
from geometry_msgs.msg import Twist
from rig.nodes.case import BLANK, GRAY, INSIDE, NODES, NodeTest, change, picture_file, scene
from rig.nodes.topics import until
from rig.page.server import free_port
from rig.processes.started import WAIT_S
from tornado.websocket import websocket_connect
from unit5.msg import AreaPose, TagPoseArray

RANGES = {'scale': (0.01, 4), 'correction': (0, 1), 'confidence': (0, 1), 'min_side': (0, 10000),
          'hold': (0, 60), 'border': (1, 10), 'opacity': (0, 1),
          'settle': (0.5, 3600), 'tag_size': (0.001, 10), 'noise': (0, 100), 'blur': (0, 20),
          'falloff': (0, 1), 'exposure': (0, 20), 'swing': (0, 4), 'hand': (0, 10), 'shutter': (0, 100),
          'jpeg': (0, 100), 'linear': (0, 2), 'angular': (0, 8), 'rate': (0, 1000), 'quality': (1, 100)}
CHOICES = {'search': ['fast', 'normal', 'thorough'], 'upright': ['tags', 'image'],
           'fit': ['stretch', 'contain', 'cover'], 'foreground': ['paint', 'keep'], 'light': ['full', 'match'],
           'grain': ['clean', 'match'], 'tags': ['show', 'hide'],
           'visitor': ['nobody', 'person', 'hand'], 'lens': ['correct', 'ignore'],
           'dictionary': ['DICT_4X4_50', 'DICT_6X6_250']}
SIGHT = {'dictionary', 'ids', 'scale', 'search', 'correction', 'confidence', 'min_side', 'border', 'folder'}
AREA = SIGHT | {'lens', 'hold', 'upright', 'wall'}
OFFERED = {'exercise5_4': SIGHT | {'lens'}, 'exercise5_5': AREA,
           'exercise5_6': AREA | {'picture', 'fit', 'opacity', 'foreground', 'light', 'grain', 'tags',
                                  'settle'},
           'tag_poses': AREA | {'tag_size', 'tag_sizes'},
           'wall_camera': {'noise', 'blur', 'falloff', 'exposure', 'swing', 'hand', 'shutter', 'visitor',
                           'jpeg'},
           'page': {'linear', 'angular'}, 'camera_relay': {'folder', 'rate', 'quality'},
           'calibrate_live': {'folder', 'camera_name', 'file'}}
RED, BLUE = (0, 0, 255), (255, 0, 0)
LEFT, RIGHT, TOP, BOTTOM = ((slice(None), slice(0, 40)), (slice(None), slice(-40, None)),
                            (slice(0, 40), slice(None)), (slice(-40, None), slice(None)))


class DynamicReconfigure(NodeTest):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        half = np.full((20, 40, 3), RED, np.uint8)
        self.flag = picture_file(folder.name, 'flag.png', np.vstack([half, np.full_like(half, BLUE)]))
        self.red = picture_file(folder.name, 'red.png', half)

    def paint(self, *arguments):
        self.start_with_camera('exercise5_6', '_picture:=' + self.red, *arguments)

    def assert_color(self, image, place, color):
        np.testing.assert_allclose(image[place].reshape(-1, 3).mean(axis=0), color, atol=8)

    def test_every_parameter_is_described_with_its_range_or_choices(self):
        self.start_all()
        for node in NODES:
            description = rospy.wait_for_message('/%s/parameter_descriptions' % node, ConfigDescription, WAIT_S)
            parameters = {each.name: each for group in description.groups for each in group.parameters}
            self.assertEqual(set(parameters), OFFERED.get(node, SIGHT), node)
            low, high, default = ({each.name: each.value for each in part.doubles + part.strs}
                                  for part in (description.min, description.max, description.dflt))
            for name, each in parameters.items():
                self.assertGreater(len(each.description), 5, (node, name))
                self.assertEqual(each.type, 'double' if name in RANGES else 'str')
                self.assertEqual((low[name], high[name]), RANGES.get(name, ('', '')), (node, name))
                if name in RANGES:
                    self.assertTrue(low[name] <= default[name] <= high[name])
                names = [choice['name'] for choice in eval(each.edit_method)['enum']] \
                    if each.edit_method else []
                self.assertTrue(set(CHOICES.get(name, [])) <= set(names), (node, name))
                self.assertEqual(default[name] in names, name in CHOICES, (node, name))

    def test_dictionary_and_ids_can_be_changed(self):
        self.paint()
        others = scene(dictionary='DICT_5X5_100')
        self.assertEqual(self.ids_seen(others), [])
        change('/exercise5_6', dictionary='DICT_5X5_100')
        image, tags = self.answer_to(others, 'image', 'tags')
        self.assert_painted(image, others)
        self.assertEqual(sorted(tag.id for tag in tags.tags), [1, 2, 3, 4])
        change('/exercise5_6', ids='1,2,3,9')
        image, tags = self.answer_to(others, 'image', 'tags')
        np.testing.assert_array_equal(image, others)
        self.assertEqual(sorted(tag.id for tag in tags.tags), [1, 2, 3])
        change('/exercise5_6', ids='any')
        self.assert_painted(self.answer_to(others), others)

    def test_scale_can_be_changed(self):
        self.paint()
        corners = {}
        for scale in (1.0, 0.5, 1.5):
            change('/exercise5_6', scale=scale)
            image, tags = self.answer_to(scene(), 'image', 'tags')
            self.assertEqual(image.shape, (480 * scale, 640 * scale, 3))
            place = tuple(slice(int(part.start * scale), int(part.stop * scale)) for part in INSIDE)
            self.assert_color(image, place, RED)
            corners[scale] = np.array([[(p.x, p.y) for p in tag.corners]
                                       for tag in sorted(tags.tags, key=lambda tag: tag.id)])
            np.testing.assert_allclose((corners[scale] + 0.5) / scale, corners[1.0] + 0.5, atol=0.5)

    def test_hold_applies_at_once_and_nothing_is_forgotten(self):
        self.paint('_hold:=5.0')
        self.assert_painted(self.answer_to(scene()), scene())
        change('/exercise5_6', hold=2.0)
        self.assert_painted(self.answer_to(BLANK), BLANK)
        self.assert_painted(self.answer_to(scene([1, 3])), scene([1, 3]))  # two are enough now
        change('/exercise5_6', hold=0.0)
        np.testing.assert_array_equal(self.answer_to(BLANK), BLANK)
        self.assert_painted(self.answer_to(scene([2, 4])), scene([2, 4]))

    def test_opacity_fit_and_picture_apply_at_once_and_nothing_is_forgotten(self):
        self.paint()
        self.assert_painted(self.answer_to(scene()), scene())
        frame = scene([1, 3])
        for opacity in (0.5, 0.0, 0.25, 1.0):
            change('/exercise5_6', opacity=opacity)
            self.assert_color(self.answer_to(frame), INSIDE, opacity * np.array(RED) + (1 - opacity) * GRAY)
        change('/exercise5_6', fit='contain')  # the picture is twice as wide as high, the area is 320 x 240
        image = self.answer_to(frame)
        self.assert_color(image, (slice(170, 310), slice(180, 460)), RED)
        self.assert_color(image, (slice(125, 150), slice(220, 420)), (GRAY,) * 3)
        change('/exercise5_6', fit='stretch', picture=self.flag)
        image = self.answer_to(frame)
        self.assert_color(image, (slice(130, 230), slice(220, 420)), RED)
        self.assert_color(image, (slice(250, 350), slice(220, 420)), BLUE)

    def test_upright_can_be_changed_while_the_camera_is_on_its_side(self):
        self.paint()
        change('/exercise5_6', picture=self.flag)
        frame = np.rot90(scene())
        middle = np.s_[200:440, 160:320]
        for upright, red, blue in (('tags', LEFT, RIGHT), ('image', TOP, BOTTOM), ('tags', LEFT, RIGHT)):
            change('/exercise5_6', upright=upright)
            image = self.answer_to(frame)[middle]
            self.assert_color(image, red, RED)
            self.assert_color(image, blue, BLUE)

    def test_tag_size_and_tag_sizes_scale_the_poses(self):
        self.publish_camera_info()
        self.start_with_camera('tag_poses', poses=TagPoseArray)

        def distances():
            """{id: distance of the tag}."""
            poses, = self.answer_to(scene(), 'poses')
            return {pose.id: np.linalg.norm([getattr(pose.pose.pose.position, axis) for axis in 'xyz'])
                    for pose in poses.tags}
        before = distances()
        self.assertEqual(sorted(before), [1, 2, 3, 4])
        for sizes, factors in (({'tag_size': 0.36}, [2, 2, 2, 2]), ({'tag_size': 0.09}, [.5, .5, .5, .5]),
                               ({'tag_size': 0.18, 'tag_sizes': '3: 0.72'}, [1, 1, 4, 1]),
                               ({'tag_sizes': 'none'}, [1, 1, 1, 1])):
            change('/tag_poses', **sizes)
            after = distances()
            ratios = [after[tag_id] / before[tag_id] for tag_id in sorted(before)]
            np.testing.assert_allclose(ratios, factors, rtol=0.01)
        self._inboxes['area'] = areas = self.listen('/tag_poses/area', AreaPose)

        def is_heard():
            self.show(scene())
            return not areas.empty()
        until(is_heard)
        for _ in range(9):  # until the wall is known well enough to locate the area by one tag
            whole, = self.answer_to(scene(), 'area')
        self.assertEqual(len(whole.corners), 4)
        change('/tag_poses', hold=1.0)
        area, = self.answer_to(scene([1]), 'area')
        self.assertEqual(len(area.corners), 4)
        self.assertAlmostEqual(area.width, whole.width, delta=0.05 * whole.width)
        self.assertAlmostEqual(area.pose.pose.position.z, whole.pose.pose.position.z, delta=0.03)

    def test_the_parameters_of_the_search_are_accepted_and_kept(self):
        self.paint()
        values = {'search': 'thorough', 'correction': 0.5, 'confidence': 0.7, 'min_side': 12.0}
        taken = change('/exercise5_6', **values)
        self.assertEqual(taken, dict(taken, **values))
        self.assert_painted(self.answer_to(scene()), scene())
        self.assertEqual(change('/exercise5_6', opacity=1.0), taken)
        for name, value in values.items():
            self.assertEqual(rospy.get_param('/exercise5_6/' + name), value)

    def test_tags_narrower_than_min_side_are_ignored(self):
        self.start_with_camera('exercise5_2')
        frame = scene(narrow=[2])
        for min_side, ids in (0.0, [1, 2, 3, 4]), (50.0, [1, 3, 4]), (90.0, []), (20.0, [1, 2, 3, 4]):
            change('/exercise5_2', min_side=min_side)
            self.assertEqual(self.ids_seen(frame), ids)

    def test_a_wrong_value_is_refused_with_a_sentence(self):
        self.paint()
        kept = change('/exercise5_6', opacity=0.5)
        for values, words in (({'scale': 9.0}, ['~scale is 9', 'from 0.01 to 4']),
                              ({'scale': 'much'}, ['~scale is "much"']),
                              ({'opacity': float('nan')}, ['~opacity is nan', 'from 0 to 1']),
                              ({'opacity': True}, ['~opacity is True']),
                              ({'hold': -1.0}, ['~hold is -1']),
                              ({'ids': '1,2,3'}, ['~ids is "1,2,3"', 'four different tags']),
                              ({'ids': 1.0}, ['~ids is 1.0']),
                              ({'dictionary': 'DICT_9X9_250'},
                               ['~dictionary is "DICT_9X9_250"', 'DICT_6X6_250']),
                              ({'search': 'best'}, ['~search is "best"', 'fast, normal, thorough']),
                              ({'picture': '/no/such.png'}, ['/no/such.png', 'not a file']),
                              ({'picture': 'topic:'}, ['~picture is "topic:"']),
                              ({'folder': ' '}, ['~folder is " "']),
                              ({'upright': 'image', 'min_side': -2.0}, ['~min_side is -2'])):
            self.assertEqual(change('/exercise5_6', **values), kept, values)
            self.node.wait_for(*words, 'Nothing is changed')
        self.assert_color(self.answer_to(scene()), INSIDE, np.array([90, 90, 217]))
        self.assertEqual(len([line for line in self.node.lines if 'Nothing is changed' in line]), 13)
        self.assertFalse(any('Traceback' in line for line in self.node.lines), self.node.lines)

    def test_dynparam_says_why_a_value_is_refused(self):
        self.paint()
        command = ['rosrun', 'dynamic_reconfigure', 'dynparam', 'set', 'exercise5_6', 'opacity', '7']
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertIn('The parameter ~opacity is 7.0; it must be a number from 0 to 1. Nothing is changed.',
                      done.stdout)
        self.assertNotEqual(done.returncode, 0)

    def test_the_other_nodes_refuse_wrong_values_too(self):
        nodes = self.start_all(['tag_poses', 'wall_camera', 'page'])
        for name, values, words in (('tag_poses', {'tag_size': 0.0}, ['~tag_size is 0', 'from 0.001 to 10']),
                                    ('tag_poses', {'tag_sizes': '7'}, ['~tag_sizes is "7"']),
                                    ('tag_poses', {'wall': '/no/wall.yaml'},
                                     ['/no/wall.yaml', 'cannot be read']),
                                    ('wall_camera', {'noise': 101.0}, ['~noise is 101', 'from 0 to 100']),
                                    ('page', {'linear': 'fast'}, ['~linear is "fast"', 'from 0 to 2'])):
            kept = change('/' + name)
            self.assertEqual(change('/' + name, **values), kept)
            nodes[name].wait_for(*words, 'Nothing is changed')
        for node in nodes.values():
            self.assertFalse(any('Traceback' in line for line in node.lines), node.lines)

    def test_noise_light_and_blur_of_the_simulated_camera_can_be_changed(self):
        self.start('wall_camera.py', '_noise:=0', '_falloff:=0')
        camera = self.listen('/camera/rgb/image_raw')

        def next_frame():
            """The first frame that is taken from now on."""
            now, message = rospy.Time.now(), camera.next()
            while message.header.stamp < now:
                message = camera.next()
            return frame_from_image(message).astype(float)
        clean = next_frame()
        np.testing.assert_array_equal(next_frame(), clean)
        change('/wall_camera', noise=10.0)
        self.assertAlmostEqual(np.std(next_frame() - clean), 10, delta=1)
        change('/wall_camera', noise=0.0, falloff=0.8)
        part = next_frame()[200:280, [5, -5]].mean(axis=(0, 2)) / clean[200:280, [5, -5]].mean(axis=(0, 2))
        self.assertLess(part[1], part[0] - 0.1)
        change('/wall_camera', falloff=0.0, blur=2.0)
        blurred = next_frame()
        self.assertLess(np.abs(np.diff(blurred)).max(), np.abs(np.diff(clean)).max() + 1)
        self.assertLess(np.abs(np.diff(blurred, axis=1)).max(), 0.5 * np.abs(np.diff(clean, axis=1)).max())

    def test_the_next_driving_command_has_the_new_speed(self):
        port = free_port()
        self.start('page.py', '_port:=%d' % port).wait_for('driving is on')
        commands = self.listen('/cmd_vel', Twist)
        until(commands.subscriber.get_num_connections)

        async def drive():
            line = await websocket_connect('ws://127.0.0.1:%d/live' % port)
            await line.write_message(json.dumps({'drive': [1, 0.5]}))
            return line
        for linear, angular in ((0.3, 0.8), (0.7, 2.0)):
            change('/page', linear=linear, angular=angular)
            asyncio.run(drive())
            command = commands.next()
            while command.linear.x == 0:  # the stop after the earlier command
                command = commands.next()
            self.assertEqual((command.linear.x, command.angular.z), (linear, angular / 2))


if __name__ == '__main__':
    rospy.init_node('reconfigure_test')
    rostest.rosrun('unit5', 'reconfigure_test', DynamicReconfigure)
