"""A QR code in the terminal, which a phone can read."""
from __future__ import annotations

from typing import TextIO

import cv2
import numpy as np

QUIET = 2  # modules around it that are white
# Of two modules above each other, by whether they are dark: the terminal's text is light on a dark ground, or
# these colors make it so.
BLOCKS = {(False, False): '\u2588', (False, True): '\u2580', (True, False): '\u2584', (True, True): ' '}
ON, OFF = '\x1b[38;2;255;255;255;48;2;0;0;0m', '\x1b[0m'


def can_show(stream: TextIO) -> bool:
    """Whether a stream, such as sys.stdout, is a terminal that shows the blocks."""
    return stream.isatty() and (stream.encoding or '').lower().startswith('utf')


def qr_code(text: str) -> str:
    """A QR code of a text, as lines of blocks in black and white."""
    modules = np.pad(cv2.QRCodeEncoder.create().encode(text) < 128, QUIET)
    if len(modules) % 2:
        modules = np.pad(modules, [(0, 1), (0, 0)])
    rows = zip(modules[::2].tolist(), modules[1::2].tolist())
    return '\n'.join(ON + ''.join(BLOCKS[pair] for pair in zip(*pairs)) + OFF for pairs in rows)
