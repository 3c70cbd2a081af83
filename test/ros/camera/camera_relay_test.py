#!/usr/bin/env python3
"""camera_relay passes frames on: as JPEG on a robot, decoded on a base station."""
import numpy as np
import rospy
import rostest
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import (
    compressed_from_frame,
    frame_from_compressed,
    frame_from_image,
    image_from_frame,
)
from aruco_node.messages.wall_messages import camera_info
from rig.nodes.case import CAMERA, NodeTest, change, scene
from rig.nodes.topics import until
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

SENT, INFO = '/camera_relay/image_raw', '/camera_relay/camera_info'
RATE = 30


class Relay(NodeTest):
    def relay(self, kind, *arguments):
        """Start camera_relay with a camera of this type of message, and a camera_info for 1280 x 960."""
        self.images, self.connections = self.camera(CAMERA + '/compressed' * (kind is CompressedImage), kind)
        self.calibrations, self.others = self.camera('/camera/rgb/camera_info', CameraInfo)
        self.node = self.start('camera_relay.py', *arguments)
        self.stamps = (rospy.Time.from_sec(100 + number / RATE) for number in range(10**6))

    def show_one(self):
        """Publish a frame; returns its header."""
        header = Header(stamp=next(self.stamps), frame_id='eye')
        make = image_from_frame if self.images.data_class is Image else compressed_from_frame
        self.images.publish(make(scene(), header))
        return header

    def relay_one(self, inbox):
        """Publish a frame; returns the relayed message, and the frame's header."""
        self.connections.wait(1)
        header = self.show_one()
        return inbox.next(), header

    def test_on_a_robot_frames_become_jpegs_of_the_requested_quality(self):
        self.relay(Image, '_quality:=90')
        inbox = self.listen(SENT + '/compressed', CompressedImage)
        fine, header = self.relay_one(inbox)
        self.assertEqual((fine.header.stamp, fine.header.frame_id), (header.stamp, 'eye'))
        self.assertIn('jpeg', fine.format)
        self.assertLess(np.abs(frame_from_compressed(fine).astype(int) - scene()).mean(), 1)
        change('/camera_relay', quality=20.0)
        coarse, _ = self.relay_one(inbox)
        self.assertLess(len(coarse.data), 0.6 * len(fine.data))
        self.assertLess(np.abs(frame_from_compressed(coarse).astype(int) - scene()).mean(), 5)

    def test_on_a_base_station_frames_are_decoded(self):
        self.relay(CompressedImage, '_image_transport:=compressed')
        answer, header = self.relay_one(self.listen(SENT))
        self.assertEqual((answer.header.stamp, answer.header.frame_id), (header.stamp, 'eye'))
        self.assertLess(np.abs(frame_from_image(answer).astype(int) - scene()).mean(), 1)

    def test_each_frame_has_its_camera_info(self):
        self.relay(Image)
        images, infos = self.listen(SENT), self.listen(INFO, CameraInfo)
        self.others.wait(1)
        self.calibrations.publish(camera_info(Camera(1280, 960), Header(stamp=rospy.Time(7))))
        headers = []
        until(lambda: headers.append(self.relay_one(images)[1]) or not infos.empty())
        info = infos.next()
        self.assertEqual((info.width, info.height, info.K[0]), (1280, 960, Camera(1280, 960).matrix[0, 0]))
        while info.header.stamp != headers[-1].stamp:
            info = infos.next()
        self.assertEqual(info.header.frame_id, 'eye')

    def test_no_more_frames_than_requested_are_relayed(self):
        self.relay(Image, '_rate:=10')
        inbox = self.listen(SENT)
        self.relay_one(inbox)
        for _ in range(10):
            self.show_one()
            self.show_one()
            answer, header = self.relay_one(inbox)
            self.assertEqual(answer.header.stamp, header.stamp)
        change('/camera_relay', rate=0.0)
        for _ in range(3):
            answer, header = self.relay_one(inbox)
            self.assertEqual(answer.header.stamp, header.stamp)


if __name__ == '__main__':
    rospy.init_node('camera_relay_test')
    rostest.rosrun('unit5', 'camera_relay_test', Relay)
