"""A node that looks at a camera's frames: topics, parameters, services, and everything that can go wrong."""
import threading
import time
from typing import Optional, Sequence

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.lateness import Lateness

from aruco_node.health.diagnostics import ERROR, OK, Diagnostics, FrameCount
from aruco_node.health.faults import guarded, note_fault, say_once
from aruco_node.health.silence import SILENCE_S, explain_silence
from aruco_node.health.snapshot import Snapshot
from aruco_node.messages.images import TRANSPORTS
from aruco_node.messages.publishing import ImagePublisher, Listener
from aruco_node.parameters.parameters import read
from aruco_node.parameters.reconfigure import Reconfigurer
from aruco_node.ros_internals.master import is_there, published_topics
from aruco_node.ros_internals.newest import is_more_pending, subscribe_newest
from aruco_node.ros_internals.tf_listener import is_time

from .node import parameter

CAMERA = 'camera/rgb/image_raw'


class FrameNode:
    """Answers the newest frame of the camera, while somebody listens.

    A subclass says by ``look`` what it makes of a frame. ``topics``: of the
    images that it makes. ``kind_of_settings``: the class of its parameters.
    """

    results: Sequence[str] = ()  # names of the topics of more than images, for who asks why nothing comes
    advice = ''  # how to see what the node makes, where it is not for the eye
    ready = True  # whether what is made of frames is all that there will be: a snapshot waits for that
    # In the last frame, for diagnostics; None where none are looked for.
    tags_in_sight: Optional[int] = None
    has_area: Optional[bool] = None

    def __init__(self, topics, kind_of_settings):
        self.settings = read(kind_of_settings, parameter)
        self.camera = rospy.resolve_name(CAMERA)
        suffix, self._kind, self._to_frame = TRANSPORTS[self.settings.transport]
        self._topic = self.camera + suffix
        self._subscriber = None
        self._last_sign = time.monotonic()  # of life from the camera
        self._waiting = None  # why nothing arrives, and whether that is all right
        self._unusable = None  # what is wrong with the last frame
        self.wake = threading.Event()
        self._outputs = {topic: ImagePublisher('~' + topic, self.wake.set) for topic in topics}
        self._count, self._lateness = FrameCount(self.tags_in_sight), Lateness()
        self._diagnostics = Diagnostics(self.report)
        self._snapshot = Snapshot(self.wake.set)
        self._looking = threading.Lock()  # rospy calls from a thread of its own for each who publishes frames

    def look(self, frame, header, stamp):
        """The images to publish, one for each topic; they are not where the frame turns out to be too old.

        ``frame``: (h, w, 3) BGR uint8, to write into. ``header``: the frame's.
        ``stamp``: its time, seconds.
        """
        raise NotImplementedError

    def to_frame(self, message):
        """The frame, (h, w, 3) BGR uint8, in a message. Raises InputError if there is none."""
        return self._to_frame(message)

    def publish(self, messages, header):
        """Publish what was made of a frame: (publisher, message) of the images, and what else there is."""
        for publisher, message in messages:
            publisher.publish(message)

    def is_wanted(self):
        """Whether anybody listens to anything that comes of a frame."""
        return self._snapshot.wanted or any(output.has_listeners() for output in self._outputs.values())

    def is_seen(self, topic):
        """Whether anybody looks at the images of that topic."""
        return self._snapshot.wanted or self._outputs[topic].has_listeners()

    def is_due(self, stamp):
        """Whether a frame of that time, seconds, is one to answer."""
        return True

    def follow(self, wanted):
        """Listen to what is needed besides the camera, or leave it; called about once a second."""

    def prepare(self, settings):
        """Functions that change over to other settings. Raises InputError if they cannot be."""
        return []

    def serve(self):
        """Offer the node's services."""
        self._snapshot.serve(lambda: self.settings.folder, lambda: self._why_nothing_arrives()[0])

    def advertise(self, topic, kind):
        """A Publisher of messages of that kind; the node takes note of who comes to listen, and goes."""
        return rospy.Publisher(topic, kind, Listener(self.wake.set), queue_size=1)

    def spin(self):
        """Subscribe while somebody listens, and say so when nothing arrives, until shutdown."""
        self.serve()
        Reconfigurer(self.settings, self._reconfigure)
        rospy.on_shutdown(self.wake.set)
        rospy.loginfo('Ready: %s -> %s', self._topic,
                      ', '.join(output.name for output in self._outputs.values()))
        while not rospy.is_shutdown():
            self._follow_listeners()
            if time.monotonic() - self._last_sign > SILENCE_S:
                self._explain_silence()
            self._diagnostics.update()
            self.wake.wait(1.0)
            self.wake.clear()

    def _reconfigure(self, settings):
        for change in self.prepare(settings):
            change()
        self.settings = settings
        self.wake.set()

    @guarded
    def _follow_listeners(self):
        wanted = self.is_wanted()
        if wanted != (self._subscriber is not None) and not is_there():
            return  # rospy would wait for the master, and with it all that is done here
        self.follow(wanted)
        if wanted and self._subscriber is None:
            self._last_sign = time.monotonic()
            self._count.begin()
            self._subscriber = subscribe_newest(self._topic, self._kind, self._on_message)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = self._unusable = None
            self._count.begin()

    def _why_nothing_arrives(self):
        """A sentence, and whether that is all right."""
        if self._unusable:
            return self._unusable, False
        try:
            published = published_topics()
        except InputError as error:
            return str(error), False
        own = [output.name for output in self._outputs.values()]
        if self._subscriber is None and published.get(self._topic) == self._kind._type:
            return 'Nobody listens to %s, so nothing is computed. To see it: %s' % (
                ', '.join([*self.results, *own]),
                self.advice or 'open the page, or rosrun image_view image_view image:=' + own[-1]), True
        return explain_silence(self.camera, self.settings.transport, published,
                               own + [name + '/compressed' for name in own]), False

    @guarded
    def _explain_silence(self):
        """Say why nothing arrives, again only when the reason has become another."""
        self._last_sign = time.monotonic()  # look again after another SILENCE_S
        self._unusable = None  # that was before the silence
        waiting = self._why_nothing_arrives()
        if waiting != self._waiting:
            self._waiting = waiting
            sentence, is_right = waiting
            (rospy.loginfo if is_right else rospy.logwarn)('%s', sentence)

    def report(self):
        """How the node is doing: see Diagnostics."""
        level, sentence, values = self._count.report()
        if self._waiting:
            sentence, is_right = self._waiting
            level = OK if is_right else ERROR
        elif self._subscriber is None:
            level, sentence = OK, 'Nobody listens, so nothing is computed.'
        elif self._unusable:
            level, sentence = ERROR, self._unusable
        return level, sentence, values

    def _on_message(self, message):
        self._last_sign = began = time.monotonic()
        if self._waiting:
            self._waiting = None
            rospy.loginfo('Frames arrive on %s.', self._topic)
        try:
            with self._looking:
                self._answer(message, began)
            self._unusable = None
        except InputError as error:
            self._unusable = str(error)
            say_once(error.kind, self._unusable)
        except Exception as error:  # a fault of ours: one frame is lost, not the node
            self._unusable = note_fault(error)

    def _answer(self, message, began):
        """Publish what is made of a message that came at that time, monotonic; raises InputError."""
        missing = self._count.came(message.header.seq)
        header = message.header
        if not is_time(header.stamp):
            raise InputError('A frame has the stamp %d s, %d ns, which is no time; check the clock of the '
                             'camera driver.' % (header.stamp.secs, header.stamp.nsecs), kind='stamp')
        stamp = (header.stamp or rospy.Time.now()).to_sec()
        if not self.is_due(stamp):
            return
        wait = self._lateness.wait_for_next(stamp, rospy.Time.now().to_sec(), missing)
        if wait and is_more_pending(self._subscriber, wait):
            self._count.left_out()  # the next frame will show the same, sooner
            return
        frame = self.to_frame(message)
        self._snapshot.before(frame)
        images = dict(zip(self._outputs, self.look(frame, header, stamp)))
        if self.ready:
            self._snapshot.after(images)
        messages = [each for topic, image in images.items()
                    for each in self._outputs[topic].messages(image, header)]
        if self._lateness.is_stale(rospy.Time.now().to_sec()) and is_more_pending(self._subscriber):
            self._count.left_out()
            return
        self.publish(messages, header)
        self._count.answered(began, header.stamp, missing, self.tags_in_sight, self.has_area)
