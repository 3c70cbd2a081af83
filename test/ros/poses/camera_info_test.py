#!/usr/bin/env python3
"""tag_poses with a camera_info or a wall that is missing, late or wrong, and with a distorting lens."""
import itertools
import pathlib
import tempfile

import numpy as np
import rospy
import rostest
from aruco_ar.base.files import package_folder
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.images import image_from_frame
from aruco_node.messages.wall_messages import camera_info
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from rig.accuracy.sheets import frames_of
from rig.nodes.case import NodeTest
from rig.nodes.topics import Diagnostics, until
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from unit5.msg import TagArray, TagPoseArray

WALL = load_wall(package_folder() + '/config/wall.yaml')
VIEW = wall_to_camera(Pose(-1.8, 0.0, 0.1))
BENT = [-0.3, 0.1, 0.0, 0.0, 0.0]


class CameraInfos(NodeTest):
    def start_poses(self, image, info, *arguments):
        """Start tag_poses in front of a camera with these topics, and subscribe to its results."""
        self.images, connections = self.camera(image)
        self.infos, others = self.camera(info, CameraInfo)
        self.node = self.start('tag_poses.py', 'camera/rgb/image_raw:=' + image, *arguments)
        self.seen = {'tags': self.listen('/tag_poses/tags', TagArray),
                     'poses': self.listen('/tag_poses/poses', TagPoseArray)}
        connections.wait(1)
        others.wait(1)

    def count_tags(self, frame, frame_id='eye'):
        """Publish a frame; returns how many tags are found in it."""
        stamp = rospy.Time.now()
        self.images.publish(image_from_frame(frame, Header(stamp=stamp, frame_id=frame_id)))
        tags = self.seen['tags'].next()
        self.assertEqual(tags.header.stamp, stamp)
        return len(tags.tags)

    def show_until_logged(self, frame, words, frame_id='eye'):
        """Publish frames until the node has logged these words; meanwhile it must find the tags."""
        until(lambda: self.assertEqual(self.count_tags(frame, frame_id), 4) or
              any(words in line for line in self.node.lines))

    def show_until_posed(self, frame, info):
        """Publish a camera_info, and frames until poses arrive; returns the poses."""
        self.infos.publish(info)
        until(lambda: self.assertEqual(self.count_tags(frame), 4) or not self.seen['poses'].empty())
        return self.seen['poses'].next().tags

    def assert_poses_are_right(self, tags):
        rotation, translation = VIEW
        self.assertEqual(sorted(tag.id for tag in tags), [1, 2, 3, 4])
        for tag in tags:
            place = next(each for each in WALL.tags if each.id == tag.id)
            true = rotation @ [place.x, place.y, 0] + translation
            found = tag.pose.pose.position
            self.assertLess(np.linalg.norm(np.array([found.x, found.y, found.z]) - true), 0.015)

    def test_a_missing_camera_info_is_reported_only_while_frames_arrive(self):
        diagnostics = Diagnostics()
        self.running.append(diagnostics.subscriber)
        self.start_poses('/eye/image_raw', '/eye/camera_info')
        self.show_until_logged(WallRenderer(WALL, Camera()).render(*VIEW), 'nothing arrives on it')
        self.assertIn('lens', diagnostics.wait('tag_poses', 'but no poses', level=DiagnosticStatus.WARN))
        for inbox in self.seen.values():
            inbox.subscriber.unregister()
        self.assertNotIn('lens', diagnostics.wait('tag_poses', 'Nobody listens'))

    def test_without_a_good_camera_info_tags_are_found_but_have_no_poses(self):
        self.start_poses('/eye/image_raw', '/eye/camera_info')
        frame, camera = WallRenderer(WALL, Camera()).render(*VIEW), Camera()
        self.assertEqual(self.count_tags(frame), 4)
        self.show_until_logged(frame, 'nothing arrives on it')
        for wrong, words in ((CameraInfo(), 'for what size of frames'),
                             (CameraInfo(width=640, height=480), 'K is not a camera matrix'),
                             (camera_info(Camera(width=1280, height=960), None), 'for frames of 1280 x 960')):
            for _ in range(3):
                self.infos.publish(wrong)
                self.show_until_logged(frame, words)
        self.assertTrue(self.seen['poses'].empty())
        self.assert_poses_are_right(self.show_until_posed(frame, camera_info(camera, None)))
        for words in 'nothing arrives on it', 'for what size', 'K is not a camera matrix', '1280 x 960':
            warnings = [line for line in self.node.lines if words in line]
            self.assertEqual(len(warnings), 1, warnings)
            self.assertIn('/eye/camera_info', warnings[0])
            self.assertIn('WARN', warnings[0])

    def test_a_camera_info_below_the_images_is_found(self):
        self.start_poses('/sim/front/Scene', '/sim/front/Scene/camera_info')
        self.assert_poses_are_right(self.show_until_posed(WallRenderer(WALL, Camera()).render(*VIEW),
                                                          camera_info(Camera(), None)))
        self.assertTrue([line for line in self.node.lines if 'Nothing publishes /sim/front/camera_info, so the '
                         'calibration is taken from /sim/front/Scene/camera_info.' in line])

    def test_without_a_camera_info_those_that_exist_are_named(self):
        self.images, connections = self.camera('/eye/image_raw')
        self.camera('/other/camera_info', CameraInfo)
        self.node = self.start('tag_poses.py', 'camera/rgb/image_raw:=/eye/image_raw')
        self.seen = {'tags': self.listen('/tag_poses/tags', TagArray)}
        connections.wait(1)
        self.show_until_logged(WallRenderer(WALL, Camera()).render(*VIEW), '/eye/camera_info: nothing arrives '
                               'on it. These are published: /other/camera_info. Choose one: camera_info:=TOPIC')

    def test_the_reading_of_an_unusual_camera_info_is_told_once(self):
        self.start_poses('/eye/image_rect', '/eye/camera_info')
        info = camera_info(Camera(), None)
        info.P = [0.0] * 12
        frame = WallRenderer(WALL, Camera()).render(*VIEW)
        for _ in range(2):
            self.assert_poses_are_right(self.show_until_posed(frame, info))
        told = [line for line in self.node.lines if '/eye/camera_info: its P is all zero' in line]
        self.assertEqual(len(told), 1)

    def test_a_calibration_of_another_focal_length_is_told(self):
        self.start_poses('/eye/image', '/eye/camera_info')
        self.infos.publish(camera_info(Camera(fov=1.3), Header()))
        with tempfile.TemporaryDirectory() as folder:
            frames = list(frames_of(Camera(), pathlib.Path(folder, 'wall.yaml')))
        stamps = itertools.count(100)

        def is_told():
            for frame in (frame for frame in frames for _ in range(2)):  # only still views are compared
                self.images.publish(image_from_frame(frame, Header(stamp=rospy.Time(next(stamps)))))
                self.seen['tags'].next()
            return any('The calibration does not fit this camera' in line for line in self.node.lines)
        until(is_told)

    def test_the_distortion_of_the_lens_is_corrected(self):
        self.start_poses('/eye/image_raw', '/eye/camera_info')
        camera = Camera(distortion=BENT)
        frame = WallRenderer(WALL, camera).render(*VIEW)
        self.assert_poses_are_right(self.show_until_posed(frame, camera_info(camera, None)))

    def test_the_frames_of_a_rectified_topic_are_not_corrected_again(self):
        self.start_poses('/eye/image_rect_color', '/eye/camera_info')
        # The camera_info has the distortion, but the frames have been corrected.
        info = camera_info(Camera(distortion=BENT), None)
        self.assert_poses_are_right(self.show_until_posed(WallRenderer(WALL, Camera()).render(*VIEW), info))

    def test_poses_of_a_resized_frame_with_another_camera_info_topic_are_right(self):
        self.start_poses('/eye/image_raw', '/else/where', '_scale:=0.5', '_camera_info:=/else/where')
        self.assert_poses_are_right(self.show_until_posed(WallRenderer(WALL, Camera()).render(*VIEW),
                                                camera_info(Camera(), None)))

    def test_a_wrong_wall_file_is_reported(self):
        frame, info = WallRenderer(WALL, Camera()).render(*VIEW), camera_info(Camera(), None)
        with open(package_folder() + '/config/wall.yaml') as file:
            fitting = file.read()
        for change, words in ((('side: 0.18', 'side: 0.15'), 'The tags in sight do not fit the wall of "%s"'),
                              (('x:  0.45, y: 0.25', 'x:  0.35, y: 0.25'),
                               'These tags are not where "%s" says: 3.')):
            with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
                file.write(fitting.replace(*change))
                file.flush()
                self.start_poses('/eye/image_raw', '/eye/camera_info', '_wall:=' + file.name)
                self.show_until_posed(frame, info)
                self.show_until_logged(frame, words % file.name)
            self.tearDown()
            self.setUp()

    def test_one_tag_of_a_wall_file_is_enough_to_locate_the_camera(self):
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
            file.write('tags: [{id: 4, x: -0.45, y: 0.25, side: 0.18}]')
            file.flush()
            self.start_poses('/eye/image_raw', '/eye/camera_info', '_wall:=' + file.name)
            self.assert_camera('wall', -VIEW[0].T @ VIEW[1])

    def test_a_learned_wall_has_its_own_frame(self):
        self.start_poses('/eye/image_raw', '/eye/camera_info')
        first = WALL.tags[0]  # that with the lowest id
        self.assert_camera('learned_wall', -VIEW[0].T @ VIEW[1] - [first.x, first.y, 0])

    def assert_camera(self, frame_id, place):
        """Assert that the camera is at that place in that frame."""
        self.seen['camera'] = self.listen('/tag_poses/camera_pose', PoseWithCovarianceStamped)
        frame = WallRenderer(WALL, Camera()).render(*VIEW)
        self.show_until_posed(frame, camera_info(Camera(), None))
        until(lambda: self.count_tags(frame) and not self.seen['camera'].empty())
        message = self.seen['camera'].next()
        self.assertEqual(message.header.frame_id, frame_id)
        found = message.pose.pose.position
        self.assertLess(np.linalg.norm([found.x, found.y, found.z] - place), 0.05)

    def test_frames_without_a_frame_id_get_poses_but_no_tf(self):
        self.start_poses('/eye/image_raw', '/eye/camera_info')
        frames = self.listen('/tf', TFMessage)
        frame = WallRenderer(WALL, Camera()).render(*VIEW)
        self.assert_poses_are_right(self.show_until_posed(frame, camera_info(Camera(), None)))
        while not frames.empty():
            frames.next()
        self.show_until_logged(frame, 'frames of the camera have no frame_id', frame_id='')
        self.assertFalse([each for message in list(frames.queue) for each in message.transforms
                          if not each.header.frame_id])


if __name__ == '__main__':
    rospy.init_node('camera_info_test')
    rostest.rosrun('unit5', 'camera_info_test', CameraInfos)
