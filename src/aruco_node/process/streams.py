"""Output streams that never fail."""
import io
import logging
import os
import sys


class _SafeOutput(io.FileIO):
    """Discards what cannot be written, for example because a pipe is broken or a disk is full."""

    def write(self, data):
        try:
            return super().write(data)
        except OSError:
            return len(data)


def make_streams_safe():
    """Have stdout and stderr write line by line and never raise, even if they are closed.

    Otherwise a node ends with a traceback when it first logs to a full disk. The same happens with a pipe whose
    reader has ended, as with ``| head``.
    """
    # If one of the numbers 0 to 2 is free, the next socket gets it. Whatever libraries print would go there.
    while os.open(os.devnull, os.O_RDWR) <= 2:
        pass
    for number, name in (1, 'stdout'), (2, 'stderr'):
        stream = getattr(sys, name)
        output = _SafeOutput(os.devnull, 'w') if stream is None else _SafeOutput(number, 'w', closefd=False)
        setattr(sys, name, io.TextIOWrapper(
            io.BufferedWriter(output), stream and stream.encoding, 'backslashreplace', line_buffering=True))
    logging.raiseExceptions = False  # no traceback for each line that cannot be written to a log file
