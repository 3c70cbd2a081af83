#!/usr/bin/env python3
"""What Foxglove shows beside and over ~image: ~annotations and ~camera_info, with the header of each frame."""
import numpy as np
import rospy
import rostest
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.annotations import kinds
from aruco_node.messages.wall_messages import camera_info
from rig.nodes.case import CENTERS, NodeTest, scene
from rig.nodes.topics import until
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

ANNOTATIONS, INFO = kinds().ImageAnnotations, '/camera/rgb/camera_info'
EXERCISES = ['exercise5_%d' % number for number in range(2, 7)]


class Foxglove(NodeTest):
    def start_calibrated(self, name, *arguments, info=None):
        """Start a node in front of a camera with this CameraInfo; subscribe to what goes with its images."""
        self.infos, others = self.camera(INFO, CameraInfo)
        self.start_with_camera(name, *arguments, annotations=ANNOTATIONS)
        self.made = self.listen('/%s/camera_info' % name, CameraInfo)
        others.wait(1)
        self.infos.publish(info or camera_info(Camera(), Header(frame_id='of the driver')))

    def made_beside(self, frame):
        """Show a frame until a CameraInfo comes; returns that and the image with the same stamp."""
        images = {}

        def is_made():
            stamp = self.show(frame)
            while stamp not in images:
                image = self._inboxes['image'].next()
                images[image.header.stamp] = image
            return not self.made.empty()
        until(is_made)
        info = self.made.next()
        return info, images[info.header.stamp]

    def test_every_exercise_has_marks_on_the_tags_at_the_time_of_the_frame(self):
        for name in EXERCISES:
            with self.subTest(name):
                self.start_with_camera(name, topics=(), annotations=ANNOTATIONS)
                del self._inboxes['tags']
                stamp = self.show(scene())
                marks = self._inboxes['annotations'].next()
                while not marks.texts or marks.texts[0].timestamp != stamp:
                    marks = self._inboxes['annotations'].next()
                for text in marks.texts:
                    place, center = (text.position.x, text.position.y), CENTERS[int(text.text)]
                    np.testing.assert_allclose(place, center, atol=1)
                self.assertEqual({text.text for text in marks.texts}, {'1', '2', '3', '4'})
                self.assertEqual(len(marks.points) - 4, name in ('exercise5_5', 'exercise5_6'))  # the area
                self.tearDown()
                self.setUp()

    def test_every_exercise_passes_on_the_calibration_with_the_header_of_each_image(self):
        for name in EXERCISES:
            with self.subTest(name):
                self.start_calibrated(name)
                info, image = self.made_beside(scene())
                self.assertEqual((info.header.stamp, info.header.frame_id), (image.header.stamp, 'eye'))
                self.assertEqual((info.width, info.height, *info.K), (640, 480, *Camera().matrix.ravel()))
                self.tearDown()
                self.setUp()

    def test_the_calibration_fits_resized_images(self):
        self.start_calibrated('exercise5_2', '_scale:=0.5')
        info, image = self.made_beside(scene())
        self.assertEqual((info.width, info.height), (image.width, image.height))
        self.assertAlmostEqual(info.K[0], Camera().matrix[0, 0] / 2)

    def test_a_camera_without_calibration_gets_none(self):
        of_size = CameraInfo(width=640, height=480)
        silent = 'Nothing is published on ~camera_info. %s: its K is not' % INFO
        for name, info, words in (('exercise5_6', CameraInfo(), 'for what size of frames'),
                                  ('exercise5_6', of_size, 'K is not a camera matrix'),
                                  ('exercise5_2', of_size, silent)):
            self.start_calibrated(name, info=info)
            until(lambda words=words: self.answer_to(scene(), 'image') and
                  any(words in line for line in self.node.lines))
            for _ in range(3):
                self.answer_to(scene(), 'image')
            self.assertTrue(self.made.empty())
            self.tearDown()
            self.setUp()


if __name__ == '__main__':
    rospy.init_node('foxglove_test')
    rostest.rosrun('unit5', 'foxglove_test', Foxglove)
