"""Conversion between image messages and frames. A frame is (h, w, 3) BGR uint8."""
import os
import struct
from typing import Any, Dict

import cv2
import numpy as np
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.painting.jpeg_file import JPEG_QUALITY, jpeg_from_frame
from aruco_ar.painting.picture_file import MAX_PICTURE_PIXELS, open_header, with_end
from geometry_msgs.msg import Point32, PolygonStamped
from PIL import Image as Picture
from sensor_msgs.msg import CompressedImage, Image
from unit5.msg import Tag as TagMessage
from unit5.msg import TagArray

from aruco_node.ros_internals.subscribers import tolerant

from .bridge import bytes_of_pixel, convert
from .jpeg import PictureDecoder
from .levels import WHITES, Levels
from .yuv import UYVY, YUY2, order_of

END_OF_VIDEO = 'empty bgr8 frame'  # image_publisher sends one after each round of a video

# Larger frames are refused before memory is allocated for them. OpenCV cannot warp images with longer sides.
MAX_SIDE_PX = 32766
# A PNG of a single gray has about 755 pixels in a byte, and zlib cannot exceed 1032. A JPEG has fewer.
MAX_PIXELS_PER_BYTE = 1100
DEPTH = 'compressedDepth'  # in the format of a depth image, which is neither JPEG nor PNG
MAX_ENCODING = 40  # no name of an encoding is longer, in characters

# The encodings that most cameras send: numbers per pixel, and the code for cv2.cvtColor. cv_bridge takes thirty
# times as long for them. A test checks that the result is the same.
FAST = {'bgr8': (3, None), 'rgb8': (3, cv2.COLOR_RGB2BGR), 'mono8': (1, cv2.COLOR_GRAY2BGR)}

# Encodings that do not say what the numbers mean, as cv2_to_imgmsg(image) gives them, and other names.
READ_AS = {'8uc1': 'mono8', '8uc3': 'bgr8', '8uc4': 'bgra8', '16uc1': 'mono16', '16uc3': 'bgr16',
           '16uc4': 'bgra16', 'mono': 'mono8', 'gray': 'mono8', 'grey': 'mono8', 'y8': 'mono8', 'y16': 'mono16',
           'rgb': 'rgb8', 'bgr': 'bgr8', 'rgba': 'rgba8', 'bgra': 'bgra8', 'uyvy': UYVY, 'yuyv': YUY2,
           'yuy2': YUY2}
BAYER = {'bayer_%s%d' % (order, bits) for order in ('rggb', 'bggr', 'gbrg', 'grbg') for bits in (8, 16)}
IN_CAPITALS = {*FAST, *READ_AS.values(), *BAYER, 'rgb16', 'rgba16'}  # encodings that may be written in capitals
IF_WRONG = {**{'bgr' + rest: ' Name rgb%s if blue looks red.' % rest for rest in ('8', 'a8', '16', 'a16')},
            'mono16': ' If they hold distances, give a topic of colors.'}
# Kinds of notes: how frames are read that do not say what they are, or are not what they say.
ENCODING, LEVELS, END_MARKER, STEP = 'encoding', 'gray levels', 'JPEG', 'step'
NOTES = ENCODING, LEVELS, END_MARKER, STEP


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


class _Decoder:
    """Converts the messages of one image topic to frames, (h, w, 3) BGR uint8, by calling it with each of them.

    ``notes``: {one of NOTES: a sentence}, what a user may not expect in how the last message was read.
    """

    def __init__(self):
        self.notes: Dict[str, str] = {}
        self._levels, self._key = Levels(), None

    def __call__(self, message):
        notes: Dict[str, str] = {}
        try:
            return self._decode(message, notes)
        finally:
            self.notes = notes

    def _decode(self, message, notes):
        raise NotImplementedError

    def _to_8_bits(self, values, name, notes):
        """Values of 16 bits, (h, n), as 8 bits. ``name``: the encoding."""
        key = name, values.shape
        if key != self._key:  # it is another camera, or has other settings
            self._levels, self._key = Levels(), key
        scaled = self._levels.to_8_bits(values, name == 'mono16')
        black, white = self._levels.range
        if (black, white) != (0, WHITES[-1]):
            notes[LEVELS] = 'Frames of %s use only the values from %d to %d, which become black to white.' \
                % (name, black, white)
        return scaled


class ImageDecoder(_Decoder):
    """Converts sensor_msgs/Images of any color encoding that cv_bridge knows, or yuv422_yuy2, to frames.

    16 bits are scaled to 8, by the values that the camera uses. A frame shares no memory with the message.
    Calling it raises InputError if the encoding is not supported, if the frame is empty or too large, or if the
    data does not fit width, height and step.
    """

    def __init__(self, keeps_alpha=False):
        """``keeps_alpha``: whether Images with an alpha channel become (h, w, 4) BGRA uint8."""
        super().__init__()
        self._keeps_alpha = keeps_alpha

    def _decode(self, message, notes):
        if message.width == 0 or message.height == 0:
            raise InputError('A frame of %d x %d pixels is empty. Check the camera driver.'
                             % (message.width, message.height),
                             kind=END_OF_VIDEO if message.encoding == 'bgr8' else 'empty frame')
        check_size(message.width, message.height)
        encoding = message.encoding
        if encoding not in FAST:
            encoding = _encoding_of(encoding, notes)
            rows = _rows(message, encoding, FAST[encoding][0] if encoding in FAST else bytes_of_pixel(encoding),
                         notes)
            if encoding.endswith('16'):
                values = rows.view('>u2' if message.is_bigendian else '<u2').astype(np.uint16, copy=False)
                rows = self._to_8_bits(values, encoding, notes)
                encoding = encoding[:-2] + '8'
            elif encoding in (UYVY, YUY2):
                encoding = _in_true_order(rows, encoding, notes)
            if encoding not in FAST:
                keeps_alpha = self._keeps_alpha and encoding in ('bgra8', 'rgba8')
                return convert(rows, encoding, 'bgra8' if keeps_alpha else 'bgr8')
        else:
            rows = _rows(message, encoding, FAST[encoding][0], notes)
        channels, code = FAST[encoding]
        pixels = rows.reshape((message.height, message.width) + (channels,) * (channels > 1))
        return pixels.copy() if code is None else cv2.cvtColor(pixels, code)


def frame_from_image(message):
    """The frame in a single sensor_msgs/Image, as an ImageDecoder gives it."""
    return ImageDecoder()(message)


def picture_from_image(message):
    """As frame_from_image, but (h, w, 4) BGRA uint8 if the Image has an alpha channel."""
    return ImageDecoder(keeps_alpha=True)(message)


def _encoding_of(encoding, notes):
    """The encoding that a name stands for, if it is clear."""
    if len(encoding) > MAX_ENCODING:
        return encoding
    name = encoding.strip().lower()
    for prefix in 'type_', 'cv_':
        name = name[len(prefix):] if name.startswith(prefix) else name
    read_as = READ_AS.get(name, name)
    if read_as == encoding or read_as not in IN_CAPITALS:
        return encoding
    notes[ENCODING] = 'Frames with the encoding "%s" are read as %s. Name it where they are published: ' \
        'cv2_to_imgmsg(image, "%s").%s' % (encoding.strip(), read_as, read_as, IF_WRONG.get(read_as, ''))
    return read_as


def _in_true_order(rows, encoding, notes):
    """The encoding, UYVY or YUY2, that the bytes of a frame really have."""
    true = order_of(rows, encoding)
    if true != encoding:
        notes[ENCODING] = 'Frames with the encoding %s have their bytes in the order of %s, and are read as ' \
            'such. Set the camera driver to %s.' % (encoding, true, true)
    return true


def _rows(message, encoding, size, notes):
    """An Image's data as a contiguous (h, bytes per row) uint8 array, without the padding of its rows.

    ``size``: how many bytes a pixel of this encoding has.
    """
    row, step = message.width * size, message.step
    if encoding in (UYVY, YUY2) and message.width % 2:
        raise InputError('A frame of %s has %d pixels in a row, but must have an even number. Check the '
                         'camera driver.' % (encoding, message.width), kind='half a pair of pixels')
    if step < row and len(message.data) == row * message.height:  # filled in by hand
        notes[STEP] = 'Frames have a step of %d bytes, but exactly the bytes of rows of %d bytes, and are ' \
            'read as such rows. Set step to %d where they are published.' % (step, row, row)
        step = row
    if step < row:
        raise InputError('A frame has a step of %d bytes, but %d pixels of %s take %d. Check the '
                         'camera driver.' % (message.step, message.width, encoding, row),
                         kind='short step')
    if len(message.data) < step * message.height:
        raise InputError('A frame has %d bytes, but by its step and height it must have %d. Check the '
                         'camera driver.' % (len(message.data), step * message.height),
                         kind='short frame')
    data = np.frombuffer(message.data, np.uint8, step * message.height)
    return np.ascontiguousarray(data.reshape(message.height, step)[:, :row])


def check_size(width, height):
    """Raises InputError if a frame of this size in pixels is too large to be processed."""
    if width * height > MAX_PICTURE_PIXELS or max(width, height) > MAX_SIDE_PX:
        raise _too_large('A frame of %d x %d pixels' % (width, height))


class CompressedDecoder(_Decoder):
    """Converts sensor_msgs/CompressedImages, JPEG or PNG, to frames.

    16 bits are scaled to 8, by the values that the camera uses. A JPEG may lack its end marker. Calling it
    raises InputError if the data is neither, if more of it is missing, or if the frame is too large.
    """

    def __init__(self):
        super().__init__()
        self._decode_picture = PictureDecoder()

    def _decode(self, message, notes):
        try:
            picture, data = _whole(message, notes)
            with picture:
                if picture.mode.startswith('I'):  # 16-bit gray
                    gray = self._to_8_bits(np.asarray(picture).astype(np.uint16), 'mono16', notes)
                    return cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR)
                return self._decode_picture(picture, data)
        except InputError:
            raise
        except Exception:  # Pillow raises many kinds
            raise _undecodable(message) from None


def frame_from_compressed(message):
    """The frame in a single sensor_msgs/CompressedImage, as a CompressedDecoder gives it."""
    return CompressedDecoder()(message)


def check_compressed(message):
    """(width, height) of a CompressedImage, JPEG or PNG. Raises InputError if its header is not usable."""
    with _opened(message, message.data) as picture:
        return picture.size


def _whole(message, notes):
    """The Pillow image in a CompressedImage, and its bytes. A JPEG has the end marker that it lacked."""
    picture = _opened(message, message.data)
    whole = with_end(picture, message.data)
    if whole is message.data:
        return picture, whole
    notes[END_MARKER] = 'The JPEGs lack their end marker, the bytes FF D9. They are used, since nothing else ' \
        'is missing.'
    return _opened(message, whole), whole


def _opened(message, data):
    """The Pillow image of the data of a CompressedImage. Only the header has been read yet."""
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
    if DEPTH in message.format:
        return InputError('A compressed frame (format "%s") is a depth image, which has no colors. Give a '
                          'topic of colors.' % shorten(message.format, 40), kind='depth image')
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


# For each ~image_transport: the suffix of the topic, the class of the message, and that of what decodes frames.
TRANSPORTS = {
    'raw': ('', tolerant(Image), ImageDecoder),
    'compressed': ('/compressed', tolerant(CompressedImage), CompressedDecoder),
}


def points_from_pixels(pixels):
    """Points, (n, 2) pixels, as a list of geometry_msgs/Point32 with z = 0."""
    return [Point32(x, y, 0.0) for x, y in np.asarray(pixels, np.float64).tolist()]


def tags_from_pixels(tags, header):
    """Tags, each a Tag, as a unit5/TagArray."""
    return TagArray(header=header, tags=[
        TagMessage(id=tag.id, corners=points_from_pixels(tag.corners), confidence=tag.confidence)
        for tag in tags])


def polygon_from_pixels(pixels, header):
    """Points, (n, 2) pixels, as a geometry_msgs/PolygonStamped."""
    message = PolygonStamped(header=header)
    message.polygon.points = points_from_pixels(pixels)
    return message
