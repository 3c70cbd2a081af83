"""Conversion between image messages and frames. A frame is (h, w, 3) BGR uint8."""
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

from aruco_node.ros_internals.subscribers import tolerant

from .bridge import bytes_of_pixel, convert

END_OF_VIDEO = 'empty bgr8 frame'  # image_publisher sends one after each round of a video
JPEG_QUALITY = 80  # the default of compressed_image_transport

# Larger frames are refused before memory is allocated for them. OpenCV cannot warp images with longer sides.
MAX_SIDE_PX = 32766
# A PNG of a single gray has about 755 pixels in a byte, and zlib cannot exceed 1032. A JPEG has fewer.
MAX_PIXELS_PER_BYTE = 1100

# The encodings that most cameras send: numbers per pixel, and the code for cv2.cvtColor. cv_bridge takes thirty
# times as long for them. A test checks that the result is the same.
FAST = {'bgr8': (3, None), 'rgb8': (3, cv2.COLOR_RGB2BGR), 'mono8': (1, cv2.COLOR_GRAY2BGR)}


class FrameMessage(Image):
    """A sensor_msgs/Image whose data is any buffer, such as a frame's own memory.

    genpy needs the data as bytes, and copies it twice more. Measured per frame, from array to written message:
    0.03 ms instead of 0.09 ms at 640 x 480 pixels, 0.18 ms instead of 0.77 ms at 1920 x 1080.
    """

    data: Any

    def serialize(self, buff):
        """Write the message to a file-like object, byte for byte as genpy does."""
        data, self.data = self.data, b''
        try:
            super().serialize(buff)
        finally:
            self.data = data
        buff.seek(-4, os.SEEK_CUR)  # go back over the data's length, which is now 0: data is the last field
        buff.write(struct.pack('<I', len(data)))
        buff.write(data)


def frame_from_image(message):
    """The frame in a sensor_msgs/Image, of any color encoding that cv_bridge knows, or yuv422_yuy2.

    16 bits are scaled to 8. The frame shares no memory with the message. Raises InputError if the encoding is
    not supported, if the frame is empty or too large, or if the data does not fit width, height and step.
    """
    return _in_color(message, 'bgr8')


def picture_from_image(message):
    """As frame_from_image, but (h, w, 4) BGRA uint8 if the Image has an alpha channel."""
    return _in_color(message, 'bgra8' if message.encoding.startswith(('bgra', 'rgba')) else 'bgr8')


def _in_color(message, wanted):
    if message.width == 0 or message.height == 0:
        raise InputError('A frame of %d x %d pixels is empty. Check the camera driver.'
                         % (message.width, message.height),
                         kind=END_OF_VIDEO if message.encoding == 'bgr8' else 'empty frame')
    check_size(message.width, message.height)
    if message.encoding not in FAST:
        return convert(_rows(message, bytes_of_pixel(message.encoding)), message.encoding, message.is_bigendian,
                       wanted)
    channels, code = FAST[message.encoding]
    rows = _rows(message, channels)
    pixels = rows.reshape((message.height, message.width) + (channels,) * (channels > 1))
    return pixels.copy() if code is None else cv2.cvtColor(pixels, code)


def _rows(message, bytes_of_pixel):
    """An Image's data as a contiguous (h, bytes per row) uint8 array, without the padding of its rows."""
    row = message.width * bytes_of_pixel
    if message.encoding.startswith('yuv422') and message.width % 2:
        raise InputError('A frame of %s has %d pixels in a row, but must have an even number. Check the '
                         'camera driver.' % (message.encoding, message.width), kind='half a pair of pixels')
    if message.step < row:
        raise InputError('A frame has a step of %d bytes, but %d pixels of %s take %d. Check the '
                         'camera driver.' % (message.step, message.width, message.encoding, row),
                         kind='short step')
    if len(message.data) < message.step * message.height:
        raise InputError('A frame has %d bytes, but by its step and height it must have %d. Check the '
                         'camera driver.' % (len(message.data), message.step * message.height),
                         kind='short frame')
    data = np.frombuffer(message.data, np.uint8, message.step * message.height)
    return np.ascontiguousarray(data.reshape(message.height, message.step)[:, :row])


def check_size(width, height):
    """Raises InputError if a frame of this size in pixels is too large to be processed."""
    if width * height > MAX_PICTURE_PIXELS or max(width, height) > MAX_SIDE_PX:
        raise _too_large('A frame of %d x %d pixels' % (width, height))


def frame_from_compressed(message):
    """The frame in a sensor_msgs/CompressedImage, JPEG or PNG.

    16 bits are scaled to 8. Raises InputError if the data is neither, or if the frame is too large.
    """
    try:
        with _opened(message) as picture:
            if picture.mode.startswith('I'):  # 16-bit gray
                gray = cv2.convertScaleAbs(np.asarray(picture).astype(np.uint16), alpha=255 / 65535)
                return cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR)
            return cv2.cvtColor(np.asarray(picture if picture.mode == 'RGB' else picture.convert('RGB')),
                                cv2.COLOR_RGB2BGR)
    except InputError:
        raise
    except Exception:  # Pillow raises many kinds
        raise _undecodable(message) from None


def check_compressed(message):
    """(width, height) of a CompressedImage, JPEG or PNG. Raises InputError if its header is not usable."""
    with _opened(message) as picture:
        return picture.size


def _opened(message):
    """The Pillow image in a CompressedImage. Only the header of its data has been read yet.

    OpenCV is not used, since its decoders write a line to stderr for each damaged frame.
    """
    data = message.data
    try:
        picture = open_header(data, ('JPEG', 'PNG'))
    except Picture.DecompressionBombError:
        raise _too_large('A compressed frame of %d bytes' % len(data)) from None
    except Exception:  # Pillow raises many kinds
        raise _undecodable(message) from None
    check_size(*picture.size)
    if picture.width * picture.height > MAX_PIXELS_PER_BYTE * len(data):
        raise _undecodable(message)
    return picture


def _too_large(frame):
    return InputError('%s is too large; frames have at most %d million pixels, and %d to a side. Set the '
                      'camera driver to a smaller size, or lower ~scale.'
                      % (frame, MAX_PICTURE_PIXELS // 10**6, MAX_SIDE_PX), kind='large frame')


def _undecodable(message):
    return InputError('A compressed frame (format "%s", %d bytes) cannot be decoded; it must be a complete '
                      'JPEG or PNG.' % (shorten(message.format, 40), len(message.data)),
                      kind='undecodable frame')


def image_from_frame(frame, header, encoding='bgr8'):
    """The frame as a sensor_msgs/Image with this header. ``encoding``: bgr8 or rgb8.

    In bgr8 the message shares the frame's memory, so the frame must not be changed any more. A picture with
    alpha, (h, w, 4) uint8, becomes bgra8.
    """
    if encoding == 'rgb8':
        frame = cv2.cvtColor(frame, cv2.COLOR_BGR2RGB)
    height, width, channels = frame.shape
    return FrameMessage(header=header, height=height, width=width, is_bigendian=0,
                        encoding='bgra8' if channels == 4 else encoding, step=channels * width,
                        data=np.ascontiguousarray(frame).reshape(-1).data)


def compressed_from_frame(frame, header, quality=JPEG_QUALITY):
    """The frame as a sensor_msgs/CompressedImage with this header: a JPEG of this quality, 1 to 100."""
    return CompressedImage(header=header, format='bgr8; jpeg compressed bgr8',
                           data=jpeg_from_frame(frame, quality))


def jpeg_from_frame(frame, quality=JPEG_QUALITY):
    """The frame as the bytes of a JPEG of this quality, 1 to 100.

    Raises InputError if a side is longer than a JPEG allows, 65500 pixels.
    """
    try:
        done, data = cv2.imencode('.jpg', frame, [cv2.IMWRITE_JPEG_QUALITY, quality])
    except cv2.error:  # OpenCV before 4.11
        done = False
    if not done:
        raise InputError('A frame of %d x %d pixels is too large for a JPEG.' % frame.shape[1::-1],
                         kind='frame too large for a JPEG')
    return data.tobytes()


# For each ~transport: the suffix of the topic, the class of the message, and the function that decodes a frame.
TRANSPORTS = {
    'raw': ('', tolerant(Image), frame_from_image),
    'compressed': ('/compressed', tolerant(CompressedImage), frame_from_compressed),
}


def points_from_pixels(pixels):
    """Points, (n, 2) pixels, as a list of geometry_msgs/Point32 with z = 0."""
    return [Point32(float(x), float(y), 0.0) for x, y in pixels]


def tags_from_pixels(tags, header):
    """Tags, pairs of (id, corners), as a unit5/TagArray. The corners are (4, 2) pixels."""
    return TagArray(header=header, tags=[TagMessage(id=tag_id, corners=points_from_pixels(corners))
                                         for tag_id, corners in tags])


def polygon_from_pixels(pixels, header):
    """Points, (n, 2) pixels, as a geometry_msgs/PolygonStamped."""
    message = PolygonStamped(header=header)
    message.polygon.points = points_from_pixels(pixels)
    return message
