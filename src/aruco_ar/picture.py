"""The picture: what is painted into the area."""
from __future__ import annotations

import os

import cv2
import numpy as np

from .arrays import Image
from .errors import InputError

# More than a frame can show; OpenCV warps pictures of less than 32768 px.
MAX_SIDE_PX = 4096


def load_picture(path: str) -> Image:
    """Read a picture: (h, w, 3) BGR or, if it has an alpha channel, (h, w, 4) BGRA, uint8.

    One with a side above MAX_SIDE_PX is shrunk to that. Raises InputError if
    the file is missing or is not a picture.
    """
    if not os.path.isfile(path):
        raise InputError('The picture "%s" is not a file; give the full path of a JPEG or PNG.' % path)
    try:
        with open(path, 'rb') as file:
            data = file.read()
    except OSError as error:
        raise InputError('The picture "%s" cannot be read: %s.' % (path, error.strerror)) from None
    return decode_picture(data, path)


def decode_picture(data: bytes, name: str) -> Image:
    """As load_picture, from the bytes of a file of that name."""
    data = np.frombuffer(data, np.uint8)
    as_stored = _decode(data, cv2.IMREAD_UNCHANGED)
    if as_stored is not None and as_stored.ndim == 3 and as_stored.shape[2] == 4 \
            and as_stored.dtype in (np.uint8, np.uint16):
        picture = as_stored if as_stored.dtype == np.uint8 else (as_stored // 257).astype(np.uint8)
    else:  # only now as color: this turns a photo upright as its camera noted it
        picture = _decode(data, cv2.IMREAD_COLOR)
    if picture is None:
        raise InputError('The picture "%s" is no picture that OpenCV can read; give a JPEG or PNG.' % name)
    return shrink_to_warp(picture)


def shrink_to_warp(picture: Image) -> Image:
    """The picture, (h, w, 3 or 4) uint8, no larger than can be warped."""
    shrink = MAX_SIDE_PX / max(picture.shape[:2])
    return resize(picture, shrink) if shrink < 1 else picture


def resize(image: Image, factor: float) -> Image:
    """The image, (h, w, ...) uint8, made that many times as large, but at least 1 px."""
    size = [max(1, round(side * factor)) for side in image.shape[1::-1]]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR)


def _decode(data: Image, flags: int) -> Image | None:
    try:
        return cv2.imdecode(data, flags)
    except cv2.error:
        return None
