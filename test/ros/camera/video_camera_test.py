#!/usr/bin/env python3
"""Any camera works: a video file, and a stream from the network."""
import os
import tempfile
import unittest

import cv2
import rospy
import rostest
from aruco_ar import Detector
from aruco_ar.base.files import package_folder
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.images import frame_from_image
from rig.nodes.topics import Inbox
from rig.page.server import free_port
from rig.processes.started import Started, node
from sensor_msgs.msg import Image
from unit5.msg import TagArray


class VideoCamera(unittest.TestCase):
    def test_tags_are_found_in_a_video_and_in_its_stream(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, 'wall.avi')
        renderer = WallRenderer(load_wall(package_folder() + '/config/wall.yaml'), Camera())
        video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), 15, (640, 480))
        for number in range(15):
            video.write(renderer.render(*wall_to_camera(Pose(-2.2 + number / 30, 0, 0))))
        video.release()
        self.launch('source:=' + path)
        self.assertEqual(self.ids_on('/camera/rgb/image_raw'), {1, 2, 3, 4})
        finder = self.start('exercise5_2.py')
        tags = Inbox('/exercise5_2/tags', TagArray)
        self.addCleanup(tags.subscriber.unregister)
        for _ in range(40):  # more than two rounds, with an empty frame after each
            self.assertEqual({tag.id for tag in tags.next().tags}, {1, 2, 3, 4})
        self.assertFalse([line for line in finder.lines if 'ERROR' in line], finder.lines)

        port = free_port()
        self.start('page.py', '_port:=%d' % port).wait_for('The page is at')
        self.launch('source:=http://127.0.0.1:%d/stream?topic=/camera/rgb/image_raw' % port, 'name:=phone',
                    'camera:=/phone/image_raw')
        self.assertEqual(self.ids_on('/phone/image_raw'), {1, 2, 3, 4})

    def launch(self, *arguments):
        launched = Started('roslaunch', 'unit5', 'video_camera.launch', *arguments)
        self.addCleanup(launched.stop)

    def start(self, *arguments):
        process = node(*arguments)
        self.addCleanup(process.stop)
        return process

    def ids_on(self, topic):
        """The ids of the tags in 20 frames of a topic, which is more than one round of the video."""
        frames = Inbox(topic, Image)
        self.addCleanup(frames.subscriber.unregister)
        found = [frames.next() for _ in range(20)]
        self.assertGreater(len({bytes(frame.data) for frame in found}), 5)  # the video plays
        return {tag.id for tag in Detector().detect(frame_from_image(found[-1]))}


if __name__ == '__main__':
    rospy.init_node('video_camera_test')
    rostest.rosrun('unit5', 'video_camera_test', VideoCamera)
