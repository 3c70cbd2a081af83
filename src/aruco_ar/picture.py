"""The picture: what is painted into the area."""
import os

import cv2
import numpy as np

from .errors import InputError


def load_picture(path):
    """Read a picture: (h, w, 3) BGR or, if it has an alpha channel, (h, w, 4) BGRA, uint8.

    Raises InputError if the file is missing or is not a picture.
    """
    if not os.path.isfile(path):
        raise InputError('The picture "%s" is not a file; give the path of a JPEG or PNG.' % path)
    try:
        with open(path, 'rb') as file:
            data = np.frombuffer(file.read(), np.uint8)
    except OSError as error:
        raise InputError('The picture "%s" cannot be read: %s.' % (path, error.strerror)) from None
    as_stored = _decode(data, cv2.IMREAD_UNCHANGED)
    if as_stored is not None and as_stored.ndim == 3 and as_stored.shape[2] == 4:
        return as_stored if as_stored.dtype == np.uint8 else (as_stored // 257).astype(np.uint8)
    # Only now as color: this turns a photo upright as its camera noted it, and drops an alpha.
    picture = _decode(data, cv2.IMREAD_COLOR)
    if picture is None:
        raise InputError('The picture "%s" is no picture that OpenCV can read; give a JPEG or PNG.'
                         % path)
    return picture


def _decode(data, flags):
    try:
        return cv2.imdecode(data, flags)
    except cv2.error:
        return None
