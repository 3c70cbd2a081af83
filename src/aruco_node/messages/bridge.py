"""Converts an Image's pixels with cv_bridge, if it works with the NumPy and OpenCV that are installed."""
import importlib.util
import sys
from functools import lru_cache
from importlib.machinery import EXTENSION_SUFFIXES
from os.path import exists, join

import cv2
import numpy as np
from aruco_ar.base.errors import InputError, shorten
from sensor_msgs.msg import Image

from .yuv import UYVY, YUY2

NUMPY_2 = b'numpy._core'  # only a module that is compiled for NumPy 2 contains this name
LAST_OPENCV = 4  # OpenCV 5 has other type numbers, which cv_bridge does not know


@lru_cache(maxsize=None)
def fault_of_bridge():
    """Why cv_bridge cannot be used, and the remedy, in a sentence; None if it can be used.

    It may be missing, or built for another Python, NumPy or OpenCV. A module that is compiled for NumPy 1
    crashes the process when it is called with NumPy 2. So its file is searched, and nothing is called. This
    can go when no distribution has NumPy 1 any more.
    """
    bridge = importlib.util.find_spec('cv_bridge')
    if bridge is None:
        return 'There is no cv_bridge for %s; run script/setup, which installs it or says how.' % sys.executable
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
    """The bytes per pixel of an encoding. Raises InputError if cv_bridge cannot convert it to color."""
    fault = fault_of_bridge()
    if fault:
        raise InputError('A frame with the encoding "%s" cannot be used without cv_bridge. %s'
                         % (shorten(encoding, 40), fault), kind='no cv_bridge')
    kind, channels = _type_of(encoding)
    return np.dtype(kind).itemsize * channels


def convert(rows, encoding, wanted):
    """Convert an Image's pixels, (h, bytes per row) uint8, to the encoding that is wanted.

    This is bgr8, (h, w, 3) uint8, or bgra8, (h, w, 4) uint8. ``encoding``: one of 8 bits that bytes_of_pixel
    accepts.
    """
    _, channels = _type_of(encoding)
    pixels = rows.reshape(len(rows), -1, channels)
    if encoding == YUY2:  # each pair of bytes is swapped; cv_bridge knows only UYVY
        pixels, encoding = pixels[..., ::-1], UYVY
    return _bridge().imgmsg_to_cv2(_message(pixels, encoding), wanted)


@lru_cache(maxsize=64)
def _type_of(encoding):
    """(name of the dtype, numbers per pixel) of an encoding.

    Raises InputError if cv_bridge cannot convert it.
    """
    if encoding == YUY2:
        return _type_of(UYVY)
    try:
        kind, channels = _bridge().encoding_to_dtype_with_channels(encoding)
        _bridge().imgmsg_to_cv2(_message(np.zeros((2, 2, channels), kind), encoding), 'bgr8')
    except Exception:  # CvBridgeError and others
        raise InputError('A frame with the encoding "%s" cannot be used. Set the camera driver to an encoding '
                         'such as rgb8, bgr8, mono8 or yuv422.' % shorten(encoding, 40),
                         kind='encoding') from None
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
    # Imported only when a frame needs it: this takes 0.2 s, and loads the system's OpenCV as well.
    from cv_bridge import CvBridge
    return CvBridge()
