"""Between sensor_msgs and frames; a frame is (h, w, 3) BGR uint8."""
import os
import struct
from typing import Any

import cv2
import numpy as np
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.painting.picture import MAX_PICTURE_PIXELS, open_header
from geometry_msgs.msg import Point32, PolygonStamped
from PIL import Image as Picture
from sensor_msgs.msg import CompressedImage, Image
from unit5.msg import Tag as TagMessage
from unit5.msg import TagArray

from aruco_node.ros_internals.tolerant import tolerant

from .bridge import bytes_of_pixel, convert

JPEG_QUALITY = 80  # what compressed_image_transport uses


# Frames of more pixels than a picture may have are refused before memory is taken
# for them; and OpenCV warps nothing that is longer than that.
MAX_SIDE_PX = 32766
# A PNG all of one gray takes a byte for about 755 pixels, a JPEG more; zlib cannot do more than 1032.
MAX_PIXELS_A_BYTE = 1100

# What most cameras send, and cv_bridge takes thirty times as long for: the numbers of a pixel, and
# cv2.cvtColor's code. A test holds it equal to what cv_bridge makes of it.
FAST = {'bgr8': (3, None), 'rgb8': (3, cv2.COLOR_RGB2BGR), 'mono8': (1, cv2.COLOR_GRAY2BGR)}


class FrameMessage(Image):
    """A sensor_msgs/Image whose data is any buffer, such as a frame's own memory.

    What genpy makes copies the data twice on its way out, which takes longer
    than painting.
    """

    data: Any

    def serialize(self, buff):
        """Write the message to a file-like object, as every message does."""
        data, self.data = self.data, b''
        try:
            super().serialize(buff)
        finally:
            self.data = data
        buff.seek(-4, os.SEEK_CUR)  # data is the last field: now its length, 0
        buff.write(struct.pack('<I', len(data)))
        buff.write(data)


def frame_from_image(message):
    """The frame in a sensor_msgs/Image, of any color encoding that cv_bridge knows, or yuv422_yuy2.

    16 bits are scaled to 8. It shares no memory with the message. Raises
    InputError if the encoding is another, if the frame is empty or too large,
    or if the data is not what width, height and step promise.
    """
    return _in_color(message, 'bgr8')


def picture_from_image(message):
    """As frame_from_image, but (h, w, 4) BGRA where the Image has an alpha channel."""
    return _in_color(message, 'bgra8' if message.encoding.startswith(('bgra', 'rgba')) else 'bgr8')


def _in_color(message, wanted):
    if message.width == 0 or message.height == 0:
        raise InputError('A frame of %d x %d pixels is empty; check the camera driver.'
                         % (message.width, message.height), kind='empty frame')
    check_size(message.width, message.height)
    if message.encoding not in FAST:
        return convert(_rows(message, bytes_of_pixel(message.encoding)), message.encoding, message.is_bigendian,
                       wanted)
    channels, code = FAST[message.encoding]
    rows = _rows(message, channels)
    pixels = rows.reshape((message.height, message.width) + (channels,) * (channels > 1))
    return pixels.copy() if code is None else cv2.cvtColor(pixels, code)


def _rows(message, bytes_of_pixel):
    """(h, bytes of a row) uint8 of an Image, in one block, without what pads its rows."""
    row = message.width * bytes_of_pixel
    if message.encoding.startswith('yuv422') and message.width % 2:
        raise InputError('A frame of %s has %d pixels in a row, where only even numbers can be; check the '
                         'camera driver.' % (message.encoding, message.width), kind='half a pair of pixels')
    if message.step < row:
        raise InputError('A frame has a step of %d bytes where %d pixels of %s take %d; check the '
                         'camera driver.' % (message.step, message.width, message.encoding, row),
                         kind='short step')
    if len(message.data) < message.step * message.height:
        raise InputError('A frame has %d bytes where its step and height promise %d; check the '
                         'camera driver.' % (len(message.data), message.step * message.height),
                         kind='short frame')
    data = np.frombuffer(message.data, np.uint8, message.step * message.height)
    return np.ascontiguousarray(data.reshape(message.height, message.step)[:, :row])


def check_size(width, height):
    """Raises InputError if a frame of so many pixels is larger than is good for the node."""
    if width * height > MAX_PICTURE_PIXELS or max(width, height) > MAX_SIDE_PX:
        raise _too_large('A frame of %d x %d pixels' % (width, height))


def frame_from_compressed(message):
    """The frame in a sensor_msgs/CompressedImage, JPEG or PNG.

    16 bits are scaled to 8. Raises InputError if the data is neither, or if
    the frame is too large.
    """
    try:
        with _opened(message) as picture:
            if picture.mode.startswith('I'):  # gray of 16 bits
                gray = cv2.convertScaleAbs(np.asarray(picture).astype(np.uint16), alpha=255 / 65535)
                return cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR)
            return cv2.cvtColor(np.asarray(picture if picture.mode == 'RGB' else picture.convert('RGB')),
                                cv2.COLOR_RGB2BGR)
    except InputError:
        raise
    except Exception:  # Pillow raises many kinds
        raise _undecodable(message) from None


def check_compressed(message):
    """Raises InputError if the header of a CompressedImage promises what frame_from_compressed refuses."""
    _opened(message).close()


def _opened(message):
    """The Pillow image in a CompressedImage, of whose data only the header has been read.

    Not by OpenCV, whose decoders write a line to stderr for each frame that is damaged.
    """
    data = message.data
    try:
        picture = open_header(data, ('JPEG', 'PNG'))
    except Picture.DecompressionBombError:
        raise _too_large('A compressed frame of %d bytes' % len(data)) from None
    except Exception:  # Pillow raises many kinds
        raise _undecodable(message) from None
    check_size(*picture.size)
    if picture.width * picture.height > MAX_PIXELS_A_BYTE * len(data):
        raise _undecodable(message)
    return picture


def _too_large(frame):
    return InputError('%s is too large; frames have at most %d million pixels, and %d to a side. Set the '
                      'camera driver, or ~scale, to less.' % (frame, MAX_PICTURE_PIXELS // 10**6, MAX_SIDE_PX),
                      kind='large frame')


def _undecodable(message):
    return InputError('A compressed frame (format "%s", %d bytes) cannot be decoded; it must be a whole JPEG '
                      'or PNG.' % (shorten(message.format, 40), len(message.data)), kind='undecodable frame')


def image_from_frame(frame, header, encoding='bgr8'):
    """The frame as a sensor_msgs/Image, bgr8 or rgb8, with that header.

    In bgr8 the message shares the frame's memory: leave it alone from then on.
    A picture with alpha, (h, w, 4), goes as bgra8.
    """
    if encoding == 'rgb8':
        frame = cv2.cvtColor(frame, cv2.COLOR_BGR2RGB)
    height, width, channels = frame.shape
    return FrameMessage(header=header, height=height, width=width, is_bigendian=0,
                        encoding='bgra8' if channels == 4 else encoding, step=channels * width,
                        data=np.ascontiguousarray(frame).reshape(-1).data)


def compressed_from_frame(frame, header, quality=JPEG_QUALITY):
    """The frame as a JPEG sensor_msgs/CompressedImage of that quality, 1 to 100, with that header."""
    return CompressedImage(header=header, format='bgr8; jpeg compressed bgr8',
                           data=jpeg_from_frame(frame, quality))


def jpeg_from_frame(frame, quality=JPEG_QUALITY):
    """The frame as the bytes of a JPEG of that quality, 1 to 100.

    Raises InputError if it is larger than a JPEG can be, 65500 pixels to a side.
    """
    try:
        done, data = cv2.imencode('.jpg', frame, [cv2.IMWRITE_JPEG_QUALITY, quality])
    except cv2.error:  # OpenCV before 4.11
        done = False
    if not done:
        raise InputError('A frame of %d x %d pixels is too large for a JPEG.' % frame.shape[1::-1],
                         kind='frame too large for a JPEG')
    return data.tobytes()


# How a camera topic's message becomes a frame, for each ~transport: the suffix
# of the topic, the type of the message, and the function.
TRANSPORTS = {
    'raw': ('', tolerant(Image), frame_from_image),
    'compressed': ('/compressed', tolerant(CompressedImage), frame_from_compressed),
}


def points_from_pixels(pixels):
    """(n, 2) pixels as a list of geometry_msgs/Point32 with z = 0."""
    return [Point32(float(x), float(y), 0.0) for x, y in pixels]


def tags_from_pixels(tags, header):
    """Pairs of (id, (4, 2) pixels) as a unit5/TagArray."""
    return TagArray(header=header, tags=[TagMessage(id=tag_id, corners=points_from_pixels(corners))
                                         for tag_id, corners in tags])


def polygon_from_pixels(pixels, header):
    """(n, 2) pixels as a geometry_msgs/PolygonStamped."""
    message = PolygonStamped(header=header)
    message.polygon.points = points_from_pixels(pixels)
    return message
