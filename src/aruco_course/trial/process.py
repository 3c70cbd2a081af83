"""Starts the process in which the learner's code runs, hears what comes of it, and ends it."""
from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from typing import IO, Any, Callable, Sequence

import numpy as np
from aruco_ar.base.arrays import Image
from aruco_ar.base.system import end_with_children

from .limits import Limits

MAIN = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'inside', 'main.py')
# What would change how the learner's code runs.
UNSET = ('PYTHONDEVMODE', 'PYTHONWARNINGS', 'PYTHONINSPECT', 'PYTHONSTARTUP', 'PYTHONMALLOC',
         'PYTHONPROFILEIMPORTTIME')
# Threads of OpenCV, and arenas of malloc, take memory of what the learner's code may have.
SET = {'OPENCV_FOR_THREADS_NUM': '1', 'MALLOC_ARENA_MAX': '2', 'OPENBLAS_NUM_THREADS': '1',
       'OMP_NUM_THREADS': '1', 'MKL_NUM_THREADS': '1', 'PYTHONUNBUFFERED': '1',
       'PYTHONIOENCODING': 'utf-8:backslashreplace', 'MPLBACKEND': 'Agg', 'OPENCV_LOG_LEVEL': 'ERROR'}
LARGEST = 1 << 24  # bytes of an image
GRACE = 2.0        # seconds that the process has to end itself after its time is over
ANSWER = 3.0       # seconds that it has to write where it is


class Ending:
    """How the process ended. ``how``: 'end' if it did all, 'ended' if it ended itself before, 'slow' if it was
    ended since it took too long, 'printed' if it printed too much. ``status``: its exit code, or minus a
    signal. ``trace``: where it was then, as faulthandler writes it.
    """

    def __init__(self) -> None:
        self.how = 'ended'
        self.status = 0
        self.trace = ''
        self.printed = ''


def run(job: dict[str, Any], arrays: Sequence[Image], limits: Limits, cwd: str | None,
        hear: Callable[[dict[str, Any], list[Image]], float | None]) -> Ending:
    """Run a job in a process of its own.

    ``hear`` is called with each record that comes, and the arrays in it, and returns how many seconds the code
    has from now on, or None if it is to be ended. ``cwd``: the folder in which the code runs; None: an empty
    one.
    """
    with tempfile.TemporaryDirectory(prefix='trial_') as folder:
        scratch = os.path.join(folder, 'empty')
        os.mkdir(scratch)
        process = Process(os.path.join(folder, 'trace'), cwd or scratch, limits)
        try:
            process.give(dict(job, memory=limits.memory), arrays)
            return process.follow(hear)
        finally:
            process.close()


class Process:
    """The learner's process, and the threads that listen to it."""

    def __init__(self, trace: str, cwd: str, limits: Limits) -> None:
        environment = {name: value for name, value in os.environ.items() if name not in UNSET}
        environment.update(SET)
        self._trace = trace
        self._limits = limits
        self._heard: queue.Queue[tuple[str, dict[str, Any], list[Image]]] = queue.Queue()
        self._printed: list[bytes] = []
        self._process = subprocess.Popen(
            [sys.executable, MAIN, trace], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, cwd=cwd, env=environment, start_new_session=True)
        self._threads = [threading.Thread(target=one, daemon=True)
                         for one in (self._read_records, self._read_printed, self._await_end)]
        for thread in self._threads:
            thread.start()

    def give(self, job: dict[str, Any], arrays: Sequence[Image]) -> None:
        """Give it the job."""
        arrays = [np.ascontiguousarray(array) for array in arrays]
        head = dict(job, arrays=[(array.dtype.str, array.shape) for array in arrays])
        assert self._process.stdin
        try:
            self._process.stdin.write(json.dumps(head).encode() + b'\n')
            for array in arrays:
                self._process.stdin.write(array.data)
            self._process.stdin.close()
        except OSError:
            pass  # it has ended already: follow() says so

    def follow(self, hear: Callable[[dict[str, Any], list[Image]], float | None]) -> Ending:
        """Hear what comes, until the process ends or is to be ended."""
        ending = Ending()
        until = time.monotonic() + self._limits.load + GRACE
        while True:
            try:
                what, record, images = self._heard.get(timeout=max(until - time.monotonic(), 0))
            except queue.Empty:
                ending.how = 'slow'
                self._ask_where()
                break
            if what == 'record':
                try:
                    seconds = hear(record, images)
                except (KeyError, TypeError, ValueError):
                    break  # no record of ours: the learner's code has written it
                if record['say'] == 'end' or seconds is None:
                    ending.how = 'end'
                    break
                until = time.monotonic() + seconds + GRACE
            elif what == 'printed':
                ending.how = 'printed'
                self._ask_where()
                break
            else:
                break
        self._kill()
        for thread in self._threads:
            thread.join(1)
        ending.status = self._process.wait()
        while ending.how == 'ended' and not self._heard.empty():  # what it said just before
            what, record, images = self._heard.get()
            if what == 'record':
                hear(record, images)
                if record['say'] == 'end':
                    ending.how = 'end'
            elif what == 'printed':
                ending.how = 'printed'
        ending.trace = self._where()
        if ending.how == 'ended' and ending.trace.startswith('Timeout'):
            ending.how = 'slow'
        ending.printed = b''.join(self._printed)[:self._limits.printed].decode('utf-8', 'replace')
        return ending

    def close(self) -> None:
        """End it and all that it has started, and what listens to it."""
        self._kill()
        for thread in self._threads:
            thread.join(1)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            with suppress(OSError):  # what was not yet written to it is lost
                if pipe:
                    pipe.close()

    def _kill(self) -> None:
        """End the process, and those that it has started."""
        if self._process.returncode is not None:
            return  # its number may be that of another process by now
        end_with_children(self._process)

    def _ask_where(self) -> None:
        """Let the process write where it is, if it has not done so, and give it a moment for that."""
        if not hasattr(signal, 'SIGUSR1') or self._where():
            return
        self._process.send_signal(signal.SIGUSR1)
        until = time.monotonic() + ANSWER
        # It writes piece by piece, and what called all else, this package's own file, comes last.
        while os.path.basename(MAIN) + '", line' not in self._where() and time.monotonic() < until:
            time.sleep(0.01)

    def _where(self) -> str:
        """What the process has written of where it is."""
        try:
            with open(self._trace, encoding='ascii', errors='replace') as file:
                return file.read(1 << 16)
        except OSError:
            return ''

    def _await_end(self) -> None:
        """Say when the process has ended; it stays a zombie until _kill has ended those that it has started."""
        if hasattr(os, 'waitid'):
            try:
                os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOWAIT)
            except ChildProcessError:
                pass  # close() was faster
        else:
            self._process.wait()
        # What it has said just before comes first, unless others keep the pipe open.
        self._threads[0].join(0.5)
        self._heard.put(('ended', {}, []))

    def _read_records(self) -> None:
        """Hear the records. Nothing in them is believed: the learner's code may have written them."""
        pipe = self._process.stdout
        assert pipe
        try:
            while True:
                record, images = read_record(pipe)
                self._heard.put(('record', record, images))
        except (ValueError, KeyError, TypeError, OSError, EOFError):
            pass  # it has ended, or it says what makes no sense, and then nothing more is heard

    def _read_printed(self) -> None:
        """Keep what is printed, until it is too much."""
        pipe = self._process.stderr
        assert pipe
        left = self._limits.printed
        try:
            while True:
                text = os.read(pipe.fileno(), 1 << 16)
                if not text:
                    return
                if left > 0:
                    self._printed.append(text)
                    left -= len(text)
                    if left <= 0:
                        self._heard.put(('printed', {}, []))
                        return
        except (OSError, ValueError):
            pass


def read_record(pipe: IO[bytes]) -> tuple[dict[str, Any], list[Image]]:
    """The next record in the pipe, and its images. Raises EOFError, or others if it makes no sense."""
    line = pipe.readline(1 << 16)
    if not line.endswith(b'\n'):
        raise EOFError
    record = json.loads(line)
    if not isinstance(record, dict) or not isinstance(record.get('say'), str):
        raise ValueError('no record')
    images: list[Image] = []
    for kind, shape in record['arrays']:
        if kind != '|u1' or len(shape) not in (2, 3) or not all(isinstance(n, int) and n > 0 for n in shape):
            raise ValueError('no image')
        size = shape[0] * shape[1] * (shape[2] if len(shape) == 3 else 1)
        if size > LARGEST or len(images) >= 8:
            raise ValueError('too large')
        data = pipe.read(size)
        if len(data) != size:
            raise EOFError
        images.append(np.frombuffer(bytearray(data), np.uint8).reshape(shape))
    return record, images
