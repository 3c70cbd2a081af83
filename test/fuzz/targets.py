"""The fuzzed functions. Each takes bytes, and raises an error only if the package has a fault.

The bytes are either converted, or refused with an InputError.
"""
import os
import struct
import tempfile

import numpy as np
from aruco_ar import InputError
from aruco_ar.painting.picture_file import MAX_SIDE_PX
from aruco_ar.painting.sources import open_source
from aruco_ar.simulation.robot import load_path
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.images import TRANSPORTS, frame_from_compressed, frame_from_image, picture_from_image
from aruco_node.parameters.parameters import read
from aruco_node.parameters.settings import PictureSettings, load_areas
from genpy import DeserializationError
from sensor_msgs.msg import CompressedImage, Image

ENCODINGS = ('bgr8', 'rgb8', 'bgra8', 'rgba8', 'mono8', 'mono16', 'bgr16', 'rgb16', 'bgra16', 'rgba16',
             'bayer_rggb8', 'bayer_bggr8', 'bayer_gbrg8', 'bayer_grbg8', 'bayer_rggb16', 'bayer_bggr16',
             'bayer_gbrg16', 'bayer_grbg16', 'yuv422', 'yuv422_yuy2', '8UC1', '8UC3', '8UC4', '16UC1', '32FC1',
             '64FC4', '8SC3', 'nv21', 'RGB8', '', 'bgr8\n', '8UC99999999')
HEAD = struct.Struct('<BBHHI')


def image(data):
    """An Image: the bytes begin with its encoding, endianness, width, height and step."""
    if len(data) < HEAD.size:
        return
    encoding, big, width, height, step = HEAD.unpack_from(data)
    if step % 4 < 3:  # mostly one that fits: some bytes per pixel, and a few more
        step = width * (1 + step % 9) + step // 9 % 3
    message = Image(encoding=ENCODINGS[encoding % len(ENCODINGS)], is_bigendian=big, width=width, height=height,
                    step=step, data=data[HEAD.size:])
    _check_image(message)


def serialized(data):
    """An Image as serialized bytes."""
    _, kind, _ = TRANSPORTS['raw']
    message = kind()
    try:
        message.deserialize(data)
    except DeserializationError:  # rospy reports it
        return
    _check_image(message)


def compressed(data):
    """A CompressedImage."""
    frame = _result(lambda: frame_from_compressed(CompressedImage(data=data, format='jpeg')))
    assert frame is None or _is_picture(frame, (3,))


def picture(data):
    """A file as a picture source, which is used for a while."""
    def look(path):
        source = open_source(path, lambda sentence: None)
        for stamp in np.arange(0, 1, 0.2):
            shown = source.at(stamp)
            assert _is_picture(shown, (3, 4)) and max(shown.shape) <= MAX_SIDE_PX
    _with_file(look, data)


def wall(data):
    """The YAML file of a wall."""
    def load(path):
        found = load_wall(path)
        assert len(found.area) in (0, 4) and np.isfinite(found.area_corners).all()
        for tag in found.tags:
            cells, corners = found.paper(tag)
            assert cells.dtype == np.uint8 and np.isfinite(corners).all()
    _with_file(load, data)


def areas(data):
    """The YAML file of several areas."""
    def load(path):
        for entry in load_areas(path):
            assert len(set(read(PictureSettings, entry.get).ids)) == 4
    _with_file(load, data)


def path(data):
    """The YAML file of a path."""
    def load(path):
        drive = load_path(path)
        assert drive.seconds > 0
        for seconds in (0, 0.1, 1e6):
            assert np.isfinite(drive.at(seconds)[0]).all()
    _with_file(load, data)


TARGETS = {target.__name__: target for target in (image, serialized, compressed, picture, wall, areas, path)}


def _check_image(message):
    for make, channels in ((frame_from_image, (3,)), (picture_from_image, (3, 4))):
        frame = _result(lambda: make(message))
        assert frame is None or _is_picture(frame, channels)
        assert frame is None or frame.shape[:2] == (message.height, message.width)


def _is_picture(frame, channels):
    return frame.dtype == np.uint8 and frame.ndim == 3 and frame.shape[2] in channels and frame.size > 0


def _with_file(use, data):
    handle, path = tempfile.mkstemp(prefix='unit5-fuzz-', dir='/dev/shm' if os.path.isdir('/dev/shm') else None)
    try:
        with os.fdopen(handle, 'wb') as file:
            file.write(data)
        sentence = _result(lambda: use(path), str)
        assert sentence is None or path in sentence, sentence
    finally:
        os.unlink(path)


def _result(make, refused=lambda error: None):
    """The result of ``make``, or that of ``refused`` for an InputError. Its message must be a good sentence."""
    try:
        return make()
    except InputError as error:
        sentence = str(error)
        assert sentence.isprintable() and sentence[-1] == '.' and len(sentence) <= 500, sentence
        return refused(error)
