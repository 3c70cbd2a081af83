"""Where a picture comes from over time: a still, or a video or GIF that plays over and over."""
from __future__ import annotations

import os
import time
import warnings
from typing import Callable, Iterator

import cv2
import numpy as np
import PIL.Image

from .arrays import Image
from .errors import InputError
from .picture import load_picture, shrink_to_warp

ANIMATED = 'GIF', 'PNG', 'WEBP'  # formats of Pillow that may hold more than one picture
USUAL_S = 0.04       # for which a picture of a clip is shown that does not say
CATCH_UP_S = 0.05    # the longest for which frames wait for a clip that is behind
MAX_BEHIND_S = 2.0   # a clip that nobody looked at for longer goes on where it was


def open_source(path: str, say: Callable[[str], None] = warnings.warn) -> Still | Clip:
    """A Still or a Clip from a file: a picture, a GIF, or a video that OpenCV can read.

    ``say`` is called with a sentence when something becomes of the file later
    on. Raises InputError if the file is missing or is none of these.
    """
    try:
        with PIL.Image.open(path) as image:
            moving = image.format in ANIMATED and getattr(image, 'is_animated', False)
    except Exception:  # whatever Pillow cannot make out, OpenCV may
        moving = False
    if moving:
        return Clip(path, _animation, say)
    if not os.path.isfile(path):
        raise InputError('The picture "%s" is not a file; give the full path of a picture or video, or '
                         'topic: and the name of an image topic.' % path)
    if cv2.haveImageReader(path):
        return Still(load_picture(path))
    return Clip(path, _video, say)


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
            raise InputError('"%s" is neither a picture nor a video that OpenCV can read; give a JPEG, '
                             'PNG, GIF or MP4.' % path)
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
        found = next(self._frames, None)
        if found is None:
            self._frames = self._open(self._path)
            found = next(self._frames, None)
        if found is None:
            self._say('"%s" cannot be read any more; its last picture stays.' % self._path)
            self._frames, self._shown = iter(()), float('inf')
        else:
            self._shown, self._picture = found


def _animation(path: str) -> Iterator[tuple[float, Image]]:
    """(seconds, picture) of a GIF, animated PNG or WebP."""
    try:
        with PIL.Image.open(path) as image:
            for number in range(image.n_frames):
                image.seek(number)
                picture = cv2.cvtColor(np.asarray(image.convert('RGBA')), cv2.COLOR_RGBA2BGRA)
                if picture[..., 3].min() == 255:
                    picture = np.ascontiguousarray(picture[..., :3])
                # As browsers do, who take less than 20 ms for a mistake.
                shown = image.info.get('duration', 0) / 1000
                yield shown if shown >= 0.02 else 0.1, shrink_to_warp(picture)
    except Exception:  # whatever Pillow raises where the file is broken: that is its end
        return


def _video(path: str) -> Iterator[tuple[float, Image]]:
    """(seconds, picture) of a video."""
    capture = cv2.VideoCapture(path, cv2.CAP_FFMPEG)
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
