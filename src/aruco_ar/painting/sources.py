"""Where a picture comes from over time: a still, or a video or GIF that plays over and over."""
from __future__ import annotations

import os
import re
import time
import warnings
from itertools import count
from typing import Callable, Iterator

import cv2

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import opened

from .picture import opened_picture, picture_of, shrink_to_warp, too_large

ANIMATED = 'GIF', 'PNG', 'WEBP'  # formats of Pillow that may hold more than one picture
KINDS = 'JPEG, PNG, GIF or MP4'
# 4096 x 2160 has 8.8 million. Of more, each would hold up the frames that wait for it.
MAX_CLIP_PIXELS = 9 * 10**6
USUAL_S = 0.04       # for which a picture of a clip is shown that does not say
CATCH_UP_S = 0.05    # the longest for which frames wait for a clip that is behind
MAX_BEHIND_S = 2.0   # a clip that nobody looked at for longer goes on where it was

# How videos begin: MP4 and QuickTime, Matroska and WebM, AVI, Ogg, Flash,
# Windows Media, MPEG. FFmpeg takes much else for one, such as texts that send
# it to other files.
VIDEO = re.compile(rb'....(ftyp|moov|mdat|free|skip|wide)|\x1aE\xdf\xa3|RIFF....AVI |OggS|FLV|0&\xb2u|'
                   rb'\x00\x00\x01[\xb3\xba]|G(?!IF8).{187}G', re.DOTALL)
BEGINNING_BYTES = 189

# Where a video breaks off, FFmpeg looks for its next frame to the end of the file, which may be far.
PATIENCE = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, 5000, cv2.CAP_PROP_READ_TIMEOUT_MSEC, 1000]


def open_source(path: str, say: Callable[[str], None] = warnings.warn) -> Still | Clip:
    """A Still or a Clip from a file: a picture, a GIF, or a video that OpenCV can read.

    ``say`` is called with a sentence when something becomes of the file later
    on. Raises InputError if the file is missing or none of these, and if it is
    too large: what stands still, see load_picture, what moves, of more than
    MAX_CLIP_PIXELS.
    """
    if not os.path.isfile(path):
        raise InputError('The picture "%s" is not a file; give the full path of a picture or video, or '
                         'topic: and the name of an image topic.' % path)
    with opened(path) as file:
        if VIDEO.match(file.read(BEGINNING_BYTES)):
            return Clip(path, _video, say)
    with opened_picture(path, KINDS) as image:
        if image.format not in ANIMATED or not getattr(image, 'is_animated', False):
            return Still(picture_of(image))
    return Clip(path, _animation, say)


class Still:
    """A picture that stays the same."""

    def __init__(self, picture: Image) -> None:
        self._picture = picture

    def at(self, stamp: float) -> Image:
        """The picture."""
        return self._picture


class Clip:
    """A picture that moves with the time of the frames, at its own rate, over and over."""

    def __init__(self, path: str, frames: Callable[[str], Iterator[tuple[float, Image]]],
                 say: Callable[[str], None]) -> None:
        """``frames``: a function of the path that iterates over (seconds, picture) once."""
        self._path, self._open, self._say = path, frames, say
        self._frames = frames(path)
        first = next(self._frames, None)
        if first is None:
            raise InputError('"%s" is no video that OpenCV can read; give another, such as an MP4.' % path)
        self._shown, self._picture = first
        self._stamp: float | None = None
        self._until = 0.0

    def at(self, stamp: float) -> Image:
        """The picture, (h, w, 3 or 4) uint8, that is shown at that time, seconds.

        The clip begins at the first of these times; it goes on where it was
        when time goes back, or when nobody asked for long. One that cannot be
        read as fast as it plays is slower.
        """
        if self._stamp is None or not 0 <= stamp - self._stamp <= MAX_BEHIND_S:
            left = self._shown if self._stamp is None else max(self._until - self._stamp, 0)
            self._until = stamp + left
        self._stamp = stamp
        began = time.monotonic()
        while stamp >= self._until:
            self._advance()
            self._until += self._shown
            if time.monotonic() - began > CATCH_UP_S:
                self._until = stamp + self._shown
        return self._picture

    def _advance(self) -> None:
        """On to the next picture; after the last, to the first."""
        found = self._next()
        if found is None:
            self._frames = self._open(self._path)
            found = self._next()
        if found is None:
            self._say('"%s" cannot be read any more; its last picture stays.' % self._path)
            self._frames, self._shown = iter(()), float('inf')
        else:
            self._shown, self._picture = found

    def _next(self) -> tuple[float, Image] | None:
        """(seconds, picture) or None at the end, which is also where the file has become a broken one."""
        try:
            return next(self._frames, None)
        except InputError:
            return None


def _animation(path: str) -> Iterator[tuple[float, Image]]:
    """(seconds, picture) of a GIF, animated PNG or WebP."""
    with opened_picture(path, KINDS) as image:
        for number in count():
            try:
                image.seek(number)
            except EOFError:
                return
            _check_size(path, image.width * image.height)
            # As browsers do, who take less than 20 ms for a mistake.
            shown = image.info.get('duration', 0) / 1000
            yield shown if shown >= 0.02 else 0.1, picture_of(image)


def _video(path: str) -> Iterator[tuple[float, Image]]:
    """(seconds, picture) of a video."""
    with opened(path) as file:
        # By its number: a path that is no UTF-8 would end the process in OpenCV.
        capture = cv2.VideoCapture('/proc/self/fd/%d' % file.fileno(), cv2.CAP_FFMPEG, PATIENCE)
    _check_size(path, capture.get(cv2.CAP_PROP_FRAME_WIDTH) * capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
    shown, picture, begun = USUAL_S, None, 0.0
    while capture.grab():
        begins = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if picture is not None:
            shown = begins - begun if 0 < begins - begun < 60 else shown
            yield shown, shrink_to_warp(picture)
        whole, picture = capture.retrieve()
        begun = begins
        if not whole:
            break
    if picture is not None:
        yield shown, shrink_to_warp(picture)


def _check_size(path: str, pixels: float) -> None:
    if pixels > MAX_CLIP_PIXELS:
        raise too_large(path, MAX_CLIP_PIXELS)
