#!/usr/bin/env python3
"""Exercises 5.4 to 5.6 in front of a camera whose lens bends the straight lines of the wall."""
import cv2
import numpy as np
import rospy
import rostest
from aruco_ar.base.files import package_folder
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.wall_messages import camera_info
from rig.nodes.case import NodeTest, change
from rig.nodes.topics import until
from sensor_msgs.msg import CameraInfo

WALL = load_wall(package_folder() + '/config/wall.yaml')
VIEW = wall_to_camera(Pose(-1.8, 0.0, 0.1))
BENT = Camera(distortion=[-0.3, 0.1, 0.0, 0.0, 0.0])
FRAME = WallRenderer(WALL, BENT).render(*VIEW)
CORNERS = WALL.area_corners


def true_masks():
    """(outer, inner): bool masks of the true area, with and without a margin of two pixels."""
    steps = np.arange(50)[:, None] / 50
    sides = [begin + steps * (end - begin) for begin, end in zip(CORNERS, np.roll(CORNERS, -1, axis=0))]
    outline = project(np.concatenate(sides), *VIEW, BENT)[0]
    mask = cv2.fillPoly(np.zeros((480, 640), np.uint8), [np.int32(np.round(outline))], 1)
    kernel = np.ones((5, 5), np.uint8)
    return cv2.dilate(mask, kernel) > 0, cv2.erode(mask, kernel) > 0


OUTER, INNER = true_masks()


class Distortion(NodeTest):
    def start_exercise(self, name, info, *topics):
        """Start an exercise in front of the camera, with a CameraInfo."""
        infos, connections = self.camera('/camera/rgb/camera_info', CameraInfo)
        self.start_with_camera(name, topics=['image', *topics])
        connections.wait(1)
        infos.publish(info)

    def mask_is_bent(self):
        """Whether the mask that answers a frame is the true area."""
        mask = self.answer_to(FRAME, 'mask')[0].max(axis=2) > 127
        return not mask[~OUTER].any() and mask[INNER].all()

    def share_outside(self):
        """The share of the pixels outside of the true area that the exercise changes."""
        return np.any(self.answer_to(FRAME) != FRAME, axis=2)[~OUTER].mean()

    def share_inside(self):
        """The share of the pixels in the true area that the exercise changes."""
        return np.any(self.answer_to(FRAME) != FRAME, axis=2)[INNER].mean()

    def test_the_mask_is_bent_as_the_wall_is_and_the_parameter_lens_switches_that_off(self):
        self.start_exercise('exercise5_5', camera_info(BENT, None), 'mask')
        until(self.mask_is_bent)
        change('/exercise5_5', lens='ignore')
        self.assertFalse(self.mask_is_bent())
        change('/exercise5_5', lens='correct')
        self.assertTrue(self.mask_is_bent())

    def test_the_picture_is_bent_as_the_wall_is(self):
        self.start_exercise('exercise5_6', camera_info(BENT, None))
        until(lambda: self.share_outside() == 0)
        self.assertGreater(self.share_inside(), 0.995)

    def test_the_polygon_is_bent_as_the_wall_is(self):
        self.start_exercise('exercise5_4', camera_info(BENT, None))
        until(lambda: self.share_outside() < 0.001)  # the dots on the centers reach out of the area
        self.assertGreater(self.share_inside(), 0.995)

    def test_a_camera_info_that_cannot_be_right_is_reported_and_not_used(self):
        self.start_exercise('exercise5_5', camera_info(Camera(width=1280, height=960), None), 'mask')
        problem = ('The lens is taken to be free of distortion: /camera/rgb/camera_info: it is for frames of '
                   '1280 x 960')
        # The first frames may be answered before the calibration has arrived.
        until(lambda: self.answer_to(FRAME, 'mask')[0].max() == 255
              and any(problem in line for line in self.node.lines))
        self.assertFalse(self.mask_is_bent())


if __name__ == '__main__':
    rospy.init_node('distortion_test')
    rostest.rosrun('unit5', 'distortion_test', Distortion)
