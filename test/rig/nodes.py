"""What the rostests that start nodes share: a camera of their own, nodes before it, and what they answer."""
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

from rig import started
from rig.listening import Connections, Inbox, until
from rig.serving import free_port
from rig.started import WAIT_S

CAMERA = '/camera/rgb/image_raw'
NODES = [*('exercise5_%d' % number for number in range(2, 7)), 'tag_poses', 'camera_relay', 'wall_camera',
         'page']
IMAGES = {name: '/%s/image' % name for name in NODES[:-3]}  # that the nodes before a camera make
IMAGES['camera_relay'] = '/camera_relay/image_raw'
CENTERS = {1: (160, 120), 2: (480, 120), 3: (480, 360), 4: (160, 360)}
GRAY = 180
KINDS = {str: ('strs', StrParameter), float: ('doubles', DoubleParameter), int: ('ints', IntParameter),
         bool: ('bools', BoolParameter)}
BLANK = np.full((480, 640, 3), GRAY, np.uint8)
INSIDE, OUTSIDE = (slice(180, 300), slice(220, 420)), (slice(0, 60), slice(0, 640))  # of the area


def scene(ids=None, dictionary='DICT_6X6_250', narrow=(), centers=CENTERS, side=80):
    """Tags on gray, a frame (480, 640, 3) uint8: those of ``ids``, or all of ``centers``, {id: (x, y)}.

    Tags are ``side`` pixels wide, ``narrow`` ones 32; with their margins a quarter more.
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
    """Starts nodes, shows them frames, and takes all away again."""

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
        for name in rospy.get_param_names():  # what _name:=value set outlives the node
            if name.startswith(tuple('/%s/' % node for node in NODES)):
                rospy.delete_param(name)

    def start(self, name, *arguments):
        self.running.append(started.node(name, *arguments))
        return self.running[-1]

    def start_all(self, names=NODES):
        """Nodes by their names, ready."""
        port = free_port()
        nodes = {name: self.start(name + '.py', *['_port:=%d' % port] * (name == 'page')) for name in names}
        for name in names:
            rospy.wait_for_service('/%s/set_parameters' % name, WAIT_S)
        return nodes

    def camera(self, topic=CAMERA, kind=Image):
        """(publisher, connections) of a camera without a picture yet."""
        connections = Connections()
        publisher = rospy.Publisher(topic, kind, connections, queue_size=10)
        self.running.append(publisher)
        return publisher, connections

    def listen(self, topic, kind=Image):
        inbox = Inbox(topic, kind)
        self.running.append(inbox.subscriber)
        return inbox

    def calibrate(self):
        """Publish the camera_info of a camera without distortion."""
        publisher = rospy.Publisher('/camera/rgb/camera_info', CameraInfo, latch=True, queue_size=1)
        self.running.append(publisher)
        publisher.publish(camera_info(Camera(), Header()))

    def before_camera(self, name, *arguments, topics=('image',), **others):
        """Start a node before a camera and listen to its images and ~tags, and to ``others``: {topic: type}."""
        self.publisher, self.connections = self.camera()
        self.node = self.start(name + '.py', *arguments)
        kinds = dict(dict.fromkeys(topics, Image), tags=TagArray, **others)
        self.attend({topic: self.listen('/%s/%s' % (name, topic), kind) for topic, kind in kinds.items()})

    def attend(self, inboxes):
        """Have ``see`` answer with what is in these inboxes, by their names, as soon as they get something."""
        self._inboxes = inboxes
        for inbox in inboxes.values():
            while not inbox.empty():  # of before
                inbox.get()
        until(self.publisher.get_num_connections)  # what is shown before is lost
        for inbox in inboxes.values():
            def answered():
                self.show(scene([1]))  # of which nothing is learned
                try:
                    inbox.get(timeout=1.0)  # a busy node that is shown more would drop some
                except queue.Empty:
                    return False
                return True
            until(answered)

    def show(self, frame, stamp=None):
        """Publish a frame; its time, 1/30 s after that of the one before unless another is given."""
        stamp = rospy.Time(next(self._seconds)) if stamp is None else stamp
        self.publisher.publish(image_from_frame(frame, Header(stamp=stamp, frame_id='eye')))
        return stamp

    def see(self, frame, *topics, stamp=None):
        """What the node makes of a frame: on each of these topics, or on ~image."""
        stamp = self.show(frame, stamp)
        answers = []
        for topic in topics or ['image']:
            message = self._inboxes[topic].next()
            while getattr(message, 'header', Header(stamp=stamp)).stamp != stamp:  # an answer to one before
                message = self._inboxes[topic].next()
            answers.append(frame_from_image(message) if isinstance(message, Image) else message)
        return answers if topics else answers[0]

    def sees(self, frame):
        """The sorted ids of the tags that the node sees in a frame."""
        return sorted(tag.id for tag in self.see(frame, 'tags')[0].tags)

    def assert_painted(self, image, frame):
        """The area, and it alone, is another than in the frame."""
        self.assertGreater(np.any(image != frame, axis=2)[INSIDE].mean(), 0.99)
        np.testing.assert_array_equal(image[OUTSIDE], frame[OUTSIDE])


def picture_file(folder, name, pixels):
    """The path of a picture, written there."""
    path = '%s/%s' % (folder, name)
    cv2.imwrite(path, pixels)
    return path


def change(node, **values):
    """Set parameters of a node, of whatever type; {name: value} of all that it then has."""
    config = Config()
    for name, value in values.items():
        fields, kind = KINDS[type(value)]
        getattr(config, fields).append(kind(name, value))
    rospy.wait_for_service(node + '/set_parameters', WAIT_S)
    answer = rospy.ServiceProxy(node + '/set_parameters', Reconfigure)(config).config
    return {item.name: item.value for fields, _ in KINDS.values() for item in getattr(answer, fields)}
