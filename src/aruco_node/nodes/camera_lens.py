"""The Lens of a camera, from the sensor_msgs/CameraInfo on its topic."""
import time
from math import inf
from typing import Any, Dict, List, Optional, Tuple

import rospy
from aruco_ar.base.errors import InputError
from rosgraph.names import is_legal_name
from sensor_msgs.msg import CameraInfo

from aruco_node.health.faults import fault_barrier, log_notes, log_once
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages.annotations import KIND
from aruco_node.messages.camera_info import info_of_frames, info_topics, lens_from_info
from aruco_node.parameters.parameters import AUTO
from aruco_node.ros_internals.master import published_topics
from aruco_node.ros_internals.subscribers import tolerant

NO_CAMERA_INFO = 'no camera_info'  # a kind of InputErrors
RECTIFIED = 'image_rect'  # image_proc's name of the topic of rectified frames
LOOK_S = 1.0              # if no CameraInfo has arrived after this time, others are looked for


def is_rectified(settings, camera):
    """Whether the frames on the raw topic ``camera`` are rectified, by PoseSettings or by the topic's name."""
    return camera.rpartition('/')[2].startswith(RECTIFIED) if settings.rectified == AUTO else settings.rectified


class InfoSubscriber:
    """Subscribes to the CameraInfo of a camera, which may be published beside its images or below them."""

    def __init__(self, topics, on_info):
        """``topics``: names that the topic may have. ``on_info`` is called with each CameraInfo."""
        self._topics, self._on_info = topics, on_info
        self.topic = topics[0]
        self._subscriber: Any = None  # a rospy.Subscriber
        self.others: List[str] = []  # sorted names of all CameraInfo topics, if this one is not published
        self.since = inf             # when it subscribed, monotonic seconds
        self._has_info, self._look_at = False, 0.0

    def update(self, wanted):
        """Subscribe to the topic if it is wanted, else leave it. Called about once a second."""
        if wanted and self._subscriber is None:
            self.since, self._look_at = time.monotonic(), time.monotonic() + LOOK_S
            self._subscribe()
        elif not wanted and self._subscriber is not None:
            self._unsubscribe()
        elif wanted and not self._has_info and time.monotonic() > self._look_at:
            self._look_at = time.monotonic() + SILENCE_S
            self._look_for_others()

    def _look_for_others(self):
        try:
            published = published_topics()
        except InputError:
            return  # the master does not answer
        # A node that publishes annotations passes on the calibration of its camera.
        found = sorted(topic for topic, kind in published.items() if kind == CameraInfo._type
                       and published.get(topic.rpartition('/')[0] + '/annotations') != KIND)
        self.others = [] if self.topic in found else found
        topic = next((topic for topic in self._topics if topic in self.others), None)
        if topic is not None:
            rospy.loginfo('Nothing publishes %s, so the calibration is taken from %s.', self.topic, topic)
            self._unsubscribe()
            self.topic, self.others = topic, []
            self._subscribe()

    def _subscribe(self):
        self._subscriber = rospy.Subscriber(self.topic, tolerant(CameraInfo), self._on_message, queue_size=1)

    def _unsubscribe(self):
        self._subscriber.unregister()
        self._subscriber = None

    @fault_barrier
    def _on_message(self, info):
        self._has_info = True
        self._on_info(info)


class CameraLens:
    """Subscribes to a camera's CameraInfo, and makes a Lens of it."""

    def __init__(self, settings, camera):
        """``camera``: the resolved name of the camera's raw topic.

        Raises InputError if the parameter ~camera_info is not a topic name.
        """
        if not is_legal_name(settings.camera_info):
            raise InputError('The parameter ~camera_info is "%s"; it must be the name of a topic.'
                             % settings.camera_info)
        self.rectified = is_rectified(settings, camera)
        self._subscriber = InfoSubscriber(
            info_topics(camera) if settings.camera_info == AUTO else [rospy.resolve_name(settings.camera_info)],
            self._on_info)
        self._info = self._lens = None
        self._fault: Optional[Tuple[str, str]] = None  # why there is none: an InputError's sentence, kind
        self._lens_input = None  # what they were made from

    @property
    def topic(self):
        """The resolved name of the CameraInfo topic."""
        return self._subscriber.topic

    def update_subscription(self, wanted):
        """Subscribe to the topic if it is wanted, else leave it. Called about once a second."""
        self._subscriber.update(wanted)

    def lens(self, size, scale):
        """The Lens for frames of this size, (width, height) pixels; None until a CameraInfo has arrived.

        ``scale``: the factor by which the frames were resized. Raises InputError if no CameraInfo arrives
        within SILENCE_S, or if it cannot be used.
        """
        info = self._info
        if info is None:
            if time.monotonic() - self._subscriber.since < SILENCE_S:
                return None
            others = self._subscriber.others
            raise InputError('nothing arrives on it. %s camera_info:=TOPIC' % (
                'These are published: %s. Choose one:' % ', '.join(others) if others else
                'Start the camera with its calibration, or name the topic:'), kind=NO_CAMERA_INFO)
        if self._lens_input != (info, size, scale):
            notes: Dict[str, str] = {}
            self._lens = self._fault = None
            try:
                self._lens = lens_from_info(info, size, self.rectified, scale, notes)
            except InputError as error:
                self._fault = str(error), error.kind
            self._lens_input = info, size, scale
            log_notes(self.topic, notes)
        if self._fault is not None:
            raise InputError(*self._fault)
        return self._lens

    def info(self, size, header, scale):
        """The CameraInfo of frames with this header, as ``lens`` takes them.

        None while that gives no Lens. Why it gives none is logged once.
        """
        info = self._info
        try:
            if self.lens(size, scale) is None or info is None:
                return None
            return info_of_frames(info, size, header, scale)
        except InputError as error:
            # Not every node has the parameter that the sentence of ``lens`` names.
            why = 'nothing arrives on it. Start the camera with its calibration.' \
                if error.kind == NO_CAMERA_INFO else error
            log_once(error.kind, 'Nothing is published on ~camera_info. %s: %s' % (self.topic, why),
                     rospy.loginfo)
            return None

    def _on_info(self, info):
        info.header = None  # the stamp would make every message look like a new calibration
        if info != self._info:
            self._info = info
