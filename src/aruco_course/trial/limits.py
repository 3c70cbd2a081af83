"""What the learner's code may use of the machine before it is stopped."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """``call``: seconds for each call of the function; ``load``: for the import of the file, or for the whole
    program; ``total``: for all calls. ``memory``: bytes beyond what Python with NumPy and OpenCV takes.
    ``printed``: bytes of output.
    """

    call: float = 5.0
    load: float = 20.0
    total: float = 20.0
    memory: int = 1 << 30
    printed: int = 1 << 20
