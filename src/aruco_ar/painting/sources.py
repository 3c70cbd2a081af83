"""Sources of the picture: a still picture, or a video or GIF that plays in a loop."""
from __future__ import annotations

import os
import re
import time
import warnings
from itertools import count
from typing import IO, Callable, Iterator

import cv2

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import opened
from aruco_ar.base.system import name_for_opencv

from .picture_file import opened_picture, picture_of, shrink_to_warp, too_large

ANIMATED_FORMATS = 'GIF', 'PNG', 'WEBP'  # Pillow's formats that may hold more than one picture
KINDS = 'JPEG, PNG, GIF or MP4'
# 4096 x 2160 has 8.8 million. Larger pictures would take so long to decode that frames are delayed.
MAX_CLIP_PIXELS = 9 * 10**6
DEFAULT_DURATION_S = 0.04  # how long a clip shows a picture if the file does not say
MAX_CATCH_UP_S = 0.05      # frames wait no longer than this while a slow clip catches up
MAX_SKIP_S = 2.0           # a clip does not skip more than this; after a longer pause it continues where it was

# The first bytes of videos: MP4 and QuickTime, Matroska and WebM, AVI, Ogg,
# Flash, Windows Media, MPEG. FFmpeg also accepts other files as videos, such as
# texts that refer it to further files.
VIDEO_START = re.compile(rb'....(ftyp|moov|mdat|free|skip|wide)|\x1aE\xdf\xa3|RIFF....AVI |OggS|FLV|0&\xb2u|'
                         rb'\x00\x00\x01[\xb3\xba]|G(?!IF8).{187}G', re.DOTALL)
START_BYTES = 189

# In a truncated video, FFmpeg searches for the next frame up to the end of the file, which may be far.
TIMEOUTS = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, 5000, cv2.CAP_PROP_READ_TIMEOUT_MSEC, 1000]


def open_source(path: str, say: Callable[[str], None] = warnings.warn) -> Still | Clip:
    """A Still or a Clip from a file: a picture, a GIF, or a video that OpenCV can read.

    ``say`` is called with a sentence if the file cannot be read any more later
    on. Raises InputError if the file is missing, is none of these, or is too
    large: see load_picture for a still picture; the pictures of a clip may
    have MAX_CLIP_PIXELS.
    """
    if not os.path.isfile(path):
        raise InputError('The picture "%s" is not a file; give the full path of a picture or video, or '
                         'topic: and the name of an image topic.' % path)
    with opened(path) as file:
        if is_video(file):
            return Clip(path, _video, say)
    with opened_picture(path, KINDS) as image:
        if image.format not in ANIMATED_FORMATS or not getattr(image, 'is_animated', False):
            return Still(picture_of(image))
    return Clip(path, _animation, say)


def is_video(file: IO[bytes]) -> bool:
    """Whether a file begins as a video does."""
    return bool(VIDEO_START.match(file.read(START_BYTES)))


class Still:
    """A picture that does not move."""

    def __init__(self, picture: Image) -> None:
        self._picture = picture

    def at(self, stamp: float) -> Image:
        """The picture, (h, w, 3 or 4) uint8, whatever the time is."""
        return self._picture


class Clip:
    """A moving picture that plays in a loop, at its own rate, by the stamps of the camera's frames."""

    def __init__(self, path: str, frames: Callable[[str], Iterator[tuple[float, Image]]],
                 say: Callable[[str], None]) -> None:
        """``frames``: a function of the path that iterates once over (duration in seconds, picture)."""
        self._path, self._open, self._say = path, frames, say
        self._frames = frames(path)
        first = next(self._frames, None)
        if first is None:
            raise InputError('OpenCV cannot read "%s" as a video; give another one, such as an MP4.' % path)
        self._duration, self._picture = first
        self._stamp: float | None = None
        self._shown_until = 0.0

    def at(self, stamp: float) -> Image:
        """The picture, (h, w, 3 or 4) uint8, to show at that time, seconds.

        The clip starts at the first stamp. If stamps go back, or after a long
        pause, it continues where it was. If it cannot be decoded fast enough,
        it plays more slowly.
        """
        if self._stamp is None or not 0 <= stamp - self._stamp <= MAX_SKIP_S:
            left = self._duration if self._stamp is None else max(self._shown_until - self._stamp, 0)
            self._shown_until = stamp + left
        self._stamp = stamp
        started = time.monotonic()
        while stamp >= self._shown_until:
            self._advance()
            self._shown_until += self._duration
            if time.monotonic() - started > MAX_CATCH_UP_S:
                self._shown_until = stamp + self._duration
        return self._picture

    def _advance(self) -> None:
        """Go to the next picture, and after the last one to the first."""
        found = self._next()
        if found is None:
            self._frames = self._open(self._path)
            found = self._next()
        if found is None:
            self._say('"%s" cannot be read any more; its last picture stays.' % self._path)
            self._frames, self._duration = iter(()), float('inf')
        else:
            self._duration, self._picture = found

    def _next(self) -> tuple[float, Image] | None:
        """(duration, picture), or None at the end, or if the file has been damaged in the meantime."""
        try:
            return next(self._frames, None)
        except InputError:
            return None


def _animation(path: str) -> Iterator[tuple[float, Image]]:
    """(duration in seconds, picture) of a GIF, animated PNG or WebP."""
    with opened_picture(path, KINDS) as image:
        for number in count():
            try:
                image.seek(number)
            except EOFError:
                return
            _check_size(path, image.width * image.height)
            # Browsers, too, take less than 20 ms for a mistake and show the picture for 100 ms.
            duration = image.info.get('duration', 0) / 1000
            yield duration if duration >= 0.02 else 0.1, picture_of(image)


def _video(path: str) -> Iterator[tuple[float, Image]]:
    """(duration in seconds, picture) of a video."""
    with opened(path) as file:
        capture = cv2.VideoCapture(name_for_opencv(file, path), cv2.CAP_FFMPEG, TIMEOUTS)
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)  # upright as players show it, whatever OpenCV does by itself
    _check_size(path, capture.get(cv2.CAP_PROP_FRAME_WIDTH) * capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
    duration, picture, start = DEFAULT_DURATION_S, None, 0.0
    while capture.grab():
        next_start = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if picture is not None:
            duration = next_start - start if 0 < next_start - start < 60 else duration
            yield duration, shrink_to_warp(picture)
        is_complete, picture = capture.retrieve()
        start = next_start
        if not is_complete:
            break
    if picture is not None:
        yield duration, shrink_to_warp(picture)


def _check_size(path: str, pixels: float) -> None:
    if pixels > MAX_CLIP_PIXELS:
        raise too_large(path, MAX_CLIP_PIXELS)
