"""The base of the rostests that start nodes: it has a camera, starts nodes, and collects their answers."""
import queue
import unittest
from itertools import count

import cv2
import numpy as np
import rospy
from aruco_ar import draw_tag
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import frame_from_image, image_from_frame
from aruco_node.messages.wall_messages import camera_info
from dynamic_reconfigure.msg import BoolParameter, Config, DoubleParameter, IntParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header
from unit5.msg import TagArray

from rig.nodes.topics import Connections, Inbox, until
from rig.page.server import free_port
from rig.processes import started
from rig.processes.started import WAIT_S

CAMERA = '/camera/rgb/image_raw'
NODES = [*('exercise5_%d' % number for number in range(2, 7)), 'tag_poses', 'calibrate_live',
         'camera_relay', 'wall_camera', 'page']
IMAGES = {name: '/%s/image' % name for name in NODES[:-3]}  # the nodes that answer frames with images
IMAGES['camera_relay'] = '/camera_relay/image_raw'
CENTERS = {1: (160, 120), 2: (480, 120), 3: (480, 360), 4: (160, 360)}
GRAY = 180
KINDS = {str: ('strs', StrParameter), float: ('doubles', DoubleParameter), int: ('ints', IntParameter),
         bool: ('bools', BoolParameter)}
BLANK = np.full((480, 640, 3), GRAY, np.uint8)
INSIDE, OUTSIDE = (slice(180, 300), slice(220, 420)), (slice(0, 60), slice(0, 640))  # of the area


def scene(ids=None, dictionary='DICT_6X6_250', narrow=(), centers=CENTERS, side=80):
    """A frame, (480, 640, 3) uint8, with tags on gray: those of ``ids``, or all of ``centers``, {id: (x, y)}.

    Tags are ``side`` pixels wide, and those in ``narrow`` 32 pixels. Their white margins add a quarter to that.
    """
    frame = BLANK.copy()
    for tag_id in centers if ids is None else ids:
        half = 20 if tag_id in narrow else 5 * side // 8
        tag = draw_tag(dictionary, tag_id, side, quiet=1)
        x, y = centers[tag_id]
        frame[y - half:y + half, x - half:x + half] = \
            cv2.resize(tag, (2 * half, 2 * half), interpolation=cv2.INTER_AREA)[..., None]
    return frame


class NodeTest(unittest.TestCase):
    """Starts nodes, shows them frames, and removes everything afterward."""

    def setUp(self):
        self.running, self._inboxes = [], {}
        self._seconds = (100 + number / 30 for number in count())

    def tearDown(self):
        started.stop_all([item for item in self.running if isinstance(item, started.Started)])
        for item in self.running:
            if not isinstance(item, started.Started):
                item.unregister()
        self.forget_parameters()

    def forget_parameters(self):
        for name in rospy.get_param_names():  # what _name:=value sets outlives the node
            if name.startswith(tuple('/%s/' % node for node in NODES)):
                rospy.delete_param(name)

    def start(self, name, *arguments):
        self.running.append(started.node(name, *arguments))
        return self.running[-1]

    def start_all(self, names=NODES):
        """Start nodes and wait until they are ready; returns {name: Started}."""
        port = free_port()
        nodes = {name: self.start(name + '.py', *['_port:=%d' % port] * (name == 'page')) for name in names}
        for name in names:
            rospy.wait_for_service('/%s/set_parameters' % name, WAIT_S)
        if 'page' in nodes:
            nodes['page'].wait_for('The page is at')
        return nodes

    def camera(self, topic=CAMERA, kind=Image):
        """(publisher, connections) of a camera that has not shown a frame yet."""
        connections = Connections()
        publisher = rospy.Publisher(topic, kind, connections, queue_size=10)
        self.running.append(publisher)
        return publisher, connections

    def listen(self, topic, kind=Image):
        inbox = Inbox(topic, kind)
        self.running.append(inbox.subscriber)
        return inbox

    def publish_camera_info(self):
        """Publish the camera_info of a camera without distortion."""
        publisher = rospy.Publisher('/camera/rgb/camera_info', CameraInfo, latch=True, queue_size=1)
        self.running.append(publisher)
        publisher.publish(camera_info(Camera(), Header()))

    def start_with_camera(self, name, *arguments, topics=('image',), **others):
        """Start a node in front of a camera; subscribe to its images, ~tags and ``others``, {topic: type}."""
        self.publisher, self.connections = self.camera()
        self.node = self.start(name + '.py', *arguments)
        kinds = dict(dict.fromkeys(topics, Image), tags=TagArray, **others)
        self.use_inboxes({topic: self.listen('/%s/%s' % (name, topic), kind) for topic, kind in kinds.items()})

    def use_inboxes(self, inboxes):
        """Let answer_to take the answers from these inboxes, {name: Inbox}, and wait until each gets some."""
        self._inboxes = inboxes
        for inbox in inboxes.values():
            while not inbox.empty():  # discard what came before
                inbox.get()
        until(self.publisher.get_num_connections)  # frames that are published earlier are lost
        for inbox in inboxes.values():
            def answered():
                self.show(scene([1]))  # nothing can be learned from it
                try:
                    inbox.get(timeout=1.0)  # a busy node would drop frames if it were shown more
                except queue.Empty:
                    return False
                return True
            until(answered)

    def show(self, frame, stamp=None):
        """Publish a frame; returns its stamp, by default 1/30 s after that of the frame before."""
        stamp = rospy.Time(next(self._seconds)) if stamp is None else stamp
        self.publisher.publish(image_from_frame(frame, Header(stamp=stamp, frame_id='eye')))
        return stamp

    def answer_to(self, frame, *topics, stamp=None):
        """The node's answers to a frame on these topics, or that on ~image."""
        stamp = self.show(frame, stamp)
        answers = []
        for topic in topics or ['image']:
            message = self._inboxes[topic].next()
            while getattr(message, 'header', Header(stamp=stamp)).stamp != stamp:  # an earlier answer
                message = self._inboxes[topic].next()
            answers.append(frame_from_image(message) if isinstance(message, Image) else message)
        return answers if topics else answers[0]

    def ids_seen(self, frame):
        """The sorted ids of the tags that the node finds in a frame."""
        return sorted(tag.id for tag in self.answer_to(frame, 'tags')[0].tags)

    def assert_painted(self, image, frame):
        """Assert that the image differs from the frame in the area, and only there."""
        self.assertGreater(np.any(image != frame, axis=2)[INSIDE].mean(), 0.99)
        np.testing.assert_array_equal(image[OUTSIDE], frame[OUTSIDE])


def picture_file(folder, name, pixels):
    """Write a picture into a folder; returns its path."""
    path = '%s/%s' % (folder, name)
    cv2.imwrite(path, pixels)
    return path


def change(node, **values):
    """Set parameters of a node, of any type; returns {name: value} of all its parameters afterward."""
    config = Config()
    for name, value in values.items():
        fields, kind = KINDS[type(value)]
        getattr(config, fields).append(kind(name, value))
    rospy.wait_for_service(node + '/set_parameters', WAIT_S)
    answer = rospy.ServiceProxy(node + '/set_parameters', Reconfigure)(config).config
    return {item.name: item.value for fields, _ in KINDS.values() for item in getattr(answer, fields)}
