"""What a program of this package needs from the first moment on: import this before all else.

It is for programs. It changes the whole process, so a library must not import it, and ``aruco_ar`` does not.
It works by being imported, since NumPy, OpenCV and FFmpeg read their settings while they are imported.
"""
import os
import signal
import sys
import warnings


def _say(kind, error, trace, say=sys.excepthook):
    """Print no traceback for Ctrl-C, nor where a sentence says what is missing or too old."""
    if getattr(error, 'is_whole', False):
        print(error, file=sys.stderr)
    elif not issubclass(kind, KeyboardInterrupt):
        say(kind, error, trace)


sys.excepthook = _say

# All matrices here are small. Threads of NumPy's OpenBLAS would only wait for each other, and take up a whole
# core while they do.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
# We say ourselves, in one sentence, what OpenCV, FFmpeg and Pillow think of a broken file.
os.environ.setdefault('OPENCV_LOG_LEVEL', 'FATAL')
os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')
warnings.filterwarnings('ignore', module='PIL')

# Ctrl-C waits until the imports are done. NumPy would take it for a broken installation.
# On Windows, signals cannot be told to wait.
_waits = hasattr(signal, 'pthread_sigmask')
_before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT]) if _waits else set()
try:
    import aruco_ar  # noqa: F401
finally:
    if _waits:
        signal.pthread_sigmask(signal.SIG_SETMASK, _before)
