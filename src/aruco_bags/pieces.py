"""Joins the output of pieces."""
from contextlib import closing

import genpy
import numpy as np
import rosbag
from aruco_ar.base.errors import InputError
from aruco_ar.base.progress import progress
from aruco_ar.painting.video_writer import video_writer
from aruco_node.messages.images import frame_from_compressed
from aruco_node.ros_internals.indexed_bag import forget_written

from .bag_reader import reader_of

COPY_BYTES = 1 << 20
DEFAULT_RATE = 30.0  # frames per second of a video with a single frame
NEVER = genpy.Time(2**32 - 1, 10**9 - 1)


def join_bags(parts, target):
    """Write the messages of several bags to a new one, bag after bag. All arguments are paths."""
    with rosbag.Bag(target, 'w') as joined:
        for part in parts:
            forget_written(joined)
            with rosbag.Bag(part) as bag:
                for topic, message, time in bag.read_messages(raw=True):
                    joined.write(topic, message, time, raw=True)


def join_tables(parts, target, columns=()):
    """Write several tables to a new one, below a row with the names of the columns, if they are given."""
    with open(target, 'wb') as joined:
        joined.write((','.join(columns) + '\n').encode() if columns else b'')
        for part in parts:
            with open(part, 'rb') as table:
                for block in iter(lambda: table.read(COPY_BYTES), b''):
                    joined.write(block)


def make_video(bag, topic, target, name):
    """Write the images on a topic of a bag, or of an MCAP file, as an MP4 with H.264 for browsers and phones.

    ``name``: what the video is called in the end, for errors. Returns whether there are any. Raises InputError
    if the video cannot be written, or the images cannot be read. Call need_video first.
    """
    try:
        with closing(reader_of(bag)) as images:
            times = sorted(time.to_sec() for _, time in images.times([topic]))
            if not times:
                return False
            period = np.median(np.diff(times)) if len(times) > 1 else 0.0
            with video_writer(target, 1 / period if period else DEFAULT_RATE, name) as add:
                messages = images.messages([topic], genpy.Time(), NEVER)
                for _, message, _ in progress(messages, 'video', len(times)):
                    add(frame_from_compressed(message))
    except InputError:
        raise
    except Exception as error:  # of the readers' libraries and of the decoder, which raise many kinds
        raise InputError('the video "%s" cannot be made of the output "%s" (%s). Run the same command again.'
                         % (name, bag, ' '.join(str(error).split()) or type(error).__name__)) from None
    return True
