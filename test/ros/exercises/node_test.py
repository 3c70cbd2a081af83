#!/usr/bin/env python3
"""What all exercises' nodes have in common: subscriptions, encodings, and explanations of errors."""
import cv2
import numpy as np
import rospy
import rostest
from aruco_node.messages.images import frame_from_compressed, frame_from_image, image_from_frame
from cv_bridge import CvBridge
from rig.nodes.case import CAMERA, NodeTest, scene
from rosgraph import Master
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header, String


class Node(NodeTest):
    def test_it_subscribes_only_while_it_has_a_subscriber(self):
        publisher, connections = self.camera()
        node = self.start('exercise5_6.py')
        node.wait_for('Ready', CAMERA, '/exercise5_6/image')
        node.wait_for('Nobody listens to /exercise5_6/image', 'rosrun image_view')
        self.assertEqual(connections.count, 0)
        inbox = self.listen('/exercise5_6/image/compressed', CompressedImage)
        connections.wait(1)
        header = Header(stamp=rospy.Time(12, 34), frame_id='some/eye')
        frame = scene()
        publisher.publish(CvBridge().cv2_to_imgmsg(frame, 'bgr8', header))
        answer = inbox.next()
        self.assertEqual((answer.header.stamp, answer.header.frame_id), (header.stamp, 'some/eye'))
        painted = frame_from_compressed(answer)
        self.assertLess(painted[130:350, 170:200].mean(), 60)  # space beside the Earth
        self.assertLess(np.abs(painted[:60].astype(int) - frame[:60]).max(), 10)
        inbox.subscriber.unregister()
        connections.wait(0)

    def test_every_encoding_is_accepted_and_bgr8_is_published(self):
        publisher, connections = self.camera()
        self.start('exercise5_5.py')
        inbox = self.listen('/exercise5_5/image')
        connections.wait(1)
        frame, bridge = scene(), CvBridge()
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        packed = np.dstack([np.full_like(gray, 128), np.uint8(gray * (219 / 255) + 16)])
        images = {'bgr8': frame, 'rgb8': frame, 'bgra8': cv2.cvtColor(frame, cv2.COLOR_BGR2BGRA),
                  'rgba8': cv2.cvtColor(frame, cv2.COLOR_BGR2BGRA), 'mono8': gray,
                  'mono16': gray.astype(np.uint16) * 257, 'yuv422': packed}
        images.update({'bayer_%s8' % order: gray for order in ('rggb', 'bggr', 'grbg', 'gbrg')})
        for encoding, pixels in images.items():
            message = bridge.cv2_to_imgmsg(pixels)
            message.encoding = encoding
            publisher.publish(message)
            answer = inbox.next()
            self.assertEqual(answer.encoding, 'bgr8', encoding)
            cut = frame_from_image(answer)
            self.assertFalse(cut[125:355, 165:475].any(), encoding)
            self.assertTrue(cut[:60].all(), encoding)

    def test_bad_frames_are_explained_once_and_the_next_good_one_is_answered(self):
        publisher, connections = self.camera()
        node = self.start('exercise5_4.py')
        inbox = self.listen('/exercise5_4/image')
        connections.wait(1)
        good = CvBridge().cv2_to_imgmsg(scene(), 'bgr8')
        bad = {'0 x 0': Image(),
               '5 bytes': Image(height=480, width=640, step=1920, encoding='bgr8', data=b'short'),
               '32FC1': Image(height=1, width=1, step=4, encoding='32FC1', data=b'1234'),
               'step of 1 bytes': Image(height=1, width=9, step=1, encoding='mono8', data=b'1')}
        for _ in range(5):
            for words, message in bad.items():
                publisher.publish(message)
                node.wait_for(words)
                publisher.publish(good)
                self.assertEqual(inbox.next().width, 640)
        self.assertTrue(inbox.empty())
        for words in bad:
            self.assertEqual(len([line for line in node.lines if words in line]), 1, words)

    def test_two_cameras_on_one_topic_do_not_disturb_the_node(self):
        publisher, connections = self.camera()
        self.start('wall_camera.py', '_rate:=100')
        node = self.start('tag_poses.py')
        answers = self.listen('/tag_poses/image')
        connections.wait(1)
        small, sizes = cv2.resize(scene(), (320, 240)), set()
        for _ in range(300):
            publisher.publish(image_from_frame(small, Header(stamp=rospy.Time.now())))
            sizes.add(answers.next().width)
        self.assertEqual(sizes, {320, 640})
        self.assertFalse([line for line in node.lines if 'Traceback' in line], node.lines)

    def test_a_compressed_camera_and_a_scale(self):
        publisher, connections = self.camera(CAMERA + '/compressed', CompressedImage)
        node = self.start('exercise5_5.py', '_transport:=compressed', '_scale:=0.5')
        node.wait_for('~transport is now named ~image_transport')
        inbox = self.listen('/exercise5_5/mask')
        connections.wait(1)
        frame = scene()
        for kind in ('.png', '.jpg'):
            publisher.publish(CompressedImage(data=b'broken'))
            publisher.publish(CompressedImage(format=kind, data=cv2.imencode(kind, frame)[1].tobytes()))
            mask = frame_from_image(inbox.next())
            self.assertEqual(mask.shape, (240, 320, 3))
            self.assertTrue(np.all(mask[64:176, 84:236] == 255) and not mask[:55].any())

    def test_only_the_requested_ids_count(self):
        publisher, connections = self.camera()
        self.start('exercise5_4.py', '_ids:=[1,2,3,9]')
        inbox = self.listen('/exercise5_4/image')
        connections.wait(1)
        frame = scene()
        publisher.publish(CvBridge().cv2_to_imgmsg(frame, 'bgr8'))
        np.testing.assert_array_equal(frame_from_image(inbox.next()), frame)

    def test_namespaces_and_remapping_work(self):
        publisher, connections = self.camera('/robot/camera/rgb/image_raw')
        other, others = self.camera('/usb/image')
        self.start('exercise5_2.py', '__ns:=/robot')
        self.start('exercise5_3.py', 'camera/rgb/image_raw:=/usb/image')
        inboxes = [self.listen('/robot/exercise5_2/image'), self.listen('/exercise5_3/image')]
        for source, seen, inbox in zip((publisher, other), (connections, others), inboxes):
            seen.wait(1)
            source.publish(CvBridge().cv2_to_imgmsg(scene(), 'bgr8'))
            self.assertEqual(inbox.next().height, 480)

    def test_a_camera_that_is_only_compressed_is_found(self):
        publisher, connections = self.camera(CAMERA + '/compressed', CompressedImage)
        node = self.start('exercise5_4.py')
        inbox = self.listen('/exercise5_4/image')
        node.wait_for('Only the compressed frames of ' + CAMERA, 'are used')
        connections.wait(1)
        publisher.publish(CompressedImage(data=cv2.imencode('.png', scene())[1].tobytes()))
        self.assertEqual(inbox.next().width, 640)
        publisher.unregister()
        publisher, connections = self.camera()
        node.wait_for('Only the raw frames of ' + CAMERA)
        connections.wait(1)
        publisher.publish(CvBridge().cv2_to_imgmsg(scene(), 'bgr8'))
        self.assertEqual(inbox.next().height, 480)

    def test_tags_that_nobody_looks_for_are_named(self):
        publisher, connections = self.camera()
        node = self.start('exercise5_6.py', '_dictionary:=DICT_4X4_50')
        self.listen('/exercise5_6/image')
        connections.wait(1)
        frame = image_from_frame(scene(), Header())
        timer = rospy.Timer(rospy.Duration(0.1), lambda _: publisher.publish(frame))
        self.addCleanup(timer.shutdown)
        node.wait_for('4 tags of DICT_6X6_50 (1, 2, 3, 4) are in sight', 'Give dictionary:=DICT_6X6_50')

    def test_a_misspelled_parameter_is_named(self):
        node = self.start('exercise5_2.py', '_dictionnary:=DICT_4X4_50')
        node.wait_for('This node has no parameter ~dictionnary', 'Did you mean ~dictionary?')

    def test_missing_frames_are_explained(self):
        node = self.start('exercise5_2.py', '_image_transport:=raw')
        self.listen('/exercise5_2/image')
        node.wait_for('Waiting for frames on ' + CAMERA, 'nothing publishes it')
        publisher, _ = self.camera(CAMERA + '/compressed', CompressedImage)
        node.wait_for('only its compressed form', 'transport:=compressed')
        publisher.unregister()
        wrong = rospy.Publisher(CAMERA, String, queue_size=1)
        node.wait_for('published as std_msgs/String', 'must be sensor_msgs/Image')
        wrong.unregister()
        publisher, connections = self.camera()
        node.wait_for('has a publisher, but nothing arrives')
        connections.wait(1)
        publisher.publish(CvBridge().cv2_to_imgmsg(scene(), 'bgr8'))
        node.wait_for('Frames arrive')

    def test_a_wrong_parameter_ends_the_node_with_a_sentence(self):
        for name, argument, words in (
                ('exercise5_2.py', '_dictionary:=DICT_6X6_260', ['~dictionary', 'DICT_6X6_260', 'DICT_4X4_50']),
                ('exercise5_3.py', '_ids:=[1,2]', ['~ids', '[1, 2]', 'four different tags']),
                ('exercise5_4.py', '_scale:=0', ['~scale', '0', 'a number from 0.01 to 4']),
                ('exercise5_5.py', '_image_transport:=theora',
                 ['~image_transport', 'theora', 'raw, compressed']),
                ('exercise5_6.py', '_picture:=/no/picture.jpg', ['/no/picture.jpg', 'not a file']),
                ('wall_camera.py', '_noise:=much', ['~noise', 'much', 'a number from 0 to 100']),
                ('wall_camera.py', '_wall:=/no/wall.yaml', ['/no/wall.yaml', 'cannot be read'])):
            self.forget_parameters()
            node = self.start(name, argument)
            self.assertEqual(node.ends(), 1, name)
            node.wait_for(*words)
            self.assertFalse(any('Traceback' in line for line in node.lines), node.lines)
            self.assertFalse([topic for topic, nodes in Master('/test').getSystemState()[0]
                              if '/' + name.replace('.py', '') in nodes])


if __name__ == '__main__':
    rospy.init_node('node_test')
    rostest.rosrun('unit5', 'node_test', Node)
