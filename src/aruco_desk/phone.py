"""A phone as the camera: its browser sends what it films to the page's server."""
from __future__ import annotations

import threading
import time
from typing import Iterator

import cv2
import numpy as np
from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.painting.picture_file import open_header

WAIT_S = 3.0  # a phone that sends nothing for this time has been put away
FORMATS = 'JPEG',
MAX_PIXELS = 9 * 10**6  # 4096 x 2160 has 8.8 million


class Phone:
    """The frames that a browser sends. Iterating yields the newest, as (seconds by time.time, frame)."""

    def __init__(self) -> None:
        self._newest: tuple[float, bytes] | None = None
        self._changed, self._ended = threading.Condition(), False

    def take(self, jpeg: bytes) -> None:
        """A frame has arrived, the bytes of a JPEG. Call it from any thread."""
        with self._changed:
            self._newest = time.time(), jpeg
            self._changed.notify_all()

    def end(self) -> None:
        """Iterating ends."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def __iter__(self) -> Iterator[tuple[float, Image]]:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._newest is not None or self._ended, WAIT_S)
                if self._ended:
                    return
                if self._newest is None:
                    raise InputError('No phone films. Open this page on the phone, and touch "Film with this '
                                     'device".')
                (stamp, jpeg), self._newest = self._newest, None
            yield stamp, decoded(jpeg)


def decoded(jpeg: bytes) -> Image:
    """The frame, (h, w, 3) BGR uint8, of the bytes of a JPEG. Raises InputError."""
    try:
        with open_header(jpeg, FORMATS) as image:
            pixels = image.width * image.height
        frame = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) if pixels <= MAX_PIXELS else None
    except Exception:  # Pillow raises many kinds
        frame = None
    if frame is None:
        raise InputError('The phone sends frames that are no JPEGs of at most %d million pixels.'
                         % (MAX_PIXELS // 10**6))
    return np.asarray(frame)
