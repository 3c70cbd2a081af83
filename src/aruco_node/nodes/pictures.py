"""Where the picture that is painted comes from: a file, or a topic."""
import os
import time

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import package_folder
from aruco_ar.painting.picture import shrink_to_warp
from aruco_ar.painting.sources import open_source
from rosgraph.names import is_legal_name

from aruco_node.health.silence import SILENCE_S
from aruco_node.messages.images import TRANSPORTS, picture_from_image
from aruco_node.messages.topics import SUFFIX
from aruco_node.parameters.settings import TOPIC
from aruco_node.ros_internals.newest import subscribe_newest


def open_picture(picture):
    """What the parameter ~picture names: a file, perhaps of the package, or a topic. Raises InputError."""
    if picture.startswith(TOPIC):
        return TopicPicture(picture[len(TOPIC):])
    path = os.path.join(package_folder(), os.path.expanduser(picture))
    return open_source(path, lambda sentence: rospy.logwarn('%s', sentence))


class TopicPicture:
    """The newest image on a topic; while nothing new comes, the last one stays."""

    def __init__(self, topic):
        """Raises InputError if there can be no such topic, or if it is one of the node's own."""
        if not is_legal_name(topic):
            raise InputError('The parameter ~picture is "%s%s"; that is no name of a topic.' % (TOPIC, topic))
        self._topic = rospy.resolve_name(topic)
        if self._topic.startswith(rospy.get_name() + '/'):
            raise InputError('The parameter ~picture is "%s%s", which this node publishes itself; give '
                             'another topic.' % (TOPIC, topic))
        compressed = self._topic.endswith(SUFFIX)
        _, self._kind, to_frame = TRANSPORTS['compressed' if compressed else 'raw']
        self._to_picture = to_frame if compressed else picture_from_image
        self._subscriber = None
        self._silent = self._broken = False  # whether that has been said, or need not be
        self._message = None  # not yet made a picture: most are never shown
        self._picture = None

    def follow(self, wanted):
        """Listen to the topic, or leave it; say so, once, when nothing comes."""
        if wanted and self._subscriber is None:
            self._since = time.monotonic()
            self._subscriber = subscribe_newest(self._topic, self._kind, self._on_message)
        elif not wanted and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
        elif wanted and not self._silent and time.monotonic() - self._since > SILENCE_S:
            self._silent = True
            rospy.logwarn('Nothing has arrived on %s, so nothing is painted yet. Is it published?',
                          self._topic)

    def at(self, stamp):
        """The picture, (h, w, 3 or 4) uint8, or None before the first has come."""
        message, self._message = self._message, None
        if message is not None:
            try:
                self._picture = shrink_to_warp(self._to_picture(message))
            except InputError as error:
                if not self._broken:
                    self._broken = True
                    rospy.logerr('A picture on %s is passed over: %s', self._topic, error)
        return self._picture

    def _on_message(self, message):
        self._message, self._silent = message, True
