"""Between sensor_msgs and frames; a frame is (h, w, 3) BGR uint8."""
import os
import struct
from typing import Any

import cv2
import numpy as np
from aruco_ar.errors import InputError
from cv_bridge import CvBridge, CvBridgeError
from geometry_msgs.msg import Point32, PolygonStamped
from sensor_msgs.msg import CompressedImage, Image
from unit5.msg import Tag as TagMessage
from unit5.msg import TagArray

JPEG_QUALITY = 80  # what compressed_image_transport uses

# rospy drops stale messages only within what one read of the socket returned,
# so a read must have room for more than the largest frame: here one of 4K in
# 16 bits and three colors, with some to spare.
BUFFER_BYTES = 64 * 1024 * 1024

_bridge = CvBridge()


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
    """The frame in a sensor_msgs/Image of any color, gray, Bayer or yuv422 encoding.

    It shares no memory with the message. Raises InputError if the encoding is
    no color or gray one, or if the data is not what width, height and step promise.
    """
    if message.width == 0 or message.height == 0:
        raise InputError('A frame of %d x %d pixels is empty; check the camera driver.'
                         % (message.width, message.height), kind='empty frame')
    if len(message.data) < message.step * message.height:
        raise InputError('A frame has %d bytes where its step and height promise %d; check the '
                         'camera driver.' % (len(message.data), message.step * message.height),
                         kind='short frame')
    try:
        if message.encoding in ('bgr8', 'rgb8'):
            return _frame_from_color(message)
        return _bridge.imgmsg_to_cv2(_without_padding(message), 'bgr8')
    except (CvBridgeError, cv2.error, TypeError) as error:
        raise InputError('A frame with the encoding "%s" cannot be used (%s); set the camera driver '
                         'to one such as rgb8, bgr8, mono8 or yuv422.'
                         % (message.encoding, ' '.join(str(error).split())), kind='encoding') from None


def _frame_from_color(message):
    """The frame in a bgr8 or rgb8 Image, copied once, where cv_bridge copies twice."""
    pixels = _rows(message, 3 * message.width).reshape(message.height, message.width, 3)
    return pixels.copy() if message.encoding == 'bgr8' else cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)


def _rows(message, row):
    """(h, row) uint8: what is in an Image without what may be between its rows of that many bytes."""
    if message.step < row:
        raise InputError('A frame has a step of %d bytes where %d pixels of %s take %d; check the '
                         'camera driver.' % (message.step, message.width, message.encoding, row),
                         kind='short step')
    data = np.frombuffer(message.data, np.uint8, message.step * message.height)
    return np.ascontiguousarray(data.reshape(message.height, message.step)[:, :row])


def _without_padding(message):
    """The Image with no bytes between its rows: Debian's cv_bridge takes them for pixels."""
    kind, channels = _bridge.encoding_to_dtype_with_channels(message.encoding)
    row = message.width * channels * np.dtype(kind).itemsize
    if message.step == row:
        return message
    data = _rows(message, row).tobytes()
    return Image(height=message.height, width=message.width, encoding=message.encoding,
                 is_bigendian=message.is_bigendian, step=row, data=data)


def picture_from_image(message):
    """As frame_from_image, but (h, w, 4) BGRA where the Image has an alpha channel."""
    frame = frame_from_image(message)
    if message.encoding not in ('bgra8', 'rgba8'):
        return frame
    return _bridge.imgmsg_to_cv2(_without_padding(message), 'bgra8').copy()


def frame_from_compressed(message):
    """The frame in a sensor_msgs/CompressedImage, JPEG or PNG.

    Raises InputError if the data is neither.
    """
    frame = None
    if message.data:
        try:
            frame = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
        except cv2.error:
            pass
    if frame is None:
        raise InputError('A compressed frame (format "%s", %d bytes) cannot be decoded; it must be '
                         'JPEG or PNG.' % (message.format, len(message.data)),
                         kind='undecodable frame')
    return frame


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


def compressed_from_frame(frame, header):
    """The frame as a JPEG sensor_msgs/CompressedImage with that header."""
    return CompressedImage(header=header, format='bgr8; jpeg compressed bgr8', data=jpeg_from_frame(frame))


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
    'raw': ('', Image, frame_from_image),
    'compressed': ('/compressed', CompressedImage, frame_from_compressed),
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
