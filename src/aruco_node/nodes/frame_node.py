"""The shell of a node that works on a camera's frames: topics, parameters, services and diagnostics."""
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable, Optional, Sequence

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.lateness import Lateness

from aruco_node.health.diagnostics import ERROR, OK, Diagnostics, FrameCount
from aruco_node.health.faults import fault_barrier, log_notes, log_once, note_fault
from aruco_node.health.silence import SILENCE_S, explain_silence
from aruco_node.health.snapshot import SnapshotService
from aruco_node.messages.images import END_OF_VIDEO, TRANSPORTS
from aruco_node.messages.publishing import ImagePublisher, ListenerEvents
from aruco_node.parameters.parameters import AUTO
from aruco_node.parameters.reconfigure import Reconfigurer
from aruco_node.ros_internals.master import is_there, published_topics
from aruco_node.ros_internals.subscribers import is_more_pending, subscribe_newest
from aruco_node.ros_internals.tf import is_time

from .node import read_settings

CAMERA = 'camera/rgb/image_raw'
OTHER_TRANSPORT_S = 2.0  # after this time without a frame, the other transport may be used


@dataclass(frozen=True)
class Answer:
    """What a node makes of one frame.

    ``images``: (h, w, 3) BGR uint8, one for each image topic. ``publish`` publishes everything else that
    belongs to the frame; it is not called if the frame is stale by then. ``is_complete``: whether nothing is
    missing that a snapshot should show, such as poses while the calibration has not arrived.
    ``tags_in_sight``: how many, and ``has_area``: whether the area is known; both are None for a node that
    does not look for tags.
    """

    images: Sequence[Any]
    publish: Callable[[], None] = lambda: None
    is_complete: bool = True
    tags_in_sight: Optional[int] = None
    has_area: Optional[bool] = None


class FrameNode:
    """The shell between ROS and what a node does with a frame. It works only while somebody listens.

    It subscribes to the camera, drops stale frames, publishes answers, takes snapshots, and reports
    diagnostics. What frames are processed with changes only in ``between_frames``. A subclass implements
    ``process``. It may extend ``decode``, ``is_due``, ``is_wanted``, ``update_subscriptions``,
    ``forget_last_frames``, ``prepare``, ``offer_services`` and ``report``.
    """

    result_topics: Sequence[str] = ()  # resolved names of the topics that are published besides images
    viewing_hint = ''  # how to see what the node publishes, if the usual ways do not show it

    def __init__(self, image_topics, kind_of_settings, looks_for_tags=False):
        """``image_topics``: private names of the images. ``kind_of_settings``: the class of the parameters.

        Raises InputError if a parameter is not valid.
        """
        self.settings = read_settings(kind_of_settings)
        self.camera = rospy.resolve_name(CAMERA)
        self._use_transport('raw' if self.settings.image_transport == AUTO else self.settings.image_transport)
        self._subscriber = None
        self._silent_since = time.monotonic()  # when the last frame arrived, or the silence was last explained
        self._silence = None  # (why no frames arrive, whether that is all right), None while they arrive
        self._frame_problem = None  # why the last frame could not be used
        self._may_end = True  # whether the next frame may be an END_OF_VIDEO: not after another one
        self._wake = threading.Event()  # ends the main loop's sleep
        self.are_heard = []  # functions that tell whether anybody listens to what is published besides images
        self.inputs = []     # what has an update_subscription: see CameraLens
        self.outputs = {topic: ImagePublisher('~' + topic, self._wake.set) for topic in image_topics}
        self._count, self._lateness = FrameCount(looks_for_tags), Lateness()
        self._diagnostics = Diagnostics(self.report)
        self._snapshots = SnapshotService(self._wake.set)
        # Held while a frame is processed: rospy calls back in one thread for each publisher of frames.
        self._processing = threading.Lock()

    def process(self, frame, header, stamp):
        """The Answer to a frame, (h, w, 3) BGR uint8, which may be drawn on.

        ``header``: the frame's. ``stamp``: its time in seconds.
        """
        raise NotImplementedError

    def _use_transport(self, transport):
        self._transport = transport
        suffix, self._message_class, decoder = TRANSPORTS[transport]
        self._decode = decoder()
        self._topic = self.camera + suffix

    def decode(self, message):
        """The frame in a message, (h, w, 3) BGR uint8. Raises InputError if it holds no usable frame."""
        return self._decode(message)

    def is_due(self, stamp):
        """Whether to process a frame with this time in seconds."""
        return True

    def is_wanted(self):
        """Whether anybody listens to any topic that is published for each frame, or waits for a snapshot."""
        return any(self.is_image_wanted(topic) for topic in self.outputs) or \
            any(is_heard() for is_heard in self.are_heard)

    def is_image_wanted(self, topic):
        """Whether anybody listens to the images on this topic, or waits for a snapshot."""
        return self._snapshots.is_waiting or self.outputs[topic].has_listeners()

    def update_subscriptions(self, wanted):
        """Subscribe to topics other than the camera's, or leave them. Called about once a second."""
        for each in self.inputs:
            each.update_subscription(wanted)

    def forget_last_frames(self):
        """Forget what is true only of the last frames. Called when the node begins or ceases to listen."""

    def prepare(self, settings):
        """Check new settings.

        Returns the function that applies them. Raises InputError if they cannot be used.
        """
        return lambda: None

    def offer_services(self):
        """Advertise the node's services. Called once, before the first frame."""
        self._snapshots.offer(lambda: self.settings.folder, lambda: self._explain_no_frames()[0])

    def report(self):
        """(level, sentence, values) for Diagnostics."""
        level, sentence, values = self._count.report()
        if self.is_receiving:
            values.update(self._decode.notes)
        if self._silence:
            sentence, is_fine = self._silence
            level = OK if is_fine else ERROR
        elif self._subscriber is None:
            level, sentence = OK, 'Nobody listens, so nothing is computed.'
        elif self._frame_problem:
            level, sentence = ERROR, self._frame_problem
        return level, sentence, values

    @property
    def is_receiving(self):
        """Whether frames arrive."""
        return self._subscriber is not None and not self._silence

    def between_frames(self, change):
        """Call a function that changes what frames are processed with, while none is processed.

        Services and dynamic_reconfigure have threads of their own. So that a frame finds everything as it was
        when it began, all that they change is changed here. The function must be quick.
        """
        with self._processing:
            change()

    def advertise(self, topic, message_class, is_enough=True):
        """A rospy.Publisher. The node notices at once when somebody starts or stops listening to it.

        ``is_enough``: whether frames are processed while somebody listens to nothing else.
        """
        publisher = rospy.Publisher(topic, message_class, ListenerEvents(self._wake.set), queue_size=1)
        if is_enough:
            self.are_heard.append(publisher.get_num_connections)
        return publisher

    def spin(self):
        """Process frames until shutdown."""
        self.offer_services()
        Reconfigurer(self.settings, self._reconfigure)
        rospy.on_shutdown(self._wake.set)
        rospy.loginfo('Ready: %s -> %s', self._topic,
                      ', '.join(output.name for output in self.outputs.values()))
        while not rospy.is_shutdown():
            self._subscribe_if_wanted()
            silence = time.monotonic() - self._silent_since
            if self.settings.image_transport == AUTO and \
                    silence > (OTHER_TRANSPORT_S if self._subscriber is not None else SILENCE_S):
                self._try_other_transport()
            if silence > SILENCE_S:
                self._log_silence()
            self._diagnostics.update()
            self._wake.wait(1.0)
            self._wake.clear()

    def _reconfigure(self, settings):
        apply = self.prepare(settings)

        def change():
            apply()
            self.settings = settings
        self.between_frames(change)
        self._wake.set()

    @fault_barrier
    def _subscribe_if_wanted(self):
        wanted = self.is_wanted()
        if wanted != (self._subscriber is not None) and not is_there():
            return  # to subscribe, rospy would wait for the master, and block the main loop meanwhile
        self.update_subscriptions(wanted)
        if wanted and self._subscriber is None:
            self._silent_since = time.monotonic()
            self._forget_frames()
            self._subscriber = subscribe_newest(self._topic, self._message_class, self._on_message)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = self._frame_problem = None
            self._forget_frames()

    def _forget_frames(self):
        self._count.forget_last_frames()
        self.between_frames(self.forget_last_frames)

    @fault_barrier
    def _try_other_transport(self):
        """Use the other transport if the camera publishes only that one."""
        try:
            published = published_topics()
        except InputError:
            return  # the silence is explained elsewhere
        other = 'raw' if self._transport == 'compressed' else 'compressed'
        suffix, message_class, _ = TRANSPORTS[other]
        if self._topic in published or published.get(self.camera + suffix) != message_class._type:
            return
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
        self.between_frames(lambda: self._use_transport(other))
        rospy.loginfo('Only the %s frames of %s are published, so these are used.', other, self.camera)

    def _explain_no_frames(self):
        """(why no frames arrive, in a sentence, and whether that is all right)."""
        if self._frame_problem:
            return self._frame_problem, False
        try:
            published = published_topics()
        except InputError as error:
            return str(error), False
        own = [output.name for output in self.outputs.values()]
        if self._subscriber is None and published.get(self._topic) == self._message_class._type:
            return 'Nobody listens to %s, so nothing is computed. To see it: %s' % (
                ', '.join([*self.result_topics, *own]),
                self.viewing_hint or 'open the page, or rosrun image_view image_view image:=' + own[-1]), True
        return explain_silence(self.camera, self._transport, published,
                               own + [name + '/compressed' for name in own]), False

    @fault_barrier
    def _log_silence(self):
        """Log why no frames arrive, if the reason is not the one that was logged last."""
        self._silent_since = asked = time.monotonic()  # look again after another SILENCE_S
        self._frame_problem = None  # it is older than the silence
        silence = self._explain_no_frames()
        if self._silent_since != asked:
            return  # while the master was asked, a frame arrived
        if silence != self._silence:
            self._silence = silence
            sentence, is_fine = silence
            (rospy.loginfo if is_fine else rospy.logwarn)('%s', sentence)

    def _on_message(self, message):
        self._silent_since = arrival = time.monotonic()
        if self._silence:
            self._silence = None
            rospy.loginfo('Frames arrive on %s.', self._topic)
        try:
            with self._processing:
                self._answer(message, arrival)
            self._frame_problem, self._may_end = None, True
        except InputError as error:
            if error.kind == END_OF_VIDEO and self._may_end:
                self._may_end = False
                return
            self._frame_problem = str(error)
            self._count.on_unusable(self._frame_problem)
            log_once(error.kind, self._frame_problem)
        except Exception as error:  # a bug costs one frame, not the node
            self._frame_problem = note_fault(error)

    def _answer(self, message, arrival):
        """Process a message that arrived at a monotonic time, and publish the Answer. Raises InputError."""
        if not isinstance(message, self._message_class):
            return  # the last frame of the transport that was used before
        missing = self._count.on_arrival(message.header.seq)
        header = message.header
        header.stamp.canon()  # some drivers count more than a second in nanoseconds
        if not is_time(header.stamp):
            raise InputError('A frame has the stamp %d s, %d ns, which is not a possible time. Check the clock '
                             'of the camera driver.' % (header.stamp.secs, header.stamp.nsecs), kind='stamp')
        stamp = (header.stamp or rospy.Time.now()).to_sec()
        if not self.is_due(stamp):
            return
        wait = self._lateness.wait_for_next(stamp, rospy.Time.now().to_sec(), missing)
        if wait and is_more_pending(self._subscriber, wait):
            self._count.on_drop()  # the next frame will show the same, but fresher
            return
        frame = self.decode(message)
        log_notes(self._topic, self._decode.notes)
        self._snapshots.keep_frame(frame)
        answer = self.process(frame, header, stamp)
        images = dict(zip(self.outputs, answer.images))
        if answer.is_complete:
            self._snapshots.keep_images(images)
        messages = [each for topic, image in images.items()
                    for each in self.outputs[topic].messages(image, header)]
        if self._lateness.is_stale(rospy.Time.now().to_sec()) and is_more_pending(self._subscriber):
            self._count.on_drop()  # stale frames are not published
            return
        answer.publish()
        for publisher, output in messages:
            publisher.publish(output)
        self._count.on_answer(arrival, header.stamp, missing, answer.tags_in_sight, answer.has_area)
