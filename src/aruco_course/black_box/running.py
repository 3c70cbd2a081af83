"""A learner's program while it runs: what it has printed, whether it still does something, and its end."""
from __future__ import annotations

import glob
import os
import re
import signal
import subprocess
import threading
import time
from contextlib import suppress
from typing import Mapping, NamedTuple, Sequence

KEPT_BYTES = 64 * 1024  # of what it printed last
READ_BYTES = 64 * 1024
STOP_S = 5.0            # a node that is asked to end has this time
REAP_S = 10.0
TRACEBACK = 'Traceback (most recent call last):'
# The last line of a traceback: AttributeError: module 'cv2.aruco' has no attribute 'Dictionary_get'
RAISED = re.compile(r'([A-Za-z_][\w.]*)(?:: (.*))?$', re.DOTALL)
PLACE = re.compile(r'  File "([^"]+)", line (\d+)')
THROWN = re.compile(r"terminate called after throwing an instance of '([^']+)'(?:\n  what\(\): +(.*))?")
# What faulthandler prints above the stack of each thread.
STACK = re.compile(r'(?:Current thread|Thread) 0x[^\n]*\(most recent call first\):')


class Raised(NamedTuple):
    """An exception that a program has printed. ``line``: that of its own file, or None."""

    kind: str
    message: str
    line: int | None


class Program:
    """A running program, in a process group of its own, so that all that it starts ends with it.

    ``file``: its path.
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str], folder: str,
                 changed: threading.Condition) -> None:
        """``folder``: where it runs. ``changed`` is notified when it prints something, and when it ends.

        Raises OSError if it cannot be started.
        """
        self.file, self._changed = command[0], changed
        self._output, self._cut = bytearray(), 0
        self._process = subprocess.Popen(command, env=dict(environment), cwd=folder, start_new_session=True,
                                         stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                         stderr=subprocess.STDOUT)
        self._busy = _Busy(self._process.pid)
        self._code: int | None = None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        threading.Thread(target=self._wait, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stream:
            while True:
                data = os.read(stream.fileno(), READ_BYTES)
                if not data:
                    return
                with self._changed:
                    self._output += data
                    self._cut += max(0, len(self._output) - KEPT_BYTES)
                    del self._output[:-KEPT_BYTES]
                    self._changed.notify_all()

    def _wait(self) -> None:
        code = self._process.wait()
        self._reader.join(1.0)  # what it printed last says why it ended; others that it started may print on
        with self._changed:
            self._code = code
            self._changed.notify_all()

    @property
    def group(self) -> int:
        """The id of its process group."""
        return self._process.pid

    @property
    def code(self) -> int | None:
        """What it returned, negative for a signal, or None while it runs."""
        return self._code

    @property
    def printed(self) -> str:
        """What it has printed, at most the last 64 kB."""
        return self._output.decode(errors='replace')

    @property
    def count(self) -> int:
        """How many bytes it has printed."""
        return self._cut + len(self._output)

    def is_idle(self, seconds: float) -> bool:
        """Whether its processes have done nothing for that time: they wait, and for nothing on a disk."""
        return self._busy.idle_s() >= seconds

    def raised(self) -> Raised | None:
        """The last exception that it printed, with its traceback or as C++ does."""
        printed = self.printed
        found = [_raised(part, self.file) for part in printed.split(TRACEBACK)[1:]]
        thrown = [Raised(kind, message or '', None) for kind, message in THROWN.findall(printed)]
        return next(filter(None, [*thrown[::-1], *found[::-1]]), None)

    def line_at_work(self) -> int | None:
        """End it, and say which line of its own file it worked on, if it is a program in Python."""
        before = len(self.printed)
        with suppress(ProcessLookupError):
            # With PYTHONFAULTHANDLER, Python then prints where it is.
            os.kill(self._process.pid, signal.SIGABRT)
        with self._changed:
            self._changed.wait_for(lambda: self.code is not None, REAP_S)
            self._changed.wait_for(lambda: STACK.search(self.printed[before:]), 1.0)
        return self.line_at_end(before)

    def line_at_end(self, before: int = 0) -> int | None:
        """The line of its own file where it was when a signal ended it, if it is a program in Python.

        ``before``: how many characters it had printed until then, or fewer.
        """
        for thread in STACK.split(self.printed[before:]):
            for path, line in PLACE.findall(thread):
                if _is_same(path, self.file):
                    return int(line)
        return None

    def stop(self, politely: bool = True) -> None:
        """End it, and whatever it has started. ``politely``: it may sign off from ROS before."""
        with suppress(ProcessLookupError):
            if politely and self.code is None:
                os.killpg(self.group, signal.SIGINT)
                with self._changed:
                    self._changed.wait_for(lambda: self.code is not None, STOP_S)
            os.killpg(self.group, signal.SIGKILL)
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(REAP_S)


class _Busy:
    """For how long a process group has not used the processor."""

    def __init__(self, group: int) -> None:
        self._group, self._used, self._since = group, -1, time.monotonic()

    def idle_s(self) -> float:
        used, waits = self._look()
        # A node that waits still wakes up now and then, which takes less than a twentieth of its time.
        if used is None or used - self._used > 2 + 5 * (time.monotonic() - self._since) or not waits:
            self._used, self._since = used or 0, time.monotonic()
        return time.monotonic() - self._since

    def _look(self) -> tuple[int | None, bool]:
        """The ticks, of 10 ms, that the group has used, and whether all its processes sleep."""
        used, sleeping, any_is_there = 0, True, False
        for path in glob.glob('/proc/[0-9]*/stat'):
            with suppress(OSError, ValueError, IndexError):
                with open(path, errors='replace') as file:
                    fields = file.read().rpartition(')')[2].split()
                if int(fields[2]) == self._group:
                    any_is_there = True
                    used += sum(map(int, fields[11:15]))
                    sleeping = sleeping and fields[0] in 'SIZ'
        return used if any_is_there else None, sleeping


def _raised(part: str, file: str) -> Raised | None:
    """The exception of a traceback, from after its first line."""
    lines = part.lstrip('\n').split('\n')
    end = next((number for number, line in enumerate(lines) if line and not line.startswith(' ')), None)
    if end is None:
        return None
    found = RAISED.match(lines[end])
    if not found:
        return None
    places = [int(line) for path, line in PLACE.findall('\n'.join(lines[:end])) if _is_same(path, file)]
    more = []
    for line in lines[end + 1:]:  # OpenCV's messages have several lines
        if not line.startswith((' ', '>')):
            break
        more.append(line)
    return Raised(found[1], '\n'.join([found[2] or '', *more]).strip(), places[-1] if places else None)


def _is_same(path: str, file: str) -> bool:
    """Whether a path in a traceback is that of the program; in devel space, a file in between starts it."""
    return os.path.basename(path) == os.path.basename(file)
