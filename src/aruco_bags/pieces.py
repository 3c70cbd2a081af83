"""Joins the output of pieces."""
import cv2
import rosbag
from aruco_ar.base.errors import InputError
from aruco_node.messages.images import frame_from_compressed
from aruco_node.ros_internals.indexed_bag import forget_written

COPY_BYTES = 1 << 20
DEFAULT_RATE = 30.0  # frames per second of a video with a single frame
RATES = 1.0, 240.0  # lowest and highest frames per second of a video


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


def make_video(bag, topic, target):
    """Write the images on a topic of a bag as a video. Returns whether there are any.

    Raises InputError if the video cannot be written.
    """
    writer, size, count = None, None, 0
    with rosbag.Bag(bag) as images:
        about = images.get_type_and_topic_info([topic]).topics.get(topic)
        rate = min(max((about and about.frequency) or DEFAULT_RATE, RATES[0]), RATES[1])
        for _, message, _ in images.read_messages([topic]):
            frame = frame_from_compressed(message)
            if writer is None:
                size = frame.shape[1::-1]
                writer = cv2.VideoWriter(target, cv2.VideoWriter.fourcc(*'mp4v'), rate, size)
                if not writer.isOpened():
                    raise InputError('no video with frames of %d x %d pixels can be written. Leave out --video.'
                                     % size)
            writer.write(frame if frame.shape[1::-1] == size else cv2.resize(frame, size))
            count += 1
    if writer is not None:
        writer.release()
        if cv2.VideoCapture(target).get(cv2.CAP_PROP_FRAME_COUNT) != count:  # no other report
            raise InputError('its video could not be written completely. Is the disk full?')
    return writer is not None
