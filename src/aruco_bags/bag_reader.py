"""What is in a bag, and reading it in pieces that are the same wherever and by however many they are read."""
import os
import stat
import threading
from bisect import bisect_left
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Dict, Optional

import genpy
import rosbag
from aruco_ar.base.errors import InputError
from aruco_node.messages.images import TRANSPORTS
from aruco_node.messages.topics import IMAGE_TYPES, raw_topic
from aruco_node.nodes.calibration import info_topic
from aruco_node.ros_internals.indexed_bag import IndexedBag
from sensor_msgs.msg import CameraInfo

PIECE_S = 60.0         # of a bag's own time
RUN_IN_NS = 3 * 10**9  # before a piece its frames are looked at as well, for what is learned from them
TRANSPORT_OF = {kind: name for name, kind in IMAGE_TYPES.items()}
_LAST = threading.local()  # of each thread of a Dask worker: the bag that is open, and what it was opened for


@dataclass(frozen=True)
class Piece:
    """The frames on a topic of a bag from a time on and before another.

    ``camera``: what the topics of what is made of it are called after. ``info``: the topic of its
    calibration, if there is one, and ``known``: when that last came before.
    """

    bag: str
    topic: str
    transport: str
    camera: str
    number: int
    begin: genpy.Time
    end: genpy.Time
    info: Optional[str]
    known: Optional[genpy.Time]


def pieces_of(path, seconds=PIECE_S):
    """All Pieces, of so many seconds, of all image topics of a bag. Raises InputError if it cannot be read."""
    length = round(seconds * 1e9)
    with opened(path) as bag:
        kinds = bag.topics()
        topics = {topic: TRANSPORT_OF[kind] for topic, kind in kinds.items() if kind in TRANSPORT_OF}
        if not topics:
            raise InputError('it has no images, no topic of %s.' % ' or '.join(IMAGE_TYPES.values()))
        first = bag.begin().to_nsec()
        # Of each topic: the numbers of the pieces that it has messages in, and when the last is.
        infos = {topic: info_topic(raw_topic(topic)) for topic in topics}
        infos = {topic: info for topic, info in infos.items() if kinds.get(info) == CameraInfo._type}
        last: Dict[str, Dict[int, Any]] = {topic: {} for topic in (*topics, *infos.values())}
        for topic, time in bag.times(list(last)):
            number = (time.to_nsec() - first) // length
            last[topic][number] = max(time, last[topic].get(number, time))
    pieces = []
    for topic, transport in topics.items():
        info = infos.get(topic)
        camera = _named(topic if raw_topic(topic) in topics else raw_topic(topic))
        known = sorted(last[info].items()) if info else []
        for number in sorted(last[topic]):
            before = bisect_left(known, (number,))
            pieces.append(Piece(path, topic, transport, camera, number, _time(first + number * length),
                                _time(first + (number + 1) * length), info,
                                known[before - 1][1] if before else None))
    return pieces


def messages(piece):
    """Images and calibrations of a Piece and its run-in: (message, time, whether it is of the piece itself).

    ``time``: genpy.Time, the bag's.
    """
    begin = _time(max(piece.begin.to_nsec() - RUN_IN_NS, 0))
    with opened(piece.bag) as bag:
        if piece.known is not None and piece.known < begin:
            for _, message, time in bag.messages([piece.info], piece.known, piece.known):
                yield message, time, False
        for _, message, time in bag.messages([piece.topic, *filter(None, [piece.info])], begin, piece.end):
            if time < piece.end:
                yield message, time, time >= piece.begin


def to_frame(piece):
    """The function that makes a frame of an image message of a Piece."""
    return TRANSPORTS[piece.transport][2]


def _named(topic):
    """A topic's whole name; in bags it may lack the first slash."""
    return '/' + topic.lstrip('/')


def _time(nanoseconds):
    return genpy.Time(nanoseconds // 10**9, nanoseconds % 10**9)


@contextmanager
def opened(path):
    """An IndexedBag. Raises InputError, also where the block finds it broken.

    The last one stays open: how a long bag begins takes long to read, and its pieces come in turn.
    """
    try:
        about = os.stat(path)
        if not stat.S_ISREG(about.st_mode):
            raise InputError('it is not a file but a folder, pipe or device.')
        key = path, about.st_size, about.st_mtime_ns
        if getattr(_LAST, 'key', None) != key:
            if hasattr(_LAST, 'bag'):
                _LAST.bag.close()
            _LAST.__dict__.clear()
            _LAST.bag, _LAST.key = IndexedBag(path), key
        yield _LAST.bag
    except rosbag.ROSBagUnindexedException:
        raise InputError('it has no index, as where its recording was cut off. Make one: rosbag reindex "%s"'
                         % path) from None
    except InputError:
        raise
    except Exception as error:  # rosbag raises many kinds
        raise InputError('it cannot be read (%s).' % (' '.join(str(error).split()) or type(error).__name__)) \
            from None
