"""cv_bridge: what it makes of an Image's pixels, and whether it can work with the NumPy and OpenCV here."""
import importlib.util
import sys
from functools import lru_cache
from importlib.machinery import EXTENSION_SUFFIXES
from os.path import exists, join

import cv2
import numpy as np
from aruco_ar.base.errors import InputError, shorten
from sensor_msgs.msg import Image

NUMPY_2 = b'numpy._core'  # by this name only what is compiled for NumPy 2 calls it
LAST_OPENCV = 4  # with 5 the numbers of its types are others
YUY2, UYVY = 'yuv422_yuy2', 'yuv422'  # the same, but for each two bytes; cv_bridge knows the second


@lru_cache(maxsize=None)
def fault_of_bridge():
    """Why cv_bridge cannot be used, and the remedy, in a sentence; None where it can.

    It may be missing, or built for another Python, NumPy or OpenCV. What is compiled for NumPy 1 ends the
    process when it is called with NumPy 2, and to ask it would be a call: so we look into its file. That can go
    when no distribution has NumPy 1 any more.
    """
    bridge = importlib.util.find_spec('cv_bridge')
    if bridge is None:
        return 'There is no cv_bridge for %s; run script/setup, or install python3-cv-bridge, on Ubuntu ' \
               'ros-noetic-cv-bridge.' % sys.executable
    paths = [join(folder, 'boost', 'cv_bridge_boost' + suffix)
             for folder in bridge.submodule_search_locations or [] for suffix in EXTENSION_SUFFIXES]
    compiled = [path for path in paths if exists(path)]
    if not compiled:
        return "cv_bridge is not built for Python %d.%d; run script/setup, which takes the system's own." \
            % sys.version_info[:2]
    if _major(np) > 1 and not _is_for_numpy_2(compiled[0]):
        return _unfit('NumPy', 1, np, '"numpy<2" "opencv-contrib-python-headless<4.12"')
    if _major(cv2) > LAST_OPENCV:
        return _unfit('OpenCV', LAST_OPENCV, cv2, '"opencv-contrib-python-headless<%d"' % (LAST_OPENCV + 1))
    return None


def bytes_of_pixel(encoding):
    """How many bytes a pixel of an Image takes. Raises InputError if cv_bridge cannot make color of it."""
    fault = fault_of_bridge()
    if fault:
        raise InputError('A frame with the encoding "%s" cannot be used without cv_bridge. %s'
                         % (shorten(encoding, 40), fault), kind='no cv_bridge')
    kind, channels = _type_of(encoding)
    return np.dtype(kind).itemsize * channels


def convert(rows, encoding, big, wanted):
    """An Image's pixels, (h, bytes of a row) uint8, as (h, w, 3) bgr8 or (h, w, 4) bgra8, whichever is wanted.

    ``big``: whether the first byte of a number is the largest. ``encoding``: one that bytes_of_pixel knows.
    """
    kind, channels = _type_of(encoding)
    if encoding == YUY2:
        numbers, encoding = rows.reshape(len(rows), -1, 2)[..., ::-1], UYVY
    else:  # in this machine's own order of bytes: with NumPy 2, cv_bridge fails at the other
        numbers = rows.view(np.dtype(kind).newbyteorder('>' if big else '<')).astype(kind)
    return _bridge().imgmsg_to_cv2(_message(numbers.reshape(len(rows), -1, channels), encoding), wanted)


@lru_cache(maxsize=64)
def _type_of(encoding):
    """The name of the dtype of an encoding, and how many numbers a pixel has."""
    if encoding == YUY2:
        return _type_of(UYVY)
    try:
        kind, channels = _bridge().encoding_to_dtype_with_channels(encoding)
        _bridge().imgmsg_to_cv2(_message(np.zeros((2, 2, channels), kind), encoding), 'bgr8')
    except Exception:  # CvBridgeError, and whatever else
        raise InputError('A frame with the encoding "%s" cannot be used; set the camera driver to one such as '
                         'rgb8, bgr8, mono8 or yuv422.' % shorten(encoding, 40), kind='encoding') from None
    return kind, channels


def _message(numbers, encoding):
    return Image(height=numbers.shape[0], width=numbers.shape[1], encoding=encoding,
                 is_bigendian=sys.byteorder == 'big', data=np.ascontiguousarray(numbers))


def _unfit(name, last, module, wanted):
    return 'cv_bridge is built for %s %d, but %s %s is here; run script/setup, or: pip install %s.' \
        % (name, last, name, module.__version__, wanted)


def _is_for_numpy_2(path):
    with open(path, 'rb') as compiled:
        return NUMPY_2 in compiled.read()


def _major(module):
    return int(module.__version__.partition('.')[0])


@lru_cache(maxsize=None)
def _bridge():
    # Only for frames that need it: it takes 0.2 s, and brings all of the system's OpenCV.
    from cv_bridge import CvBridge
    return CvBridge()
