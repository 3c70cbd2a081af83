"""The pieces of a bag, put together."""
import cv2
import rosbag
from aruco_ar.base.errors import InputError
from aruco_node.messages.images import frame_from_compressed
from aruco_node.ros_internals.indexed_bag import forget_written

COPY_BYTES = 1 << 20
USUAL_RATE = 30.0  # of the video of a single frame
RATES = 1.0, 240.0


def join_bags(parts, target):
    """Write the messages of bags, one after the other, into another."""
    with rosbag.Bag(target, 'w') as joined:
        for part in parts:
            forget_written(joined)
            with rosbag.Bag(part) as bag:
                for topic, message, time in bag.read_messages(raw=True):
                    joined.write(topic, message, time, raw=True)


def join_tables(parts, target, columns=()):
    """Write tables, one after the other, into another, under the names of its columns."""
    with open(target, 'wb') as joined:
        joined.write((','.join(columns) + '\n').encode() if columns else b'')
        for part in parts:
            with open(part, 'rb') as table:
                for block in iter(lambda: table.read(COPY_BYTES), b''):
                    joined.write(block)


def make_video(bag, topic, target):
    """Write the images on a topic of a bag as a video; whether there are any. Raises InputError."""
    writer, size, count = None, None, 0
    with rosbag.Bag(bag) as images:
        about = images.get_type_and_topic_info([topic]).topics.get(topic)
        rate = min(max((about and about.frequency) or USUAL_RATE, RATES[0]), RATES[1])
        for _, message, _ in images.read_messages([topic]):
            frame = frame_from_compressed(message)
            if writer is None:
                size = frame.shape[1::-1]
                writer = cv2.VideoWriter(target, cv2.VideoWriter.fourcc(*'mp4v'), rate, size)
                if not writer.isOpened():
                    raise InputError('no video of frames of %d x %d pixels can be written. Leave --video out.'
                                     % size)
            writer.write(frame if frame.shape[1::-1] == size else cv2.resize(frame, size))
            count += 1
    if writer is not None:
        writer.release()
        if cv2.VideoCapture(target).get(cv2.CAP_PROP_FRAME_COUNT) != count:  # OpenCV does not say
            raise InputError('its video could not be written whole. Is the disk full?')
    return writer is not None
