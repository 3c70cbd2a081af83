"""Writing frames as JPEGs."""
from __future__ import annotations

import cv2

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError

JPEG_QUALITY = 80  # the default of ROS's compressed_image_transport


def jpeg_from_frame(frame: Image, quality: int = JPEG_QUALITY) -> bytes:
    """The frame, (h, w, 3) BGR or (h, w) gray, uint8, as the bytes of a JPEG of this quality, 1 to 100.

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
