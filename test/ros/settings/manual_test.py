#!/usr/bin/env python3
"""--help of every node lists what the running node subscribes to, publishes and offers, without a roscore."""
import asyncio
import json
import os
import re
import subprocess
from functools import lru_cache

import rospy
import rostest
from dynamic_reconfigure.msg import ConfigDescription
from rig.nodes.case import NODES, NodeTest, change
from rig.nodes.topics import until
from rig.page.server import free_port
from rig.processes.started import WAIT_S
from rosgraph import Master
from roslib.message import get_message_class
from rosservice import get_service_type
from tornado.websocket import websocket_connect

WIDTH = 120
NOBODY = dict(os.environ, ROS_MASTER_URI='http://localhost:1')
OF_ROS = re.compile(r'/rosout|.*/(get_loggers|set_logger_level|tf2_frames)')  # what every node has
# The topics in use here, of those that may have any name.
ANY_TOPIC = {'exercise5_6': '/other/camera', 'page': '/exercise5_3/image(/compressed)?'}


@lru_cache(None)
def run_manual(node, option='--help'):
    return subprocess.run(['rosrun', 'unit5', node + '.py', option], env=NOBODY, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=WAIT_S)


def listed(node, title):
    """{name: type} of what a node's manual lists under a title."""
    part = re.search(r'^%s.*:\n((?:  .*\n)+)' % title, run_manual(node).stdout + '\n', re.MULTILINE)
    rows = re.findall(r'^  (\S+) +(\S+)', part.group(1), re.MULTILINE) if part else []
    return {name.replace('~', '/%s/' % node) if name[0] in '~/' else '/' + name: kind for name, kind in rows}


class Manuals(NodeTest):
    def setUp(self):
        super().setUp()
        self.master = Master('/manual_test')

    def registered(self, node, number):
        """The names for which a node is registered as publisher (0), subscriber (1) or server (2)."""
        return {name for name, nodes in self.master.getSystemState()[number]
                if '/' + node in nodes and not OF_ROS.fullmatch(name)}

    def test_it_needs_no_roscore_fits_the_terminal_and_has_two_options(self):
        for node in NODES:
            whole = run_manual(node)
            self.assertEqual(whole.returncode, 0, whole.stdout)
            self.assertEqual(run_manual(node, '-h').stdout, whole.stdout)
            self.assertIn('rosrun unit5 %s.py' % node, whole.stdout)
            for line in whole.stdout.splitlines():
                self.assertLessEqual(len(line), WIDTH, line)
                self.assertEqual(line, line.rstrip())

    def test_it_lists_what_the_running_node_has(self):
        published = {node: listed(node, 'Publishes') for node in NODES}
        rospy.set_param('/wall_camera/rate', 2)
        self.start_all(NODES[:-1])  # one of them is a camera
        port = free_port()
        self.start('page.py', '_port:=%d' % port).wait_for('driving is on')
        change('/exercise5_6', picture='topic:/other/camera')
        for topics in published.values():  # a node with subscribers subscribes to all that it needs
            self.running += [rospy.Subscriber(name, get_message_class(kind) or rospy.AnyMsg)
                             for name, kind in topics.items()]

        async def look():
            line = await websocket_connect('ws://127.0.0.1:%d/live' % port)
            await line.write_message(json.dumps({'look': ['/exercise5_3/image']}))
            await line.read_message()
            return line
        self.line = asyncio.run(look())  # it stays open during this test
        for node, topic in (('tag_poses', '/tf'), ('exercise5_6', '/other/camera'),
                            ('page', '/exercise5_3/tags')):
            until(lambda: topic in self.registered(node, 1))
        types = dict(self.master.getTopicTypes())
        for node, topics in published.items():
            self.assertEqual(self.registered(node, 0), set(topics), node)
            self.assertEqual({topic: types[topic] for topic in topics}, topics)
            services = listed(node, 'Services')
            self.assertEqual(self.registered(node, 2), set(services), node)
            self.assertEqual({name: get_service_type(name) for name in services}, services)
            listened, any_topic = listed(node, 'Subscribes'), ANY_TOPIC.get(node, '')
            known = '|'.join(re.escape(name).replace('_N', r'_\d') for name in listened)
            for topic in self.registered(node, 1):
                self.assertRegex(topic, '^(%s|%s)$' % (known, any_topic), node)
            self.assertEqual('/TOPIC' in listened, node in ANY_TOPIC)
            for topic in set(listened) & set(types):
                self.assertEqual(types[topic], listened[topic])
            self.assert_parameters(node)

    def assert_parameters(self, node):
        description = rospy.wait_for_message('/%s/parameter_descriptions' % node, ConfigDescription, WAIT_S)
        part = run_manual(node).stdout.partition('\nParameters')[2]
        rows = re.findall(r'^  ~(\w+) +(.*)', part, re.MULTILINE)
        live = {name for name, rest in rows if re.search(r' \*( |$)', rest)}
        self.assertEqual(live, {each.name for group in description.groups for each in group.parameters}, node)
        self.assertEqual(len(rows), len({name for name, _ in rows}))


if __name__ == '__main__':
    rospy.init_node('manual_test')
    rostest.rosrun('unit5', 'manual_test', Manuals)
