#!/usr/bin/env python3
"""A bag in the place of a camera that is called otherwise: its images and its calibration arrive."""
import rospy
import rostest
from aruco_ar.base.files import package_folder
from rig.nodes.case import NodeTest
from rig.processes.started import Started
from sensor_msgs.msg import CameraInfo, CompressedImage

BAG = package_folder() + '/test/bags/drive_compressed.bag'


class Bag(NodeTest):
    def test_images_and_calibration_are_on_the_topics_of_the_camera(self):
        images = self.listen('/eye/image/compressed', CompressedImage)
        infos = self.listen('/eye/camera_info', CameraInfo)
        self.running.append(Started('roslaunch', 'unit5', 'camera.launch', 'camera:=/eye/image', 'bag:=' + BAG))
        self.assertGreater(len(images.next().data), 1000)
        self.assertEqual((infos.next().width, infos.next().height), (640, 480))


if __name__ == '__main__':
    rospy.init_node('bag_test')
    rostest.rosrun('unit5', 'bag_test', Bag)
