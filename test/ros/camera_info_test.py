#!/usr/bin/env python3
"""tag_poses with a camera_info that is missing, late or wrong, and with a lens that bends."""
import unittest

import numpy as np
import rospy
import rostest
from aruco_ar.files import package_folder
from aruco_ar.render import WallRenderer
from aruco_ar.robot import Camera, Pose, wall_to_camera
from aruco_ar.wall import load_wall
from aruco_node.messages import image_from_frame
from aruco_node.wall_messages import camera_info
from listening import Connections, Inbox
from sensor_msgs.msg import CameraInfo, Image
from started import WAIT_S, Started
from std_msgs.msg import Header
from unit5.msg import TagArray, TagPoseArray

WALL = load_wall(package_folder() + '/config/wall.yaml')
VIEW = wall_to_camera(Pose(-1.8, 0.0, 0.1))
BENT = [-0.3, 0.1, 0.0, 0.0, 0.0]


class CameraInfos(unittest.TestCase):
    def setUp(self):
        self.node, self.seen, self.publishers = None, {}, {}

    def tearDown(self):
        self.node.stop()
        for inbox in self.seen.values():
            inbox.subscriber.unregister()
        for publisher, _ in self.publishers.values():
            publisher.unregister()
        rospy.delete_param('/tag_poses')

    def start(self, image, info, *arguments):
        """tag_poses before a camera with these topics; it has listeners."""
        self.image, self.info = image, info
        for topic, kind in (image, Image), (self.info, CameraInfo):
            connections = Connections()
            self.publishers[topic] = rospy.Publisher(topic, kind, connections, queue_size=1), connections
        self.node = Started('rosrun', 'unit5', 'tag_poses.py', 'camera/rgb/image_raw:=' + image, *arguments)
        self.seen = {'tags': Inbox('/tag_poses/tags', TagArray), 'poses': Inbox('/tag_poses/poses', TagPoseArray)}
        for _, connections in self.publishers.values():
            connections.wait(1)

    def show(self, frame):
        """Publish a frame; how many tags are found in it."""
        stamp = rospy.Time.now()
        self.publishers[self.image][0].publish(image_from_frame(frame, Header(stamp=stamp, frame_id='eye')))
        tags = self.seen['tags'].next()
        self.assertEqual(tags.header.stamp, stamp)
        return len(tags.tags)

    def show_until_said(self, frame, words):
        """Publish frames, in which tags are found all the while, until the node has said these words."""
        until = rospy.Time.now() + rospy.Duration(WAIT_S)
        while not any(words in line for line in self.node.lines):
            self.assertEqual(self.show(frame), 4)
            self.assertLess(rospy.Time.now(), until, words)

    def show_until_posed(self, frame, info):
        """Publish a camera_info and frames until poses come; what they say."""
        self.publishers[self.info][0].publish(info)
        for _ in range(100):
            self.assertEqual(self.show(frame), 4)
            if not self.seen['poses'].empty():
                return self.seen['poses'].next().tags
        raise AssertionError('no poses in 100 frames')

    def assert_right(self, tags):
        rotation, translation = VIEW
        self.assertEqual(sorted(tag.id for tag in tags), [1, 2, 3, 4])
        for tag in tags:
            place = next(each for each in WALL.tags if each.id == tag.id)
            true = rotation @ [place.x, place.y, 0] + translation
            found = tag.pose.pose.position
            self.assertLess(np.linalg.norm(np.array([found.x, found.y, found.z]) - true), 0.015)

    def test_without_a_good_camera_info_the_tags_are_found_and_the_poses_wait(self):
        self.start('/eye/image_raw', '/eye/camera_info')
        frame, camera = WallRenderer(WALL, Camera()).render(*VIEW), Camera()
        self.assertEqual(self.show(frame), 4)
        self.show_until_said(frame, 'nothing arrives on it')
        for wrong, words in ((CameraInfo(), 'for frames of 0 x 0 pixels'),
                             (CameraInfo(width=640, height=480), 'no focal length'),
                             (camera_info(Camera(width=1280, height=960), None), 'for frames of 1280 x 960')):
            for _ in range(3):
                self.publishers[self.info][0].publish(wrong)
                self.show_until_said(frame, words)
        self.assertTrue(self.seen['poses'].empty())
        self.assert_right(self.show_until_posed(frame, camera_info(camera, None)))
        for words in 'nothing arrives on it', '0 x 0', 'no focal length', '1280 x 960':
            told = [line for line in self.node.lines if words in line]
            self.assertEqual(len(told), 1, told)
            self.assertIn('/eye/camera_info', told[0])
            self.assertIn('WARN', told[0])

    def test_a_lens_that_bends_is_honored(self):
        self.start('/eye/image_raw', '/eye/camera_info')
        camera = Camera(distortion=BENT)
        self.assert_right(self.show_until_posed(WallRenderer(WALL, camera).render(*VIEW), camera_info(camera, None)))

    def test_a_rectified_topic_is_taken_as_such(self):
        self.start('/eye/image_rect_color', '/eye/camera_info')
        # The calibration says how the lens bends; the frames have been corrected.
        info = camera_info(Camera(distortion=BENT), None)
        self.assert_right(self.show_until_posed(WallRenderer(WALL, Camera()).render(*VIEW), info))

    def test_a_resized_frame_and_a_topic_elsewhere(self):
        self.start('/eye/image_raw', '/else/where', '_scale:=0.5', '_camera_info:=/else/where')
        self.assert_right(self.show_until_posed(WallRenderer(WALL, Camera()).render(*VIEW),
                                                camera_info(Camera(), None)))


if __name__ == '__main__':
    rospy.init_node('camera_info_test')
    rostest.rosrun('unit5', 'camera_info_test', CameraInfos)
