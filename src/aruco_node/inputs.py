"""What an exercise's step takes besides the frame, for one area, and where a node gets it from."""
import os
import threading
import time
from typing import Any

import rospy
from aruco_ar.detector import Detector
from aruco_ar.errors import InputError
from aruco_ar.picture import shrink_to_warp
from aruco_ar.sources import open_source
from aruco_ar.tracker import Tracker
from rosgraph.names import is_legal_name

from .connections import subscribe_newest
from .messages import TRANSPORTS, picture_from_image
from .settings import TOPIC
from .waiting import SILENCE_S, SUFFIX

# Parameters of a Detector, and others after whose change all is learned anew.
FINDS = 'search', 'correction', 'likeness', 'min_side'
BEGINS = 'dictionary', 'ids', 'upright'


class Inputs:
    """Gives a step what it takes, frame by frame.

    ``takes``: some of tags, area, picture, fit, opacity. ``package``: the
    folder within which the path of a picture may be given.
    """

    def __init__(self, takes, settings, package):
        self._takes, self._settings, self._package = takes, settings, package
        self._lock = threading.Lock()  # topics are followed in one thread, settings changed in another
        self._detected, self.has_area = [], False
        self._detector, self._tracker = self._begin(settings)
        self._source: Any = self._open(settings.picture) if 'picture' in takes else None

    @property
    def tags(self):
        """A list of Tag: those seen in the last frame."""
        return self._detected if 'tags' in self._takes else self._tracker.tags

    @property
    def why(self):
        """What the area is known by, or why there is none: see Tracker."""
        return self._tracker.why

    def at(self, frame, stamp):
        """What the step takes, in order, for a frame and its time, seconds."""
        return [getattr(self, '_' + name)(frame, stamp) for name in self._takes]

    def prepare(self, settings):
        """Open the picture of other Settings; returns what uses it, and all else, from the next frame on.

        Raises InputError if there is no such picture.
        """
        before = self._settings
        same = 'picture' not in self._takes or settings.picture == before.picture
        source = self._source if same else self._open(settings.picture)
        begun = self._begin(settings) if any(getattr(settings, name, None) != getattr(before, name, None)
                                             for name in (*FINDS, *BEGINS)) else None

        def change():
            with self._lock:
                if not same and isinstance(self._source, TopicPicture):
                    self._source.follow(False)
                if begun:
                    self._detector, self._tracker = begun
                elif self._tracker is not None:
                    self._tracker.hold = settings.hold
                self._settings, self._source = settings, source
        return change

    def reset(self):
        """Forget what was learned from frames."""
        with self._lock:
            self._detector, self._tracker = self._begin(self._settings)

    def _begin(self, settings):
        """What finds tags, and what follows the area, as far as they are needed."""
        finds = {name: getattr(settings, name) for name in FINDS}
        return (Detector(settings.dictionary, settings.ids, **finds) if 'tags' in self._takes else None,
                Tracker(settings.dictionary, settings.ids, settings.hold, settings.upright, **finds)
                if 'area' in self._takes else None)

    def follow(self, wanted):
        """Listen to the picture's topic, if it is one, or leave it."""
        with self._lock:
            if isinstance(self._source, TopicPicture):
                self._source.follow(wanted)

    def _tags(self, frame, stamp):
        self._detected = self._detector.detect(frame)
        return self._detected

    def _area(self, frame, stamp):
        area = self._tracker.update(frame, stamp)
        self.has_area = area is not None
        return area

    def _picture(self, frame, stamp):
        return self._source.at(stamp)

    def _fit(self, frame, stamp):
        return self._settings.fit

    def _opacity(self, frame, stamp):
        return self._settings.opacity

    def _open(self, picture):
        if picture.startswith(TOPIC):
            return TopicPicture(picture[len(TOPIC):])
        path = os.path.join(self._package, os.path.expanduser(picture))
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
