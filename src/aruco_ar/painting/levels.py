"""A picture in several sizes, each half as large as the one before, so that shrinking it skips no pixels."""
from __future__ import annotations

import weakref

import cv2
import numpy as np

from aruco_ar.base.arrays import Image

# The smaller sizes of each picture that cannot change, by the address of the array that owns its pixels. Of the
# parts and views of a picture, only those of the one that was asked for last are kept.
_KEPT: dict[int, tuple[object, list[Image]]] = {}


def levels_of(picture: Image, count: int) -> list[Image]:
    """A picture, (h, w, 3) BGR or (h, w, 4) BGRA, and at most ``count`` smaller ones, each half the one before.

    If the picture is read-only, they are kept for as long as the picture exists.
    """
    owner = picture if picture.base is None else picture.base
    smaller: list[Image] = []
    if isinstance(owner, np.ndarray) and not owner.flags.writeable and not picture.flags.writeable:
        view = picture.ctypes.data, picture.shape, picture.strides
        if id(owner) not in _KEPT:
            weakref.finalize(owner, _KEPT.pop, id(owner), None)
        kept_view, smaller = _KEPT.get(id(owner), (None, smaller))
        if kept_view != view:
            smaller = []
            _KEPT[id(owner)] = view, smaller
    while len(smaller) < count and min((smaller or [picture])[-1].shape[:2]) > 1:
        smaller.append(_half(smaller[-1] if smaller else picture))
    return [picture, *smaller[:count]]


def _half(picture: Image) -> Image:
    """The picture at half its size. Each pixel is the mean of four; an odd side loses its last pixel."""
    picture = picture[:picture.shape[0] // 2 * 2, :picture.shape[1] // 2 * 2]
    if picture.shape[2] == 3:
        return cv2.resize(picture, None, None, 0.5, 0.5, cv2.INTER_AREA)
    # Colors count by their alpha, so that transparent ones do not bleed in.
    alpha = np.asarray(picture[:, :, 3:], np.float32)
    colors = cv2.resize(picture[:, :, :3] * alpha, None, None, 0.5, 0.5, cv2.INTER_AREA)
    mean = cv2.resize(alpha[:, :, 0], None, None, 0.5, 0.5, cv2.INTER_AREA)[:, :, None]
    return np.asarray(np.round(np.concatenate([colors / np.maximum(mean, 1e-3), mean], axis=2)), np.uint8)
