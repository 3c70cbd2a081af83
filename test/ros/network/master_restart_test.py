#!/usr/bin/env python3
"""The ROS master is killed and started again, or hangs: nodes continue, and register again."""
import atexit
import os
import signal
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from dynamic_reconfigure.msg import Config, DoubleParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from rig.nodes.case import CAMERA, NodeTest, change, scene
from rig.nodes.stalled import Stalled
from rig.nodes.topics import Diagnostics, until
from rig.page.server import ask, free_port
from rig.processes.started import Started, stop_all
from sensor_msgs.msg import CompressedImage, Image

AGAIN = 'it is registered again'


class Master:
    """A ROS master of the test's own, which everything uses that is started from now on."""

    def __init__(self):
        self._port = free_port()
        os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % self._port
        self.start()

    def start(self):
        self._started = Started('rosmaster', '--core', '-p', str(self._port))
        until(rosgraph.is_master_online)

    def send(self, number):
        os.killpg(self._started.process.pid, number)

    def kill(self):
        self.send(signal.SIGKILL)
        self._started.ends()


def registrations(node):
    """{(kind, name)} of what the master knows about a node: published and subscribed topics, services."""
    return {(kind, name) for kind, state in enumerate(rosgraph.Master('/test').getSystemState())
            for name, nodes in state if node in nodes}


class MasterRestart(NodeTest):
    def restart(self, *nodes):
        """Start the master, and wait until the nodes have registered again."""
        master.start()
        for node in nodes:
            node.wait_for(AGAIN)

    def test_all_nodes_register_again_and_the_page_explains_the_fault(self):
        nodes = self.start_all()
        port = int(rospy.get_param('/page/port'))
        nodes['exercise5_2'].wait_for('Nobody listens')
        before = {name: registrations('/' + name) for name in nodes}
        self.assertTrue(all(len(each) > 8 for each in before.values()), before)
        master.kill()
        nodes['exercise5_2'].wait_for('The ROS master at', 'does not answer')
        status, _, body = ask(port, '/stream?topic=/exercise5_2/image')
        self.assertEqual((status, b'does not answer' in body), (503, True))
        line_count = len(nodes['exercise5_2'].lines)
        self.restart(*nodes.values())
        for name in nodes:
            until(lambda: registrations('/' + name) == before[name])
        self.assertLess(len(nodes['exercise5_2'].lines), line_count + 4)
        self.assertIn(CAMERA, ask(port, '/')[2].decode())

    def test_connected_nodes_continue_and_others_find_the_node_again(self):
        self.start_with_camera('exercise5_6', '_opacity:=0.5', '_image_transport:=raw')
        painted = self.answer_to(scene())
        master.kill()
        self.assert_painted(self.answer_to(scene()), scene())
        self.restart(self.node)
        self.assert_painted(self.answer_to(scene()), scene())
        compressed = self.listen('/exercise5_6/image/compressed', CompressedImage)
        until(compressed.subscriber.get_num_connections)

        def is_answered():
            self.show(scene())
            return not compressed.empty()
        until(is_answered)  # the node may learn late that somebody listens
        self.assertIn('jpeg', compressed.next().format)
        self.assertEqual([rospy.get_param('/exercise5_6/' + name) for name in ('opacity', 'image_transport')],
                         [0.5, 'raw'])
        self.assertEqual(change('/exercise5_6', opacity=1.0)['opacity'], 1.0)
        self.publisher.unregister()
        api = ServerProxy(rosgraph.Master('/test').lookupNode('/exercise5_6'))
        until(lambda: CAMERA not in [each[4] for each in api.getBusInfo('/test')[2]])
        self.publisher, self.connections = self.camera()
        self.connections.wait(1)
        two = self.answer_to(scene([1, 3]))
        self.assert_painted(two, scene([1, 3]))  # the node has not forgotten the wall
        self.assertGreater(np.abs(two.astype(int) - painted).max(), 50)
        self.assertEqual(len([line for line in self.node.lines if AGAIN in line]), 1)

    def test_parameters_and_subscriptions_can_be_changed_without_a_master(self):
        self.start_with_camera('exercise5_6')
        painted = self.answer_to(scene())
        reconfigure = rospy.ServiceProxy('/exercise5_6/set_parameters', Reconfigure, persistent=True)
        reconfigure()
        image = self.listen('/exercise5_6/image')
        master.kill()
        self.assertEqual({item.name: item.value for item in reconfigure(Config(
            doubles=[DoubleParameter('opacity', 0.5)])).config.doubles}['opacity'], 0.5)
        self.node.wait_for('The ROS master at', 'does not answer', 'uses the changed parameters all the same')
        self.assertGreater(np.abs(self.answer_to(scene()).astype(int) - painted).max(), 50)
        reconfigure(Config(strs=[StrParameter('picture', 'topic:/other')]))  # it cannot subscribe to it now
        self.answer_to(scene())
        self.assertFalse([line for line in self.node.lines if 'Traceback' in line], self.node.lines)
        self.restart(self.node)
        until(lambda: (1, '/other') in registrations('/exercise5_6'))
        self.assertEqual(rospy.get_param('/exercise5_6/opacity'), 0.5)
        master.kill()
        reconfigure(Config(strs=[StrParameter('picture', 'topic:/another')]))
        self.answer_to(scene())
        stop_all([self.node])
        self.assertEqual(self.node.ends(), 0)
        master.start()
        del image

    def test_a_master_that_hangs_stops_neither_frames_nor_diagnostics_and_nodes_can_end(self):
        diagnostics = Diagnostics()
        self.running.append(diagnostics.subscriber)
        self.start_with_camera('exercise5_6')
        # This is not the camera of exercise5_6, which is the test itself.
        other = self.start('wall_camera.py', 'camera/rgb/image_raw:=/other/image')
        nodes = [self.node, other, *self.start_all(['exercise5_2', 'page']).values()]
        for node in 'exercise5_6', 'exercise5_2', 'wall_camera', 'page':
            diagnostics.wait_for_any(node)
        uri = rosgraph.Master('/test').lookupNode('/exercise5_2')
        master.send(signal.SIGSTOP)
        try:
            self.running.append(Stalled(uri, '/exercise5_2/image', Image))  # the node tries to subscribe for it
            self.publisher.publish(Image())
            self.node.wait_for('0 x 0')
            self.assert_painted(self.answer_to(scene()), scene())
            diagnostics.wait('exercise5_2', 'does not answer', level=DiagnosticStatus.ERROR)
            for node in 'wall_camera', 'page':
                diagnostics.wait_for_any(node)
            stop_all(nodes)
            self.assertEqual([node.ends() for node in nodes], [0] * 4)
        finally:
            master.send(signal.SIGCONT)


if __name__ == '__main__':
    master = Master()
    atexit.register(master.kill)
    rospy.init_node('master_restart_test')
    rostest.rosrun('unit5', 'master_restart_test', MasterRestart)
