"""Writing a video that browsers and phones play: MP4 with H.264."""
from __future__ import annotations

from contextlib import contextmanager
from fractions import Fraction
from typing import Any, Callable, Iterator

import cv2

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.versions import SetupError, need

RATES = 1.0, 240.0  # lowest and highest frames per second of a video
FROM_THE_START = {'movflags': '+faststart'}  # a browser plays it before all of it has arrived
PIXELS = 'yuv420p'  # browsers play no others; the sides of such a frame are even
QUALITY = {'crf': '20', 'preset': 'veryfast'}


def need_video(instead: str) -> None:
    """Raise InputError if the library that writes videos is missing. ``instead``: what to do without it."""
    try:
        need('av')
    except SetupError as error:
        raise InputError('%s Or %s.' % (error, instead)) from None


@contextmanager
def video_writer(path: str, rate: float, name: str) -> Iterator[Callable[[Image], None]]:
    """A function that adds a frame, (h, w, 3) BGR uint8, to a new video, for a ``with`` block.

    ``rate``: frames per second; RATES limit it. ``name``: what the video is called in the end, for errors. All
    frames get the size of the first one, its sides made even. Raises InputError if the video cannot be written.
    Call need_video first.
    """
    import av
    rate = min(max(rate, RATES[0]), RATES[1])
    try:
        with av.open(path, 'w', format='mp4', options=FROM_THE_START) as video:
            stream: Any = video.add_stream('libx264', rate=Fraction(rate).limit_denominator(1000))
            stream.pix_fmt, stream.options = PIXELS, {**QUALITY}

            def add(frame: Image) -> None:
                if not stream.width:
                    height, width = frame.shape[:2]
                    stream.width, stream.height = max(width // 2, 1) * 2, max(height // 2, 1) * 2
                size = stream.width, stream.height
                even: Any = frame if frame.shape[1::-1] == size else cv2.resize(frame, size)
                video.mux(stream.encode(av.VideoFrame.from_ndarray(even, format='bgr24')))
            yield add
            video.mux(stream.encode())
    except (av.error.FFmpegError, OSError) as error:
        raise InputError('The video "%s" cannot be written (%s). Is there such a folder, and room in it?'
                         % (name, error)) from None
