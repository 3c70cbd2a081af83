"""Opens the picture that is painted: a file, or a topic."""
import time
from collections import deque

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package
from aruco_ar.painting.picture_file import shrink_to_warp
from aruco_ar.painting.sources import open_source
from genpy import Message
from rosgraph.names import is_legal_name

from aruco_node.health.faults import log_notes
from aruco_node.health.silence import SILENCE_S
from aruco_node.messages.images import END_OF_VIDEO, TRANSPORTS, ImageDecoder
from aruco_node.messages.topics import SUFFIX
from aruco_node.parameters.settings import TOPIC
from aruco_node.ros_internals.subscribers import subscribe_newest


def open_picture(picture):
    """The source of the picture that the parameter ~picture names: a file or a topic.

    A relative path starts in the package's folder. Raises InputError if there is no such picture.
    """
    if picture.startswith(TOPIC):
        return TopicPicture(picture[len(TOPIC):])
    return open_source(in_package(picture), lambda sentence: rospy.logwarn('%s', sentence))


class TopicPicture:
    """A source of pictures: the newest image on a topic."""

    def __init__(self, topic):
        """Raises InputError if ``topic`` is not a topic name, or if this node publishes it itself."""
        if not is_legal_name(topic):
            raise InputError('The parameter ~picture is "%s%s"; it must be %sTOPIC, with the name of a topic.'
                             % (TOPIC, topic, TOPIC))
        self._topic = rospy.resolve_name(topic)
        if self._topic.startswith(rospy.get_name() + '/'):
            raise InputError('The parameter ~picture is "%s%s", which this node publishes itself. Give '
                             'another topic.' % (TOPIC, topic))
        compressed = self._topic.endswith(SUFFIX)
        _, self._kind, decoder = TRANSPORTS['compressed' if compressed else 'raw']
        self._to_picture = decoder() if compressed else ImageDecoder(keeps_alpha=True)
        self._subscriber = None
        self._is_silence_logged = self._is_fault_logged = False
        # The newest message that was not shown yet. It is decoded only when it is shown, as most are not.
        self._messages: deque[Message] = deque(maxlen=1)
        self._picture = None

    def update_subscription(self, wanted):
        """Subscribe to the topic if it is wanted, else leave it. Logs a warning, once, if nothing arrives."""
        if wanted and self._subscriber is None:
            self._subscribed_at = time.monotonic()
            self._subscriber = subscribe_newest(self._topic, self._kind, self._on_message)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
        elif wanted and not self._is_silence_logged and time.monotonic() - self._subscribed_at > SILENCE_S:
            self._is_silence_logged = True
            rospy.logwarn('Nothing has arrived on %s, so nothing is painted yet. Is it published?',
                          self._topic)

    def at(self, stamp):
        """The newest picture, (h, w, 3 or 4) uint8, or None before the first one has arrived."""
        if self._messages:
            try:
                self._picture = shrink_to_warp(self._to_picture(self._messages.pop()))
                log_notes(self._topic, self._to_picture.notes)
            except InputError as error:
                is_end = error.kind == END_OF_VIDEO and self._picture is not None
                if not (is_end or self._is_fault_logged):
                    self._is_fault_logged = True
                    rospy.logerr('A picture on %s is skipped: %s', self._topic, error)
        return self._picture

    def _on_message(self, message):
        self._messages.append(message)
        self._is_silence_logged = True
