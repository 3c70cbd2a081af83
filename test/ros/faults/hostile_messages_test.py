#!/usr/bin/env python3
"""Messages that crash or mislead other packages, and some of the messages that script/torture sends."""
import threading

import cv2
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
from geometry_msgs.msg import PoseWithCovarianceStamped
from hostile.messages.camera_messages import Garbage, Hostile, jpeg_of_size
from hostile.messages.paced_publisher import PacedPublisher
from rig.nodes.case import BLANK, CAMERA, CENTERS, NodeTest, scene
from rig.nodes.topics import Connections, until
from rig.page.server import ask, free_port
from rosgraph import Master
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from unit5.msg import TagPoseArray

IDS = sorted(CENTERS)
LINES = 20  # a node may log at most this many lines about all hostile messages
MESSAGES = 500  # of each type


class HostileMessages(NodeTest):
    def start_with_calibrated_camera(self, **changes):
        """Start tag_poses, and wait until it answers a frame with poses. ``changes``: to the CameraInfo."""
        self.infos = rospy.Publisher('/camera/rgb/camera_info', CameraInfo, latch=True, queue_size=1)
        self.running.append(self.infos)
        self.publish_info(**changes)
        self.start_with_camera('tag_poses', poses=TagPoseArray)
        until(self.gives_poses)  # those of a frame may arrive later than its tags

    def publish_info(self, **changes):
        info = camera_info(Camera(), Header())
        for name, value in changes.items():
            setattr(info, name, value)
        self.infos.publish(info)

    def gives_poses(self):
        """Whether the tags of a frame get poses; these must be finite."""
        self.answer_to(scene(), 'tags')
        posed = [message.tags for message in self.received('poses')]
        for tags in posed:
            for tag in tags:
                place = tag.pose.pose.position
                self.assertTrue(np.all(np.isfinite([place.x, place.y, place.z])))
        return bool(posed)

    def received(self, topic):
        """The messages on a topic since the last call."""
        inbox, messages = self._inboxes[topic], []
        while not inbox.empty():
            messages.append(inbox.get())
        return messages

    def logged(self, *words):
        return [line for line in self.node.lines if all(word in line for word in words)]

    def test_an_empty_image_does_not_end_the_node(self):
        """It aborts aruco_ros and apriltag_ros."""
        self.start_with_camera('tag_poses')
        for _ in range(3):
            self.publisher.publish(Image(encoding='rgb8'))  # one of bgr8 may be the end of a video
            self.node.wait_for('0 x 0 pixels is empty')
            self.assertEqual(self.ids_seen(scene()), IDS)
        self.assertEqual(len(self.logged('0 x 0 pixels is empty')), 1)

    def test_an_empty_list_of_coefficients_is_accepted(self):
        """It crashes aruco_detect. A camera without distortion may have an empty list."""
        self.start_with_calibrated_camera(D=[])

    def test_all_five_coefficients_are_used(self):
        """aruco_ros ignores all of them if there are five."""
        self.start_with_calibrated_camera()
        straight = self.answer_to(scene(), 'poses')[0].tags
        self.publish_info(D=[-0.3, 0.1, 0.0, 0.0, 0.02])

        def bent():
            tags = self.answer_to(scene(), 'poses')[0].tags
            return abs(tags[0].pose.pose.position.x - straight[0].pose.pose.position.x) > 0.005
        until(bent)

    def test_the_node_recovers_from_a_calibration_of_zeros(self):
        """aruco_ros publishes NaN, and ar_track_alvar never recovers."""
        self.start_with_calibrated_camera()
        self.publish_info(K=[0.0] * 9)
        until(lambda: self.answer_to(scene(), 'tags') and self.logged('K is not a camera matrix'))
        self.received('poses')
        self.assertEqual(self.ids_seen(scene()), IDS)
        self.assertFalse(self.received('poses'))
        self.publish_info()
        until(self.gives_poses)

    def test_yuv422_is_decoded(self):
        """It aborts apriltag_ros."""
        self.start_with_camera('exercise5_2')
        gray = np.uint8(cv2.cvtColor(scene(), cv2.COLOR_BGR2GRAY) * (219 / 255) + 16)
        pair = [np.full_like(gray, 128), gray]
        for encoding, order in (('yuv422', pair), ('yuv422_yuy2', pair[::-1])):
            answer, ids = self.see_image(np.dstack(order), encoding)
            self.assertEqual(ids, IDS)
            self.assertLess(abs(int(answer[5, 5].mean()) - 180), 3)

    def test_16_bit_images_are_scaled_and_floats_are_refused(self):
        """apriltag_ros reads both as 8 bits, without a warning."""
        self.start_with_camera('exercise5_2')
        gray = np.uint16(cv2.cvtColor(scene(), cv2.COLOR_BGR2GRAY)) * 257
        for big in (0, 1):
            answer, ids = self.see_image(gray.byteswap() if big else gray, 'mono16', big)
            self.assertEqual(ids, IDS)
            np.testing.assert_array_equal(answer[:60], scene()[:60])
        floats = np.float32(gray)
        floats[::2] = np.nan
        for _ in range(3):
            self.publish_image(floats, '32FC1')
            self.node.wait_for('32FC1')
            self.assertEqual(self.ids_seen(scene()), IDS)
        self.assertEqual(len(self.logged('encoding "32FC1" cannot be used. Set the camera driver')), 1)

    def test_without_subscribers_it_unsubscribes_from_the_camera(self):
        """aruco_detect continues to compute."""
        self.start_with_camera('exercise5_6')
        self.connections.wait(1)
        for inbox in self._inboxes.values():
            inbox.subscriber.unregister()
        self.connections.wait(0)

    def test_an_impossible_stamp_harms_neither_the_node_nor_listeners_of_tf(self):
        """tf2 computes a time beyond 32 bits from it and throws. It also logs a line for a repeated stamp."""
        self.start_with_calibrated_camera()
        # With a subscriber to this topic, the node itself subscribes to /tf.
        self.listen('/tag_poses/robot_pose', PoseWithCovarianceStamped)
        until(lambda: [topic for topic, nodes in Master('/test').getSystemState()[1]
                       if topic == '/tf' and '/tag_poses' in nodes])
        frames = self.listen('/tf', TFMessage)
        wrong = rospy.Time()
        wrong.secs = 2**32 - 1
        for stamp in (rospy.Time(2**31), rospy.Time(50)):
            self.show(scene(), wrong)
            self.node.wait_for('not a possible time. Check the clock')
            self.answer_to(scene(), 'tags', stamp=stamp)
        self.assertEqual(self.ids_seen(scene()), IDS)
        self.assertEqual(len(self.logged('not a possible time')), 1)
        for _ in range(5):
            self.answer_to(scene(), 'tags', stamp=rospy.Time(2000))
        self.answer_to(scene(), 'tags', stamp=rospy.Time(2001))
        stamps = []
        while 2001 not in stamps:
            stamps.append(frames.next().transforms[0].header.stamp.to_sec())
        self.assertEqual(len(stamps), len(set(stamps)), stamps)
        self.assertNotIn(2**32 - 1, stamps)
        self.assertFalse(self.logged('TF_REPEATED_DATA'))

    def test_a_stamp_with_more_than_a_second_of_nanoseconds_is_used_in_canonical_form(self):
        self.start_with_camera('exercise5_2')
        stamp = rospy.Time(2000)
        stamp.nsecs = 1500000000
        self.show(scene(), stamp)
        while True:
            message = self._inboxes['tags'].next()
            if message.header.stamp.secs >= 2000:
                break
        self.assertEqual((message.header.stamp.secs, message.header.stamp.nsecs, len(message.tags)),
                         (2001, 500000000, 4))

    def test_frames_without_stamps_have_their_time_of_arrival_in_tf(self):
        self.start_with_calibrated_camera()
        frames = self.listen('/tf', TFMessage)
        began = rospy.Time.now()

        def framed():
            self.show(scene(), rospy.Time())
            return not frames.empty()
        until(framed)
        self.assertGreaterEqual(frames.next().transforms[0].header.stamp, began)

    def test_unreadable_messages_are_reported_once_and_the_next_one_is_answered(self):
        """rospy itself would try to read them again and again, and never get to another."""
        self.start_with_camera('exercise5_2')
        for data in (b'', b'x' * 7, b'\xff' * 100, bytes(12) + b'\xff' * 4):
            self.publisher.publish(Garbage(Image, data))
            self.node.wait_for('cannot be read')
            self.assertEqual(self.ids_seen(scene()), IDS)
        self.assertEqual(len(self.logged('cannot be read')), 1)
        self.assertLess(len(self.node.lines), LINES)

    def test_the_next_good_frame_after_many_hostile_messages_is_answered_as_before(self):
        for transport, kind in (('raw', Image), ('compressed', CompressedImage)):
            self.send_hostile_messages(transport, kind)
            self.tearDown()
            self.setUp()

    def send_hostile_messages(self, transport, kind):
        topic = CAMERA + ('/compressed' if kind is CompressedImage else '')
        connections = Connections()
        publisher = PacedPublisher(topic, kind, connections)
        self.running.append(publisher)
        encode = compressed_from_frame if kind is CompressedImage else image_from_frame
        port = free_port()
        self.node = self.start('exercise5_6.py', '_image_transport:=' + transport, '_picture:=topic:' + topic)
        page = self.start('page.py', '_port:=%d' % port)
        answers = self.listen('/exercise5_6/image')
        page.wait_for('The page is at')
        watching = threading.Event()

        def snapshot():
            return ask(port, '/snapshot?topic=%s' % CAMERA)

        def good():
            """The node's answer to a good frame that is sent twice, so that one is painted into the other."""
            for number, frame in enumerate((BLANK[:9, :9], scene(), scene())):
                stamp = rospy.Time(1000 + number)

                def answered():
                    publisher.publish(encode(frame, Header(stamp=stamp)))
                    message = answers.next()
                    while message.header.stamp != stamp and not answers.empty():
                        message = answers.next()
                    return message if message.header.stamp == stamp else None
                message = until(answered)
            return frame_from_image(message)

        def look():
            while not watching.is_set():
                snapshot()
        connections.wait(1)
        before = good()
        looking = threading.Thread(target=look)
        looking.start()
        hostile = Hostile(1, [scene()])
        make = hostile.compressed if kind is CompressedImage else hostile.image
        for _ in range(MESSAGES):
            publisher.publish(make())
        after = good()
        watching.set()
        looking.join()
        np.testing.assert_array_equal(after, before)

        def snapshot_of(message):
            """(status, body) of the page's snapshot of a message."""
            shown = []
            threading.Thread(target=lambda: shown.append(snapshot())).start()
            until(lambda: publisher.publish(message) or shown)
            return shown[0][0], shown[0][2]
        picture = frame_from_compressed(CompressedImage(data=snapshot_of(encode(scene(), Header()))[1]))
        self.assertLess(np.abs(picture.astype(int) - scene()).mean(), 3)
        large = Image(width=65000, height=65000, encoding='bgr8') if kind is Image else \
            CompressedImage(data=jpeg_of_size(encode(scene(), Header()).data, 65000, 65000))
        status, sentence = snapshot_of(large)  # no browser should get this
        self.assertEqual(status, 503)
        self.assertIn(b'is too large' if kind is Image else b'compressed frame', sentence)
        for node in (self.node, page):
            self.assertIsNone(node.process.poll())
            self.assertLess(len(node.lines), LINES, node.lines)
            self.assertFalse([line for line in node.lines if 'Traceback' in line or 'fault of' in line])

    def publish_image(self, pixels, encoding, big=0):
        stamp = rospy.Time(next(self._seconds))
        self.publisher.publish(Image(header=Header(stamp=stamp), height=480, width=640, encoding=encoding,
                                     is_bigendian=big, step=pixels.strides[0], data=pixels.tobytes()))
        return stamp

    def see_image(self, pixels, encoding, big=0):
        """(image, sorted ids): the node's answers to an Image with these pixels."""
        stamp, found = self.publish_image(pixels, encoding, big), []
        for topic in 'image', 'tags':
            found.append(self._inboxes[topic].next())
            while found[-1].header.stamp != stamp:
                found[-1] = self._inboxes[topic].next()
        return frame_from_image(found[0]), sorted(tag.id for tag in found[1].tags)


if __name__ == '__main__':
    rospy.init_node('hostile_messages_test')
    rostest.rosrun('unit5', 'hostile_messages_test', HostileMessages)
