#!/usr/bin/env python3
"""A small part of the attacks on the page's server; script/torture --only page runs more."""
import random

import psutil
import rospy
import rostest
from aruco_node.messages.images import image_from_frame
from hostile.page import attacks, client
from rig.nodes.topics import until
from rig.page.server import PICTURE, ServerTest
from rig.processes.skip import skip
from sensor_msgs.msg import Image
from std_msgs.msg import Header

SHARE = 0.05
# What it may use in addition afterward: two uploads; connections to the master, until Python collects them.
MORE_MB, MORE_FDS = 128, 64


class PageAttack(ServerTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        processes = psutil.Process(cls.server.process.pid).children(recursive=True)
        cls.page = next(process for process in processes
                        if any(word.endswith('/page.py') for word in process.cmdline()))
        cls.publisher = rospy.Publisher(attacks.TOPIC, Image, queue_size=1)
        rospy.Timer(rospy.Duration(1 / 30), lambda event: cls.publisher.publish(
            image_from_frame(PICTURE, Header(stamp=rospy.Time.now()))))

    def setUp(self):
        snapshot = '/snapshot?topic=' + attacks.TOPIC
        until(lambda: client.statuses(client.get(self.port, snapshot, 5)) == [200])
        self.guest = attacks.Guest(self.port)
        self.assertTrue(self.guest.is_served())

    def attack(self, *names):
        before = self.page.memory_info().rss, self.page.num_fds(), self.page.num_threads()
        attack = attacks.Attack(self.guest, random.Random(1))
        for name in names:
            getattr(attack, name)(SHARE)
        self.assertEqual(attack.faults, [])
        self.assertGreater(attack.sent, 5)
        self.guest.close()
        until(lambda: self.page.num_fds() <= before[1] + MORE_FDS)
        until(lambda: self.page.num_threads() <= before[2] + 8)  # its thread pools grow up to their limits
        until(lambda: self.page.memory_info().rss < before[0] + 1e6 * MORE_MB)
        self.assertFalse([line for line in self.server.lines if 'Traceback' in line or
                          line.startswith(client.FORGED)], ''.join(self.server.lines))

    def test_odd_addresses_requests_and_queries_do_no_harm(self):
        self.attack('paths', 'requests', 'queries')

    def test_picture_bombs_and_large_uploads_do_no_harm(self):
        self.attack('bombs', 'uploads')

    def test_nonsense_and_floods_on_websockets_do_no_harm(self):
        self.attack('frames', 'floods')

    def test_crowds_of_clients_do_no_harm(self):
        self.attack('crowds')

    def test_the_answers_match_the_openapi_description(self):
        try:
            from hostile.page import openapi
        except ImportError:
            skip(self.id(), 'schemathesis, which needs Python 3.10, is not installed')
        known = {'topic': [attacks.TOPIC], 'file': ['page.js', 'openapi.yaml'], 'name': ['earth.jpg']}
        answers, faults = openapi.ask(self.port, 1, 4, known)
        self.assertEqual(faults, [])
        for answer in (('GET', '/', 200), ('GET', '/stream', 200), ('GET', '/snapshot', 200),
                       ('GET', '/stream', 400), ('POST', '/picture', 422), ('GET', '/page/{file}', 200)):
            self.assertGreater(answers[answer], 0, answer)
        self.guest.close()


if __name__ == '__main__':
    rospy.init_node('page_attack_test')
    rostest.rosrun('unit5', 'page_attack_test', PageAttack)
