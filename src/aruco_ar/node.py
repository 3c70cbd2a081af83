"""The ROS node around an exercise: parameters, topics, and everything that can go wrong."""
import sys
import threading
import time
import traceback

import cv2
import rospkg
import rospy
from sensor_msgs.msg import CompressedImage, Image

from .detector import Detector
from .errors import InputError
from .memory import keep_memory
from .messages import TRANSPORTS, compressed_from_frame, image_from_frame
from .picture import load_picture, resize
from .settings import picture_path, read_settings
from .tracker import Tracker
from .waiting import explain_silence

CAMERA = 'camera/rgb/image_raw'
SILENCE_S = 5.0

# rospy drops stale messages only within what one read of the socket returned,
# so a read must have room for more than the largest frame: here one of 4K in
# 16 bits and three colors, with some to spare.
BUFFER_BYTES = 64 * 1024 * 1024


def run(name, step, takes=('tags',), topics=('image',)):
    """Run an exercise as a node until ROS shuts down.

    For each frame ``step`` is called with the frame, (h, w, 3) BGR uint8,
    which is its own to write into, and with what it ``takes``, in that order:
    ``tags``, a list of Tag; ``area``, the Area that the tags in this frame and
    before it show, or None (see Tracker); ``picture``, what the parameter
    ~picture names. It returns the image to publish as ~image or, with several
    ``topics``, one for each of them in that order. ``step`` is called only
    while somebody listens, and only with the newest frame.
    """
    run_node(name, lambda: _ImageNode(step, takes, topics).spin())


def run_node(name, work):
    """Start a node, call ``work``, which goes on until ROS shuts down, and end the process.

    Where ``work`` raises InputError, its sentence is logged and the exit code is 1.
    """
    sys.stdout.reconfigure(line_buffering=True)  # else a log that is no terminal comes late
    keep_memory()
    rospy.init_node(name)
    # A frame takes a few milliseconds: threads would add more work than they save time.
    cv2.setNumThreads(1)
    errors = []

    def guarded():
        try:
            work()
        except InputError as error:
            errors.append(error)
            rospy.logfatal('%s', error)
            rospy.signal_shutdown(str(error))
        except Exception:
            errors.append(traceback.format_exc())
            rospy.logfatal('%s', errors[0])
            rospy.signal_shutdown('a fault of this node')
    # Not in the main thread: there rospy handles Ctrl-C by talking to the
    # master, and if that thread is talking to it already, waits for itself.
    worker = threading.Thread(target=guarded, daemon=True)
    worker.start()
    rospy.spin()
    worker.join(2.0)
    sys.exit(1 if errors else 0)


def package_folder():
    """Where launch/, images/ and Tags/ are: the source folder, or share/unit5 once installed."""
    return rospkg.RosPack().get_path('unit5')


def parameter(name, default):
    """The value of a private parameter."""
    return rospy.get_param('~' + name, default)


class ImagePublisher:
    """An image topic, raw and JPEG, each made only while somebody listens to it."""

    def __init__(self, topic, on_listeners=None, encoding='bgr8'):
        """``on_listeners`` is called, from any thread, when somebody comes or goes."""
        self._encoding = encoding
        listener = _Listener(on_listeners) if on_listeners else None
        self.name = rospy.resolve_name(topic)
        self._raw = rospy.Publisher(topic, Image, listener, queue_size=1)
        self._compressed = rospy.Publisher(topic + '/compressed', CompressedImage, listener,
                                           queue_size=1)

    def has_listeners(self):
        """Whether anybody listens to one of the two."""
        return self._raw.get_num_connections() + self._compressed.get_num_connections() > 0

    def publish(self, frame, header):
        """Publish a frame, (h, w, 3) BGR uint8, to whom listens."""
        if self._raw.get_num_connections():
            self._raw.publish(image_from_frame(frame, header, self._encoding))
        if self._compressed.get_num_connections():
            self._compressed.publish(compressed_from_frame(frame, header))


class _Listener(rospy.SubscribeListener):
    def __init__(self, on_change):
        super().__init__()
        self._on_change = on_change

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        self._on_change()

    def peer_unsubscribe(self, topic_name, num_peers):
        self._on_change()


class _ImageNode:
    """Calls a step with frames and tags, and publishes what it returns."""

    def __init__(self, step, takes, topics):
        settings = read_settings(parameter)
        self._scale = settings.scale
        self._transport = settings.transport
        self._step = step
        self._given = [self._giver(name, settings) for name in takes]

        self._camera = rospy.resolve_name(CAMERA)
        suffix, self._kind, self._to_frame = TRANSPORTS[self._transport]
        self._topic = self._camera + suffix
        self._subscriber = None
        self._last_sign = time.monotonic()  # of life from the camera
        self._said = set()
        self._waiting = None
        self._wake = threading.Event()
        self._outputs = [ImagePublisher('~' + topic, self._wake.set) for topic in topics]
        rospy.on_shutdown(self._wake.set)
        rospy.loginfo('Ready: %s -> %s', self._topic,
                      ', '.join(output.name for output in self._outputs))

    def _giver(self, name, settings):
        """The function of a frame and its time, seconds, that gives a step what it takes."""
        if name == 'tags':
            detector = Detector(settings.dictionary, settings.ids)
            return lambda frame, stamp: detector.detect(frame)
        if name == 'area':
            return Tracker(settings.dictionary, settings.ids, settings.hold, settings.upright).update
        picture = load_picture(picture_path(parameter('picture', 'images/earth.jpg'), package_folder()))
        return lambda frame, stamp: picture

    def spin(self):
        """Subscribe while somebody listens, and say so when nothing arrives, until shutdown."""
        while not rospy.is_shutdown():
            self._follow_listeners()
            if time.monotonic() - self._last_sign > SILENCE_S:
                self._explain_silence()
            self._wake.wait(1.0)
            self._wake.clear()

    def _follow_listeners(self):
        wanted = any(output.has_listeners() for output in self._outputs)
        if wanted and self._subscriber is None:
            self._last_sign = time.monotonic()
            self._subscriber = rospy.Subscriber(self._topic, self._kind, self._on_message,
                                                queue_size=1, buff_size=BUFFER_BYTES)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def _explain_silence(self):
        """Say why nothing arrives, again only when the reason has become another."""
        self._last_sign = time.monotonic()  # look again after another SILENCE_S
        try:
            published = dict(rospy.get_published_topics())
        except Exception as error:  # the master is away; whatever its client raises
            rospy.logwarn_once('The ROS master does not answer: %s', error)
            return
        own = [output.name for output in self._outputs]
        if self._subscriber is None and published.get(self._topic) == self._kind._type:
            sentence = ('Nobody listens to %s, so nothing is computed. To see it: rosrun image_view '
                        'image_view image:=%s' % (', '.join(own), own[-1]))
            log = rospy.loginfo
        else:
            sentence = explain_silence(self._camera, self._transport, published,
                                       own + [name + '/compressed' for name in own])
            log = rospy.logwarn
        if sentence != self._waiting:
            self._waiting = sentence
            log('%s', sentence)

    def _on_message(self, message):
        self._last_sign = time.monotonic()
        if self._waiting:
            self._waiting = None
            rospy.loginfo('Frames arrive on %s.', self._topic)
        try:
            frame = self._to_frame(message)
            if self._scale != 1.0:
                frame = resize(frame, self._scale)
            stamp = (message.header.stamp or rospy.Time.now()).to_sec()
            images = self._step(frame, *[give(frame, stamp) for give in self._given])
        except InputError as error:
            self._say_once(error.kind, str(error))
            return
        except Exception:  # a fault of ours: one frame is lost, not the node
            fault = traceback.format_exc()
            self._say_once(fault, 'A frame is passed over, by a fault of this node: ' + fault)
            return
        if len(self._outputs) == 1:
            images = [images]
        for output, image in zip(self._outputs, images):
            output.publish(image, message.header)

    def _say_once(self, kind, sentence):
        if kind not in self._said:
            self._said.add(kind)
            rospy.logerr('%s', sentence)
