"""Frames as H.264, for browsers that are not on this machine: a tenth of the bytes of JPEGs, or less."""
from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError

# No frame waits for a later one, and each is one packet. "superfast" takes as long as "ultrafast", for half of
# the bytes. Everything that plays H.264 knows the baseline profile.
# A browser that is not told which colors are meant takes others for them.
COLORS = ':'.join(name + '=smpte170m' for name in ('colorprim', 'transfer', 'colormatrix'))
OPTIONS = {'preset': 'superfast', 'tune': 'zerolatency', 'profile': 'baseline', 'crf': '26',
           'maxrate': '1400k', 'bufsize': '700k', 'g': '600', 'x264-params': COLORS}
CLOCK = 90000  # ticks per second, as usual; the times are only for the rate of bytes


@lru_cache(maxsize=None)
def can_encode() -> bool:
    """Whether this machine has an encoder for H.264."""
    try:
        _encoder(64, 64)
    except Exception:  # not only ImportError: it may be built for another system, or without x264
        return False
    return True


class VideoStream:
    """The frames that one browser is sent of one image, each as what has changed since the one before."""

    def __init__(self) -> None:
        self._encoder: Any = None

    def restart(self) -> None:
        """The browser has lost the stream, so the next frame begins a new one."""
        self._encoder = None

    def encode(self, frame: Image, seconds: float) -> tuple[bytes, bool]:
        """A frame, (h, w, 3) BGR uint8, as H.264 in Annex B, and whether a stream begins with it.

        ``seconds``: when it was made. A stream also begins when the size changes. An odd last row or column is
        left out. Raises InputError if it cannot be encoded.
        """
        height, width = (side // 2 * 2 for side in frame.shape[:2])
        is_first = self._encoder is None or (self._encoder.width, self._encoder.height) != (width, height)
        if is_first:
            self._encoder, self._began, self._last = _encoder(width, height), seconds, -1
        import av
        even: Any = frame[:height, :width]
        picture = av.VideoFrame.from_ndarray(even, format='bgr24')
        self._last = picture.pts = max(self._last + 1, round((seconds - self._began) * CLOCK))
        picture.time_base = Fraction(1, CLOCK)
        try:
            return b''.join(map(bytes, self._encoder.encode(picture))), is_first
        except av.error.FFmpegError as error:
            self._encoder = None
            raise InputError('A frame of %d x %d pixels cannot be encoded as H.264 (%s).'
                             % (width, height, error)) from None


def _encoder(width: int, height: int) -> Any:
    import av  # when it is needed, since it takes 30 MB
    encoder: Any = av.CodecContext.create('libx264', 'w')
    encoder.width, encoder.height, encoder.pix_fmt = width, height, 'yuv420p'
    encoder.time_base, encoder.framerate = Fraction(1, CLOCK), Fraction(30)
    encoder.thread_count, encoder.options = 1, OPTIONS
    return encoder
