#!/usr/bin/env python3
"""What exercise 5.6 paints: videos, image topics, several areas, and changes while it runs."""
import os
import tempfile
import unittest
from itertools import count
from pathlib import Path

import cv2
import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_image, image_from_frame
from dynamic_reconfigure.client import Client
from hostile.files.png import png
from rig.nodes.case import GRAY, scene
from rig.nodes.topics import Connections, Inbox, until
from rig.processes import started
from rig.processes.started import WAIT_S
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header
from unit5.msg import TagArray

RED, GREEN, BLUE = (0, 0, 255), (0, 255, 0), (255, 0, 0)


def areas_at(*lefts):
    """A frame with an area of 200 x 200 pixels at each of these left sides; its tags are numbered from 1."""
    corners = [corner for left in lefts
               for corner in ((left, 120), (left + 200, 120), (left + 200, 320), (left, 320))]
    return scene(centers=dict(enumerate(corners, start=1)), side=40)


def plain(color, width=30, height=20):
    return np.full((height, width, 3), color, np.uint8)


def bomb(path):
    """A small file that claims to be a picture of 60000 x 60000 pixels."""
    with open(path, 'wb') as file:
        file.write(png(60000, 60000))


class Picture(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.connections = Connections()
        self.camera = rospy.Publisher('/camera/rgb/image_raw', Image, self.connections, queue_size=1)
        self.addCleanup(self.camera.unregister)

    def tearDown(self):
        for name in rospy.get_param_names():
            if name.startswith('/exercise5_6/'):
                rospy.delete_param(name)

    def file(self, name, write):
        path = os.path.join(self.folder.name, name)
        write(path)
        return path

    def start(self, *arguments):
        self.node = started.node('exercise5_6.py', *arguments)
        self.addCleanup(self.node.stop)
        self.answers = Inbox('/exercise5_6/image', Image)
        self.addCleanup(self.answers.subscriber.unregister)
        self.connections.wait(1)

    def colors_of(self, frame, stamp, *places):
        """The (blue, green, red) of the node's answer to a frame at each (x, y) of ``places``."""
        self.camera.publish(image_from_frame(frame, Header(stamp=rospy.Time(stamp))))
        image = frame_from_image(self.answers.next())
        return [tuple(int(value) for value in image[y, x]) for x, y in places]

    def assert_near(self, colors, *expected):
        np.testing.assert_allclose(colors, expected, atol=8)

    def test_a_video_plays_in_the_time_of_the_frames(self):
        def write(path):
            video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), 2, (64, 64))
            for color in (RED, GREEN, BLUE):
                video.write(plain(color, 64, 64))
            video.release()
        self.start('_picture:=' + self.file('a.avi', write))
        frame, middle = areas_at(220), (320, 220)
        for stamp, color in ((10.0, RED), (10.4, RED), (10.6, GREEN), (11.1, BLUE), (11.6, RED), (12.1, GREEN)):
            self.assert_near(self.colors_of(frame, stamp, middle, (30, 30)), color, (GRAY,) * 3)

    def test_an_image_topic_is_painted_and_may_stall_resize_or_break(self):
        self.start('_picture:=topic:/other/camera')
        frame, middle, seconds = areas_at(220), (320, 220), (number / 10 for number in count(10))

        def color():
            return self.colors_of(frame, next(seconds), middle)
        self.assert_near(color(), (GRAY,) * 3)
        self.node.wait_for('Nothing has arrived on /other/camera')
        watched = Connections()
        screen = rospy.Publisher('/other/camera', Image, watched, queue_size=1)
        self.addCleanup(screen.unregister)
        watched.wait(1)

        def wait_for_painted(expected):
            until(lambda: np.abs(np.subtract(color(), expected)).max() < 8)
        screen.publish(image_from_frame(plain(RED), Header()))
        wait_for_painted(RED)
        screen.publish(image_from_frame(plain(BLUE, 641, 479), Header()))
        wait_for_painted(BLUE)
        clear = np.dstack([plain(GREEN), np.zeros((20, 30), np.uint8)])
        screen.publish(image_from_frame(clear, Header()))
        wait_for_painted((GRAY,) * 3)
        screen.publish(image_from_frame(plain(GREEN, 5, 5), Header()))
        wait_for_painted(GREEN)
        for _ in range(3):
            screen.publish(Image(height=9, width=9, step=9, encoding='nonsense', data=bytes(81)))
            screen.publish(Image())
            color()
        self.node.wait_for('A picture on /other/camera is skipped')
        screen.unregister()
        self.assert_near(color(), GREEN)  # the topic stalls, and its last picture stays
        self.assertEqual(len([line for line in self.node.lines if 'is skipped' in line]), 1)
        self.assertIsNone(self.node.process.poll())

    def test_a_compressed_topic_is_only_subscribed_to_while_somebody_subscribes_to_the_node(self):
        watched = Connections()
        screen = rospy.Publisher('/other/camera/compressed', CompressedImage, watched, queue_size=1, latch=True)
        self.addCleanup(screen.unregister)
        screen.publish(CompressedImage(data=cv2.imencode('.png', plain(BLUE))[1].tobytes()))
        self.start('_picture:=topic:/other/camera/compressed')
        watched.wait(1)
        stamps = count(1)
        until(lambda: np.abs(np.subtract(self.colors_of(areas_at(220), next(stamps), (320, 220)),
                                         BLUE)).max() < 8)
        self.answers.subscriber.unregister()
        watched.wait(0)

    def test_fit_opacity_and_picture_can_be_changed_and_wrong_values_are_refused(self):
        red = self.file('red.png', lambda path: cv2.imwrite(path, plain(RED, 20, 10)))
        green = self.file('green.png', lambda path: cv2.imwrite(path, plain(GREEN, 20, 10)))
        self.start('_picture:=' + red)
        frame, middle, edge = areas_at(220), (320, 220), (320, 140)
        client = Client('/exercise5_6', timeout=WAIT_S)
        self.addCleanup(client.close)
        self.assert_near(self.colors_of(frame, 1, middle, edge), RED, RED)
        client.update_configuration({'fit': 'contain'})
        self.assert_near(self.colors_of(frame, 2, middle, edge), RED, (GRAY,) * 3)
        client.update_configuration({'opacity': 0.5, 'picture': green})
        self.assert_near(self.colors_of(frame, 3, middle, edge), (90, 217, 90), (GRAY,) * 3)
        taken = client.update_configuration({'picture': '/no/picture.png', 'opacity': 1.0})
        self.assertEqual((taken['picture'], taken['opacity']), (green, 0.5))
        self.node.wait_for('/no/picture.png', 'not a file', 'Nothing is changed')
        taken = client.update_configuration({'fit': 'squeeze'})
        self.assertEqual(taken['fit'], 'contain')
        self.node.wait_for('~fit is "squeeze"', 'stretch, contain, cover')
        self.assert_near(self.colors_of(frame, 4, middle, edge), (90, 217, 90), (GRAY,) * 3)

    def test_hostile_files_are_refused_while_it_runs_and_the_picture_stays(self):
        self.start('_picture:=' + self.file('red.png', lambda path: cv2.imwrite(path, plain(RED))))
        client = Client('/exercise5_6', timeout=WAIT_S)
        self.addCleanup(client.close)
        for stamp, (name, write, words) in enumerate((
                ('bomb.png', bomb, 'at most 36 million pixels'), ('pipe.mp4', os.mkfifo, 'is not a file'),
                ('two\nlines.jpg', lambda path: Path(path).write_text('text'),
                 'must be the path of a picture'),
                ('list.mp4', lambda path: Path(path).write_text('#EXTM3U\nfile:///dev/zero\n'),
                 'cannot be read as a picture'))):
            path = self.file(name, write)
            client.update_configuration({'picture': path})
            self.node.wait_for(path.replace('\n', '\\n'), words, 'Nothing is changed')
            self.assert_near(self.colors_of(areas_at(220), 1 + stamp, (320, 220)), RED)
        self.assertFalse(any('Traceback' in line for line in self.node.lines), self.node.lines)

    def test_several_areas_have_their_own_pictures(self):
        red = self.file('red.png', lambda path: cv2.imwrite(path, plain(RED)))
        areas = self.file('areas.yaml', lambda path: Path(path).write_text(
            'areas:\n- {ids: [1, 2, 3, 4]}\n- {ids: [5, 6, 7, 8], picture: %s, opacity: 0.5}\n' % red))
        green = self.file('green.png', lambda path: cv2.imwrite(path, plain(GREEN)))
        self.start('_areas:=' + areas, '_picture:=' + green)
        tags = Inbox('/exercise5_6/tags', TagArray)
        self.addCleanup(tags.subscriber.unregister)
        frame, places = areas_at(50, 350), [(150, 220), (450, 220), (300, 220)]
        self.assert_near(self.colors_of(frame, 1, *places), GREEN, (90, 90, 217), (GRAY,) * 3)
        without = frame.copy()
        without[:, 310:] = GRAY
        colors = self.colors_of(without, 100, *places)
        self.assert_near(colors, GREEN, (GRAY,) * 3, (GRAY,) * 3)
        seen = [sorted(tag.id for tag in tags.next().tags)]
        while len(seen[-1]) != 4:
            seen.append(sorted(tag.id for tag in tags.next().tags))
        self.assertEqual(seen[-1], [1, 2, 3, 4])

    def test_another_picture_is_refused_if_all_areas_have_their_own(self):
        red = self.file('red.png', lambda path: cv2.imwrite(path, plain(RED)))
        areas = self.file('areas.yaml', lambda path: Path(path).write_text(
            'areas: [{ids: [1, 2, 3, 4], picture: %s}]' % red))
        self.start('_areas:=' + areas)
        client = Client('/exercise5_6', timeout=WAIT_S)
        self.addCleanup(client.close)
        self.assertEqual(client.update_configuration({'picture': red})['picture'], 'images/earth.jpg')
        self.node.wait_for('has no effect: the file that ~areas names gives each area a picture')

    def test_an_impossible_picture_ends_the_node_with_a_sentence(self):
        few = self.file('few.yaml', lambda path: Path(path).write_text('areas: [{ids: [1, 2, 3]}]'))
        for argument, words in (('_picture:=' + self.file('bomb.png', bomb), 'at most 36 million pixels'),
                                ('_picture:=topic:a b', 'must be topic:TOPIC'),
                                ('_picture:=topic:/exercise5_6/image', 'publishes itself'),
                                ('_areas:=' + few, 'four different'),
                                ('_areas:=' + self.file('pipe.yaml', os.mkfifo), 'not a file but a folder')):
            node = started.node('exercise5_6.py', argument)
            self.assertEqual(node.ends(), 1)
            node.wait_for(words)
            self.assertFalse(any('Traceback' in line for line in node.lines), node.lines)


if __name__ == '__main__':
    rospy.init_node('picture_test')
    rostest.rosrun('unit5', 'picture_test', Picture)
