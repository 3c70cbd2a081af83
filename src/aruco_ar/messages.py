"""Between sensor_msgs and frames; a frame is (h, w, 3) BGR uint8."""
import cv2
import numpy as np
from cv_bridge import CvBridge, CvBridgeError
from geometry_msgs.msg import Point32, PolygonStamped
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image

from .errors import InputError

JPEG_QUALITY = 80  # what compressed_image_transport uses

_bridge = CvBridge()


def frame_from_image(message):
    """The frame in a sensor_msgs/Image of any color, gray, Bayer or yuv422 encoding.

    Raises InputError if the encoding is no color or gray one, or if the data
    is not what width, height and step promise.
    """
    if message.width == 0 or message.height == 0:
        raise InputError('A frame of %d x %d pixels is empty; check the camera driver.'
                         % (message.width, message.height), kind='empty frame')
    if len(message.data) < message.step * message.height:
        raise InputError('A frame has %d bytes where its step and height promise %d; check the '
                         'camera driver.' % (len(message.data), message.step * message.height),
                         kind='short frame')
    try:
        return _bridge.imgmsg_to_cv2(_without_padding(message), 'bgr8')
    except (CvBridgeError, cv2.error, TypeError) as error:
        raise InputError('A frame with the encoding "%s" cannot be used (%s); set the camera driver '
                         'to one such as rgb8, bgr8, mono8 or yuv422.'
                         % (message.encoding, ' '.join(str(error).split())), kind='encoding') from None


def _without_padding(message):
    """The Image with no bytes between its rows: Debian's cv_bridge takes them for pixels."""
    kind, channels = _bridge.encoding_to_dtype_with_channels(message.encoding)
    row = message.width * channels * np.dtype(kind).itemsize
    if message.step < row:
        raise InputError('A frame has a step of %d bytes where %d pixels of %s take %d; check the '
                         'camera driver.' % (message.step, message.width, message.encoding, row),
                         kind='short step')
    if message.step == row:
        return message
    rows = np.frombuffer(message.data, np.uint8, message.step * message.height)
    data = rows.reshape(message.height, message.step)[:, :row].tobytes()
    return Image(height=message.height, width=message.width, encoding=message.encoding,
                 is_bigendian=message.is_bigendian, step=row, data=data)


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
    """The frame as a sensor_msgs/Image, bgr8 or rgb8, with that header."""
    if encoding == 'rgb8':
        frame = cv2.cvtColor(frame, cv2.COLOR_BGR2RGB)
    return _bridge.cv2_to_imgmsg(frame, encoding, header=header)


def compressed_from_frame(frame, header):
    """The frame as a JPEG sensor_msgs/CompressedImage with that header."""
    _, data = cv2.imencode('.jpg', frame, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return CompressedImage(header=header, format='bgr8; jpeg compressed bgr8', data=data.tobytes())


# How a camera topic's message becomes a frame, for each ~transport: the suffix
# of the topic, the type of the message, and the function.
TRANSPORTS = {
    'raw': ('', Image, frame_from_image),
    'compressed': ('/compressed', CompressedImage, frame_from_compressed),
}


def points_from_pixels(pixels):
    """(n, 2) pixels as a list of geometry_msgs/Point32 with z = 0."""
    return [Point32(float(x), float(y), 0.0) for x, y in pixels]


def polygon_from_pixels(pixels, header):
    """(n, 2) pixels as a geometry_msgs/PolygonStamped."""
    message = PolygonStamped(header=header)
    message.polygon.points = points_from_pixels(pixels)
    return message
