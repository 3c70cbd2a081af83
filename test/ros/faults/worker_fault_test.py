#!/usr/bin/env python3
"""If a function of a node raises an error, the log and /diagnostics say so, and the node continues."""
import os
import sys
import tempfile
import threading

import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_image
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rig.nodes.case import CAMERA, NodeTest, change, scene
from rig.nodes.topics import Diagnostics, until
from rig.page.server import ask, free_port
from rig.processes import failing
from rig.processes.started import WAIT_S, Started
from std_srvs.srv import Trigger
from unit5.msg import TagPoseArray

ERROR = DiagnosticStatus.ERROR
FAILING = failing.__file__


class WorkerFault(NodeTest):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.showing = threading.Lock()
        self.file = folder.name + '/fails'
        self.diagnostics = Diagnostics()
        self.running.append(self.diagnostics.subscriber)

    def make_fail(self, place=''):
        with open(self.file + '.new', 'w') as file:
            file.write(place)
        os.replace(self.file + '.new', self.file)

    def start_failing(self, name, places, *arguments):
        self.make_fail()
        self.name, self.node = name, Started(sys.executable, FAILING, self.file, ','.join(places), name + '.py',
                                             *arguments)
        self.running.append(self.node)

    def assert_reported(self, provokes):
        """Let functions, {place: what calls it}, raise twice each; it must be reported, and logged once."""
        for place, provoke in provokes.items():
            self.make_fail(place)
            provoke()
            provoke()
            self.diagnostics.wait(self.name, 'A fault of this node', 'RuntimeError: %s fails, number' % place,
                                level=ERROR)
        self.make_fail()
        diagnostics = self.listen('/diagnostics', DiagnosticArray)
        until(lambda: all(status.level < ERROR for status in diagnostics.next().status))  # it may also be slow
        for place in provokes:
            logged = [line for line in self.node.lines if 'RuntimeError: %s fails' % place in line]
            self.assertEqual(len(logged), 1, self.node.lines)
        self.assertEqual(len([line for line in self.node.lines if 'Traceback' in line]), len(provokes),
                         self.node.lines)

    def show_repeatedly(self):
        """Show frames until the test is over."""
        frames = rospy.Timer(rospy.Duration(0.1), lambda event: self.show(scene()))
        self.addCleanup(frames.join)
        self.addCleanup(frames.shutdown)

    def next_message(self, topic):
        """Wait for the next message on a topic."""
        while not self.inboxes[topic].empty():
            self.inboxes[topic].get()
        return self.inboxes[topic].next()

    def show(self, frame, stamp=None):
        with self.showing:
            return super().show(frame, stamp)

    def call(self, service):
        rospy.wait_for_service(service, WAIT_S)
        return rospy.ServiceProxy(service, Trigger)()

    def test_an_exercise_continues_if_its_loop_its_frames_or_its_services_fail(self):
        node = 'aruco_node.nodes.camera_node:CameraNode.'
        look = 'aruco_ar.tracking.observer:Observer.look'
        write = 'aruco_node.health.snapshot:SnapshotService._write'
        self.publisher, self.connections = self.camera()
        self.start_failing('exercise5_6', [look, write] + [
            node + name for name in ('is_wanted', 'report', 'reset', 'prepare')])
        self.inboxes = {'image': self.listen('/exercise5_6/image')}
        self.use_inboxes(self.inboxes)
        self.answer_to(scene())  # by then the earlier frames are answered
        self.show_repeatedly()

        def answers():
            self.assert_painted(frame_from_image(self.next_message('image')), scene())

        def ask_for(service):
            with self.assertRaisesRegex(rospy.ServiceException, 'fails, number'):
                self.call('/exercise5_6/' + service)

        def reconfigure():
            self.assertEqual(change('/exercise5_6', opacity=0.5)['opacity'], 1.0)
        self.assert_reported({node + 'is_wanted': answers, node + 'report': answers, look: lambda: None,
                          node + 'reset': lambda: ask_for('reset'), write: lambda: ask_for('snapshot'),
                          node + 'prepare': reconfigure})
        answers()
        self.assertTrue(self.call('/exercise5_6/reset').success)
        self.assertEqual(change('/exercise5_6', opacity=0.5)['opacity'], 0.5)

    def test_poses_are_published_again_after_the_calibration_failed(self):
        info = 'aruco_node.nodes.camera_lens:CameraLens.lens'
        check = 'aruco_ar.poses.wall_watch:WallWatch.check'
        self.publish_camera_info()
        self.publisher, self.connections = self.camera()
        self.start_failing('tag_poses', [info, check])
        self.inboxes = {'poses': self.listen('/tag_poses/poses', TagPoseArray)}
        self.use_inboxes(self.inboxes)
        self.answer_to(scene(), 'poses')  # by then the earlier frames are answered
        self.show_repeatedly()
        self.assert_reported({info: lambda: None, check: lambda: None})
        self.assertEqual(sorted(tag.id for tag in self.next_message('poses').tags), [1, 2, 3, 4])

    def test_the_simulated_camera_publishes_again(self):
        observe = 'aruco_node.messages.wall_messages:observe'
        render = 'aruco_ar.simulation.render:WallRenderer.render'
        self.start_failing('wall_camera', [observe, render])
        self.inboxes = {'camera': self.listen(CAMERA)}
        self.next_message('camera')
        self.assert_reported({observe: lambda: None, render: lambda: None})
        self.assertGreater(np.ptp(np.frombuffer(self.next_message('camera').data, np.uint8)), 50)

    def test_the_page_is_served_again(self):
        state, images = 'page_server.choices:Choices.state', 'aruco_node.page.topics:Topics.images'
        port = free_port()
        self.start_failing('page', [state, images], '_port:=%d' % port)
        self.node.wait_for('The page is at')
        self.assert_reported({state: lambda: None, images: lambda: self.assertEqual(ask(port, '/')[0], 500)})
        self.assertEqual(ask(port, '/')[0], 200)


if __name__ == '__main__':
    rospy.init_node('worker_fault_test')
    rostest.rosrun('unit5', 'worker_fault_test', WorkerFault)
