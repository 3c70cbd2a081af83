#!/usr/bin/env python3
"""A full disk: write errors are reported, no incomplete file is left, and nodes continue."""
import os
import subprocess
import tempfile
import threading

import cv2
import numpy as np
import rospy
import rostest
from rig.nodes.case import NodeTest, scene
from rig.processes.skip import skip
from rig.processes.started import WAIT_S, Started, program
from std_srvs.srv import Trigger
from unit5.msg import TagArray

DISK_BYTES, PAGE_BYTES = 1 << 20, 4096


class DiskFull(NodeTest):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def mount(self):
        """Mount a small disk at ``folder``."""
        command = ['mount', '-t', 'tmpfs', '-o', 'size=%d' % DISK_BYTES, 'unit5', self.folder]
        if os.geteuid() != 0 or subprocess.call(command, stderr=subprocess.DEVNULL) != 0:
            skip(self.id(), 'a small disk cannot be mounted here')
        self.addCleanup(subprocess.check_call, ['umount', '--lazy', self.folder])

    def fill(self, room):
        """Fill the disk except for this many bytes."""
        with open(self.folder + '/filling', 'wb') as file:
            free = os.statvfs(self.folder)
            file.write(bytes(free.f_bavail * free.f_bsize - room))

    def written(self):
        """The paths of all files in the folder, including hidden ones."""
        return sorted(os.path.join(place, name) for place, _, names in os.walk(self.folder) for name in names
                      if name != 'filling')

    def snapshot(self):
        """Request a snapshot while frames are shown, in which the area must be painted; returns the answer."""
        rospy.wait_for_service('/exercise5_6/snapshot', WAIT_S)
        answers = []
        calling = threading.Thread(
            target=lambda: answers.append(rospy.ServiceProxy('/exercise5_6/snapshot', Trigger)()))
        calling.start()
        while calling.is_alive():
            self.assert_painted(self.answer_to(scene()), scene())
        return answers[0]

    def assert_refused(self, why, remedy):
        answer = self.snapshot()
        self.assertFalse(answer.success)
        self.assertRegex(answer.message, 'Cannot write "%s/exercise5_6_.*png": %s. %s' % (
            self.folder, why, remedy))
        self.assertEqual(self.written(), [])
        self.assert_painted(self.answer_to(scene()), scene())

    def assert_taken(self):
        answer = self.snapshot()
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.message, 'Wrote ' + ', '.join(self.written()))
        frame, image = (cv2.imread(path) for path in self.written())
        np.testing.assert_array_equal(frame, scene())
        self.assert_painted(image, frame)

    def assert_no_traceback(self):
        self.assertFalse(any('Traceback' in line for line in self.node.lines), self.node.lines)

    def test_a_snapshot_is_taken_once_there_is_room_for_all_of_it(self):
        self.mount()
        self.start_with_camera('exercise5_6', '_folder:=' + self.folder)
        # The frame takes less than 20 000 bytes, and with the image more than 100 000.
        for room in 0, PAGE_BYTES, 10 * PAGE_BYTES:
            self.fill(room)
            self.assert_refused('No space left on device', 'Make room there, or choose another place')
            os.unlink(self.folder + '/filling')
        self.assert_taken()
        self.assert_no_traceback()

    def test_a_snapshot_is_refused_if_its_files_would_be_too_large(self):
        self.publisher, self.connections = self.camera()
        self.node = Started(
            'bash', '-c', 'ulimit -f 40; exec rosrun unit5 exercise5_6.py _folder:=' + self.folder)
        self.running.append(self.node)
        self.use_inboxes({'image': self.listen('/exercise5_6/image'),
                     'tags': self.listen('/exercise5_6/tags', TagArray)})
        self.answer_to(scene())  # by then the earlier frames, in which nothing was painted, are answered
        self.assert_refused('File too large', 'Choose another place')
        self.assert_no_traceback()

    def test_tags_and_walls_are_written_completely_or_not_at_all(self):
        self.mount()
        for tool, words in (('artag_generator', ['--size', '3000', '--format', 'png', '--ids', '0-20']),
                            ('artag_generator', ['--sheet', self.folder + '/tags.pdf', '--ids', '0-249']),
                            ('gazebo_wall', [])):
            self.fill(20 * PAGE_BYTES if tool == 'artag_generator' else 5 * PAGE_BYTES)
            output = [] if '--sheet' in words else ['--output', self.folder]
            command = [program(tool + '.py'), *output, *words]
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 1, done)
            self.assertRegex(done.stderr, '%s: Cannot write "%s/.*": No space left on device. Make room there, '
                                          'or choose another place' % (tool, self.folder))
            self.assertNotIn('Traceback', done.stderr)
            self.assertEqual(self.written(), sorted(line[len('Wrote '):] for line in done.stdout.splitlines()))
            for path in self.written():
                if path.endswith('.png'):
                    self.assertIsNotNone(cv2.imread(path), path)
                os.unlink(path)
            os.unlink(self.folder + '/filling')


if __name__ == '__main__':
    rospy.init_node('disk_full_test')
    rostest.rosrun('unit5', 'disk_full_test', DiskFull)
