"""The frames that are painted: those of a video, a photo, or a camera."""
from __future__ import annotations

import os
import time
from itertools import islice
from typing import Iterator

import cv2
from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import opened
from aruco_ar.base.system import name_for_opencv
from aruco_ar.painting.sources import TIMEOUTS

USUAL_RATE = 30.0          # frames per second, if the file or the camera does not say
RATES = 1.0, 1000.0        # a file that says another rate is not believed


def filmed(camera: str) -> Iterator[tuple[float, Image]]:
    """(seconds by time.time, frame) of a camera, live: see Footage.of_camera. A file has its own rate."""
    began, is_file, footage = time.monotonic(), os.path.isfile(camera), Footage.of_camera(camera)
    for number, (_, frame) in enumerate(footage):
        if is_file:
            time.sleep(max(0.0, began + number / footage.rate - time.monotonic()))
        yield time.time(), frame


class Footage:
    """Frames, (h, w, 3) BGR uint8, upright as players show them.

    ``rate``: frames per second. ``is_photo``: whether it is a single photo. Iterating yields (seconds, frame),
    once. ``length_hint`` tells how many there are, if that is known.
    """

    def __init__(self, capture: cv2.VideoCapture, photo: Image | None, name: str, is_live: bool) -> None:
        self._capture, self._photo, self._name, self._is_live = capture, photo, name, is_live
        rate = capture.get(cv2.CAP_PROP_FPS)
        self.rate = rate if RATES[0] <= rate <= RATES[1] else USUAL_RATE
        self.is_photo = photo is not None

    @classmethod
    def of_file(cls, path: str) -> Footage:
        """Raises InputError if there is no such file, or if it is neither a video nor a photo."""
        if not os.path.exists(path):
            raise InputError('There is no file "%s". Give the path of a video or a photo.' % path)
        with opened(path) as file:
            name = name_for_opencv(file, path)
            photo = cv2.imread(name) if cv2.haveImageReader(name) else None
            capture = cv2.VideoCapture() if photo is not None else \
                cv2.VideoCapture(name, cv2.CAP_FFMPEG, TIMEOUTS)
        if photo is None and not capture.isOpened():
            raise InputError('"%s" is neither a video nor a photo that OpenCV can read.' % path)
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)
        return cls(capture, photo, path, False)

    @classmethod
    def of_camera(cls, text: str) -> Footage:
        """``text``: the number of a webcam, or an address such as rtsp://... Raises InputError without it."""
        capture = cv2.VideoCapture(int(text) if text.isdecimal() else text)
        if not capture.isOpened():
            raise InputError('The camera %s cannot be opened. Is it plugged in, may you use it, and does no '
                             'other program? The first one is --camera 0.' % text)
        return cls(capture, None, text, True)

    def stills(self, count: int) -> list[Image]:
        """Some of its frames, evenly chosen; of a camera, the next ones. Read a file anew after that."""
        if self._photo is not None:
            return [self._photo]
        if self._is_live:
            return [frame for _, frame in islice(self, count)]
        whole, found = max(int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT)), count), []
        for number in range(count):
            self._capture.set(cv2.CAP_PROP_POS_FRAMES, (2 * number + 1) * whole // (2 * count))
            is_read, frame = self._capture.read()
            found += [frame] if is_read else []
        return found

    def __length_hint__(self) -> int:
        return 1 if self.is_photo else max(int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT)), 0)

    def __iter__(self) -> Iterator[tuple[float, Image]]:
        if self._photo is not None:
            yield 0.0, self._photo
            return
        number, began = 0, time.monotonic()
        while True:
            is_read, frame = self._capture.read()
            if not is_read:
                break
            yield time.monotonic() - began if self._is_live else number / self.rate, frame
            number += 1
        if not number:
            raise InputError('No frame of "%s" can be read.' % self._name)
