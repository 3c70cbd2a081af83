"""Reads a bag or an MCAP file in pieces. They do not depend on how many processes read them, or where."""
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
from aruco_node.messages.camera_info import info_topics
from aruco_node.messages.images import TRANSPORTS
from aruco_node.messages.topics import IMAGE_TYPES, SUFFIX, raw_topic
from aruco_node.ros_internals.indexed_bag import IndexedBag
from sensor_msgs.msg import CameraInfo

from .mcap_bag import McapBag, is_mcap

PIECE_S = 60.0         # length of a piece, in the bag's time
RUN_IN_NS = 3 * 10**9  # frames before a piece, from which the tracker learns
TRANSPORT_OF = {kind: name for name, kind in IMAGE_TYPES.items()}
_LAST = threading.local()  # for each thread of a Dask worker, the bag that is open, and its key


@dataclass(frozen=True)
class Piece:
    """The frames on a topic of a bag from the time ``begin`` on and before the time ``end``.

    ``camera``: the name that the output topics end with. ``info``: the topic of the camera's calibration, if
    there is one. ``known``: the time of the last calibration in an earlier piece, if there is one.
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
    """All Pieces of the image topics of a bag, and a list of sentences on the topics that are left out.

    Raises InputError if the bag cannot be read.
    """
    length = round(seconds * 1e9)
    with opened(path) as bag:
        kinds = bag.topics()
        topics = {topic: TRANSPORT_OF[kind] for topic, kind in kinds.items() if kind in TRANSPORT_OF}
        if not topics:
            raise InputError('it has no images: no topic has the type %s.' % ' or '.join(IMAGE_TYPES.values()))
        notes = _leave_out_copies(topics)
        first = bag.begin().to_nsec()
        # For each topic: {number of a piece that has messages of it: time of the last of these messages}.
        infos = {topic: info for topic in topics for info in reversed(info_topics(raw_topic(topic)))
                 if kinds.get(info) == CameraInfo._type}
        last: Dict[str, Dict[int, Any]] = {topic: {} for topic in (*topics, *infos.values())}
        for topic, time in bag.times(list(last)):
            number = (time.to_nsec() - first) // length
            last[topic][number] = max(time, last[topic].get(number, time))
    pieces = []
    for topic, transport in topics.items():
        info = infos.get(topic)
        camera = _absolute(topic if raw_topic(topic) in topics else raw_topic(topic))
        known = sorted(last[info].items()) if info else []
        for number in sorted(last[topic]):
            before = bisect_left(known, (number,))
            pieces.append(Piece(path, topic, transport, camera, number, genpy.Time(0, first + number * length),
                                genpy.Time(0, first + (number + 1) * length), info,
                                known[before - 1][1] if before else None))
    return pieces, notes


def _leave_out_copies(topics):
    """Remove compressed topics from {topic: transport} whose raw frames are there, too. Returns sentences."""
    raw = {_absolute(topic): topic for topic, transport in topics.items() if transport == 'raw'}
    copies = {topic: raw[camera] for topic, transport in topics.items()
              for camera in [_absolute(raw_topic(topic))]
              if transport == 'compressed' and topic.endswith(SUFFIX) and camera in raw}
    for topic in copies:
        del topics[topic]
    return ['%s and %s are of the same camera, so only %s is processed.' % (camera, topic, camera)
            for topic, camera in copies.items()]


def messages(piece):
    """(message, time, is_in_piece) of the images and calibrations of a Piece and its run-in.

    ``time``: the genpy.Time of the bag. ``is_in_piece``: False for the run-in.
    """
    begin = genpy.Time(0, max(piece.begin.to_nsec() - RUN_IN_NS, 0))
    with opened(piece.bag) as bag:
        if piece.known is not None and piece.known < begin:
            for _, message, time in bag.messages([piece.info], piece.known, piece.known):
                yield message, time, False
        for _, message, time in bag.messages([piece.topic, *filter(None, [piece.info])], begin, piece.end):
            if time < piece.end:
                yield message, time, time >= piece.begin


def decoder_of(piece):
    """A new decoder of the image messages of a Piece, which makes frames of them."""
    return TRANSPORTS[piece.transport][2]()


def _absolute(topic):
    """The absolute name of a topic. In bags the first slash may be missing."""
    return '/' + topic.lstrip('/')


def reader_of(path):
    """A new IndexedBag or McapBag of a file. Raises what their libraries raise, and InputError."""
    return McapBag(path) if is_mcap(path) else IndexedBag(path)


@contextmanager
def opened(path):
    """A context manager with the IndexedBag or McapBag of an input file.

    Raises InputError, also if reading fails within the block.

    The last bag stays open, since opening a long bag takes long, and the next piece is usually of the same bag.
    """
    try:
        about = os.stat(path)
        if not stat.S_ISREG(about.st_mode):
            raise InputError('it is a folder, pipe or device, not a file.')
        key = path, about.st_size, about.st_mtime_ns
        if getattr(_LAST, 'key', None) != key:
            if hasattr(_LAST, 'bag'):
                _LAST.bag.close()
            _LAST.__dict__.clear()
            _LAST.bag = reader_of(path)
            _LAST.key = key
        yield _LAST.bag
    except rosbag.ROSBagUnindexedException:
        raise InputError('it has no index; perhaps its recording was interrupted. Make one: rosbag reindex "%s"'
                         % path) from None
    except InputError:
        raise
    except Exception as error:  # rosbag raises exceptions of many kinds
        raise InputError('it cannot be read (%s).' % (' '.join(str(error).split()) or type(error).__name__)) \
            from None
