"""What is done before numpy and OpenCV are imported, and while they are."""
import sys

from .versions import TooOld, need


def _say(kind, error, trace, say=sys.excepthook):  # type: ignore[no-untyped-def]  # typing would be read before
    """Ctrl-C ends a program, also one that is just beginning: nobody wants to read where it was.

    Nor where it was found out that something is too old.
    """
    if issubclass(kind, TooOld):
        print(error, file=sys.stderr)
    elif not issubclass(kind, KeyboardInterrupt):
        say(kind, error, trace)


sys.excepthook = _say

import os  # noqa: E402
import signal  # noqa: E402

# All matrices here are small. Threads of numpy's OpenBLAS would only wait for
# each other, and take up a whole core while they do; it has to know beforehand.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
# What OpenCV and its FFmpeg think of a broken file is said by us, once, in a sentence.
os.environ.setdefault('OPENCV_LOG_LEVEL', 'FATAL')
os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')

# A Ctrl-C waits for so long: numpy takes one for a broken installation.
_before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
try:
    for each in 'python', 'numpy', 'cv2', 'PIL':
        need(each)
finally:
    signal.pthread_sigmask(signal.SIG_SETMASK, _before)
