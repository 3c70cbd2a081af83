"""Mixing images pixel by pixel."""
from __future__ import annotations

import cv2

from aruco_ar.base.arrays import Image


def blend(frame: Image, picture: Image, cover: Image) -> Image:
    """The picture where ``cover`` is white, the frame where it is black, and a mixture where it is gray.

    All three are (h, w, 3) uint8, and so is the result.
    """
    return cv2.add(cv2.multiply(frame, cv2.bitwise_not(cover), scale=1 / 255),
                   cv2.multiply(picture, cover, scale=1 / 255))
