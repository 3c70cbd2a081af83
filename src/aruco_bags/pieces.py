"""Joins the output of pieces."""
from fractions import Fraction

import cv2
import rosbag
from aruco_ar.base.errors import InputError
from aruco_ar.base.progress import progress
from aruco_ar.base.versions import SetupError, need
from aruco_node.messages.images import frame_from_compressed
from aruco_node.ros_internals.indexed_bag import forget_written

COPY_BYTES = 1 << 20
DEFAULT_RATE = 30.0  # frames per second of a video with a single frame
RATES = 1.0, 240.0  # lowest and highest frames per second of a video
FROM_THE_START = {'movflags': '+faststart'}  # a browser plays it before all of it has arrived
PIXELS = 'yuv420p'  # browsers play no others; the sides of such a frame are even
QUALITY = {'crf': '20', 'preset': 'veryfast'}


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


def need_video():
    """Raise InputError if the library that writes videos is missing: ROS has no package for it."""
    try:
        need('av')
    except SetupError as error:
        raise InputError('%s Or leave out --video.' % error) from None


def make_video(bag, topic, target):
    """Write the images on a topic of a bag as an MP4 with H.264, as browsers and phones play it.

    Returns whether there are any. Raises InputError if the video cannot be written. Call need_video first.
    """
    import av
    with rosbag.Bag(bag) as images:
        about = images.get_type_and_topic_info([topic]).topics.get(topic)
        if about is None:
            return False
        rate = min(max(about.frequency or DEFAULT_RATE, RATES[0]), RATES[1])
        try:
            with av.open(target, 'w', format='mp4', options=FROM_THE_START) as video:
                stream = video.add_stream('libx264', rate=Fraction(rate).limit_denominator(1000))
                stream.pix_fmt, stream.options = PIXELS, {**QUALITY}
                for _, message, _ in progress(images.read_messages([topic]), 'video', about.message_count):
                    frame = frame_from_compressed(message)
                    if not stream.width:
                        height, width = frame.shape[:2]
                        stream.width, stream.height = max(width // 2, 1) * 2, max(height // 2, 1) * 2
                    size = stream.width, stream.height
                    frame = frame if frame.shape[1::-1] == size else cv2.resize(frame, size)
                    video.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format='bgr24')))
                video.mux(stream.encode())
        except (av.error.FFmpegError, OSError) as error:
            raise InputError('its video could not be written (%s). Is the disk full? Otherwise leave out '
                             '--video.' % error) from None
    return True
