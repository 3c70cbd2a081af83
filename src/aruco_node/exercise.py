"""The ROS node around an exercise: parameters, topics, and everything that can go wrong."""
import threading
import time
import traceback

import rospy
from aruco_ar.errors import InputError
from aruco_ar.files import package_folder
from aruco_ar.picture import resize
from dynamic_reconfigure.server import Server
from unit5.cfg import PictureConfig
from unit5.msg import TagArray

from .inputs import Inputs
from .memory import keep_memory
from .messages import BUFFER_BYTES, TRANSPORTS, tags_from_pixels
from .node import parameter, run_node
from .publishing import ImagePublisher, Listener
from .settings import load_areas, read_settings
from .waiting import SILENCE_S, explain_silence

CAMERA = 'camera/rgb/image_raw'


def run(name, step, takes=('tags',), topics=('image',)):
    """Run an exercise as a node until ROS shuts down.

    For each frame ``step`` is called with the frame, (h, w, 3) BGR uint8,
    which is its own to write into, and with what it ``takes``, in that order:
    ``tags``, a list of Tag; ``area``, the Area that the tags in this frame and
    before it show, or None (see Tracker); ``picture``, what the parameter
    ~picture shows at that time, or None; ``fit``, ``opacity``, the parameters
    of these names. Where ~areas names several, ``step`` is called for one
    after the other, each time with the image it returned. It returns the image
    to publish as ~image or, with several ``topics``, one for each of them in
    that order. ``step`` is called only while somebody listens, and only with
    the newest frame.
    """
    keep_memory()
    run_node(name, lambda: _ImageNode(step, takes, topics).spin())


class _ImageNode:
    """Calls a step with frames and tags, and publishes what it returns."""

    def __init__(self, step, takes, topics):
        self._step = step
        self._areas = [{}]  # of each area, the parameters that are its own
        areas = parameter('areas', 'none') if 'picture' in takes else 'none'
        if areas != 'none':
            self._areas = load_areas(areas)
        settings = self._read({})
        self._scale = settings[0].scale
        self._transport = settings[0].transport
        self._inputs = [Inputs(takes, of_area, package_folder()) for of_area in settings]

        self._camera = rospy.resolve_name(CAMERA)
        suffix, self._kind, self._to_frame = TRANSPORTS[self._transport]
        self._topic = self._camera + suffix
        self._subscriber = None
        self._last_sign = time.monotonic()  # of life from the camera
        self._said = set()
        self._waiting = None
        self._wake = threading.Event()
        self._outputs = [ImagePublisher('~' + topic, self._wake.set) for topic in topics]
        self._reconfigurer = None
        self._tags = rospy.Publisher('~tags', TagArray, Listener(self._wake.set), queue_size=1)
        if 'picture' in takes:
            self._reconfigurer = Server(PictureConfig, self._reconfigure)
        rospy.on_shutdown(self._wake.set)
        rospy.loginfo('Ready: %s -> %s', self._topic,
                      ', '.join(output.name for output in self._outputs))

    def _read(self, changed):
        """The Settings of each area: its own before what was changed before the node's parameters."""
        def settings(own):
            return read_settings(lambda name, default: own.get(
                name, changed[name] if name in changed else parameter(name, default)))
        return [settings(own) for own in self._areas]

    def _reconfigure(self, config, level):
        """What dynamic_reconfigure calls with what somebody wishes; returns what it becomes."""
        try:
            if all('picture' in own for own in self._areas) and self._reconfigurer is not None \
                    and config['picture'] != self._reconfigurer.config['picture']:
                raise InputError('Each area has a picture of its own, in the file that ~areas names.')
            changes = [inputs.prepare(settings) for inputs, settings in zip(self._inputs, self._read(config))]
        except InputError as error:
            rospy.logerr('%s Nothing is changed.', error)
            return self._reconfigurer.config
        config['opacity'] = float(config['opacity'])  # of opacity:=1 a whole number came
        for change in changes:
            change()
        self._wake.set()
        return config

    def spin(self):
        """Subscribe while somebody listens, and say so when nothing arrives, until shutdown."""
        while not rospy.is_shutdown():
            self._follow_listeners()
            if time.monotonic() - self._last_sign > SILENCE_S:
                self._explain_silence()
            self._wake.wait(1.0)
            self._wake.clear()

    def _follow_listeners(self):
        wanted = self._tags.get_num_connections() > 0 or \
            any(output.has_listeners() for output in self._outputs)
        for inputs in self._inputs:
            inputs.follow(wanted)
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
            sentence = ('Nobody listens to %s, so nothing is computed. To see it: open the page, or rosrun '
                        'image_view image_view image:=%s' % (', '.join(own), own[-1]))
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
            images = frame
            for given in [inputs.at(frame, stamp) for inputs in self._inputs]:
                images = self._step(images, *given)
            self._publish(images, message.header)
        except InputError as error:
            self._say_once(error.kind, str(error))
            return
        except Exception:  # a fault of ours: one frame is lost, not the node
            fault = traceback.format_exc()
            self._say_once(fault, 'A frame is passed over, by a fault of this node: ' + fault)

    def _publish(self, images, header):
        """Publish what the step returned, and the tags that were seen for it."""
        if len(self._outputs) == 1:
            images = [images]
        for output, image in zip(self._outputs, images):
            output.publish(image, header)
        if self._tags.get_num_connections():
            tags = {tag.id: tag.corners for inputs in self._inputs for tag in inputs.tags}
            self._tags.publish(tags_from_pixels(tags.items(), header))

    def _say_once(self, kind, sentence):
        if kind not in self._said:
            self._said.add(kind)
            rospy.logerr('%s', sentence)
