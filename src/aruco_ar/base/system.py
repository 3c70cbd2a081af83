"""What Linux, macOS and Windows do in different ways. All else in the package is the same on each of them."""
from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from typing import IO

NO_UNNAMED_FILES = errno.EOPNOTSUPP, errno.EISDIR  # from file systems without O_TMPFILE
OPEN_FILES = '/proc/self/fd'  # where Linux shows a process its own open files


def open_at_once(path: str) -> int:
    """A descriptor of a file to read from. Does not wait, even if the file has become a pipe by now.

    Windows keeps its pipes in a place of their own, where no file is replaced by one. But without O_BINARY, it
    takes files for text, and changes their bytes.
    """
    return os.open(path, os.O_RDONLY | getattr(os, 'O_NONBLOCK', 0) | getattr(os, 'O_BINARY', 0))


def open_unnamed(folder: str) -> int | None:
    """A descriptor of a new file without a name, to write to, on the disk of a folder.

    None if there are none: only Linux has them, and not on every disk. See give_name.
    """
    if not hasattr(os, 'O_TMPFILE'):
        return None
    try:
        return os.open(folder, os.O_TMPFILE | os.O_WRONLY, 0o666)
    except OSError as error:
        if error.errno not in NO_UNNAMED_FILES:
            raise
        return None


def give_name(handle: int, path: str) -> None:
    """Let an unnamed file, which is still open, appear at a path."""
    # Python follows the link in /proc only if it gets the descriptor of a folder. An absolute path
    # needs none, so any descriptor will do.
    os.link('%s/%d' % (OPEN_FILES, handle), path, src_dir_fd=handle)


def name_for_opencv(file: IO[bytes], path: str) -> str:
    """The name under which OpenCV opens a file that is open. ``path``: its path.

    On Linux, it is named by its descriptor, since OpenCV ends the process for a path that is not UTF-8.
    Elsewhere, raises UnicodeEncodeError for such a path.
    """
    if os.path.isdir(OPEN_FILES):
        return '%s/%d' % (OPEN_FILES, file.fileno())
    path.encode()
    return os.path.abspath(path)


def lock(handle: int) -> None:
    """Wait until no other process has this file locked, and lock it until it is closed.

    Raises OSError if the disk has no locks, or, on Windows, if another process keeps it for ten seconds.
    Raises ImportError if the system has none.
    """
    if sys.platform == 'win32':
        import msvcrt
        msvcrt.locking(handle, msvcrt.LK_LOCK, 1)
    else:
        import fcntl
        fcntl.flock(handle, fcntl.LOCK_EX)


def is_typed(stdin: IO[str], seconds: float) -> bool:
    """Whether something is typed into a terminal within that time. Windows tells it before Enter."""
    if sys.platform == 'win32':
        import msvcrt
        time.sleep(seconds)  # Windows can wait for sockets only
        return msvcrt.kbhit()
    import select
    return bool(select.select([stdin], [], [], seconds)[0])


def end_with_children(process: subprocess.Popen[bytes]) -> None:
    """End a process that was started in a session of its own, and those that it has started."""
    if hasattr(os, 'killpg'):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        return
    with suppress(OSError):  # Windows has no sessions; this finds the children while their parent still runs
        subprocess.run(['taskkill', '/f', '/t', '/pid', str(process.pid)], stdin=subprocess.DEVNULL,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    process.kill()


def knows_escapes() -> bool:
    """Whether terminals understand ANSI's escapes. The old console of Windows shows them as they are."""
    return sys.platform != 'win32' or 'WT_SESSION' in os.environ or 'TERM' in os.environ
