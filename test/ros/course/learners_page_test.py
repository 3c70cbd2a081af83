#!/usr/bin/env python3
"""The page shows a learner's images beside ours, and his last verdict, while they are published."""
import os
import re
import tempfile

import cv2
import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_image
from rig.nodes.topics import Inbox, until
from rig.page.server import ServerTest, ask
from rig.processes.started import node
from rospy import Publisher
from sensor_msgs.msg import Image

VERDICT = '/learn_verdict/image'


class LearnersPage(ServerTest):
    def shown(self):
        """The topics of the page's tiles, in their order."""
        _, _, body = ask(self.port, '/')
        return re.findall('class="tile" data-topic="([^"]+)"', body.decode())

    def test_yours_is_beside_ours(self):
        until(lambda: '/exercise5_4/image' in self.shown())
        self.assertNotIn('/my_exercise5_4/image', self.shown())
        topics = ['/camera/rgb/image_raw', '/exercise5_4/image', '/my_exercise5_4/image']
        publishers = [Publisher(topic, Image, queue_size=1) for topic in topics]
        until(lambda: self.shown() == topics)
        for publisher in publishers:
            publisher.unregister()

    def test_the_newest_verdict_is_a_tile(self):
        with tempfile.TemporaryDirectory() as package:
            program = node('learn_verdict.py', package)
            self.addCleanup(program.stop)
            inbox = Inbox(VERDICT, Image, newest=1)
            self.addCleanup(inbox.subscriber.unregister)
            os.makedirs(os.path.join(package, '.learn', 'pictures'))
            for number, color in enumerate(((200, 30, 10), (10, 220, 90)), 2):
                picture = np.full((48, 64, 3), color, np.uint8)
                draft = os.path.join(package, 'draft.png')
                cv2.imwrite(draft, picture)
                os.utime(draft, (number, number))
                os.replace(draft, os.path.join(package, '.learn', 'pictures', '5_%d.png' % number))
                until(lambda picture=picture: np.array_equal(frame_from_image(inbox.next()), picture))
            until(lambda: VERDICT in self.shown())


if __name__ == '__main__':
    rospy.init_node('learners_page_test')
    rostest.rosrun('unit5', 'learners_page_test', LearnersPage)
