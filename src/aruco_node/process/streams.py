"""What a node prints."""
import io
import logging
import os
import sys


class _Outlet(io.FileIO):
    """Drops what nobody takes: a pipe that is broken, a disk that is full."""

    def write(self, data):
        try:
            return super().write(data)
        except OSError:
            return len(data)


def guard_streams():
    """Have stdout and stderr take everything line by line and never raise, also where they are closed."""
    while os.open(os.devnull, os.O_RDWR) <= 2:  # else a socket gets the number, and what libraries print
        pass
    for number, name in (1, 'stdout'), (2, 'stderr'):
        stream = getattr(sys, name)
        outlet = _Outlet(os.devnull, 'w') if stream is None else _Outlet(number, 'w', closefd=False)
        setattr(sys, name, io.TextIOWrapper(
            io.BufferedWriter(outlet), stream and stream.encoding, 'backslashreplace', line_buffering=True))
    logging.raiseExceptions = False  # a log file that cannot be written is not worth a traceback for each line
