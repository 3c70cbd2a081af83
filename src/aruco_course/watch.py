"""Watching a learner's files: a verdict each time one is saved."""
from __future__ import annotations

import os
import sys
import threading
import time
from typing import IO, Callable, Iterable, Iterator, NamedTuple

from aruco_ar import InputError
from aruco_ar.base.system import is_typed

from . import say
from .check import Challenge, Check, Exercise, Fault
from .course import Course
from .terminal import Screen
from .verdict import Verdict, try_challenges

# The files are looked at, over and over. Nothing has to be installed for that, and it works with every editor,
# whether it writes a file or replaces it, and on network drives, of whose changes the system does not tell.
LOOK_S = 0.2
SETTLE_S = 0.05  # a file that has changed is judged once it stays the same for this long

KEYS = 'h: hint, s: solution, r: reset, n: next, q: quit; then Enter'


class Event(NamedTuple):
    """``kind``: 'saved', with the number of an exercise, or 'typed', with a line, or 'resized'."""

    kind: str
    text: str = ''


class Files:
    """Which of the learner's files have changed."""

    def __init__(self, course: Course) -> None:
        self._paths = {check.number: course.package.source(check) for check in course.checks}
        self._known = {number: _state(path) for number, path in self._paths.items()}

    def is_any_newer(self) -> bool:
        """Whether ``changed`` would find something."""
        return any(_state(path) != self._known[number] for number, path in self._paths.items())

    def changed(self, pause: Callable[[float], object] = time.sleep) -> list[str]:
        """The exercises whose files have changed since the last call, once nobody writes to them."""
        found = {number: _state(path) for number, path in self._paths.items()}
        changed = [number for number in found if found[number] != self._known[number]]
        if changed:
            before = None
            while before != found:
                before = found
                pause(SETTLE_S)
                found = {number: _state(path) for number, path in self._paths.items()}
        self._known = found
        return changed


def _state(path: str) -> tuple[int, ...]:
    """What changes when a file is saved; nothing if there is none."""
    try:
        status = os.stat(path)
    except OSError:
        return ()
    return status.st_mtime_ns, status.st_size, status.st_ino


def events(files: Files, screen: Screen, stdin: IO[str] | None) -> Iterator[Event]:
    """What happens, without end, or until the learner types Ctrl-D. ``stdin``: a terminal, or None."""
    width = screen.width
    while True:
        for number in files.changed():
            yield Event('saved', number)
        if screen.width != width:
            width = screen.width
            yield Event('resized')
        if stdin is None:
            time.sleep(LOOK_S)
        elif is_typed(stdin, LOOK_S):
            line = stdin.readline()
            if not line:  # Ctrl-D
                return
            yield Event('typed', line.strip())


class Watch:
    """What ``learn.py watch`` shows, and what it does when something happens.

    ``can_type``: whether the learner can type commands into it. ``is_over``: tells whether what takes long can
    be given up, since something has happened.
    """

    def __init__(self, course: Course, screen: Screen, can_type: bool,
                 is_over: Callable[[], bool] = lambda: False) -> None:
        self._course, self._screen, self._can_type, self._is_over = course, screen, can_type, is_over
        self._shown: Exercise = course.at_hand() or course.checks[-1]
        self._told: Exercise | None = None  # whose task was told
        self._verdict: Verdict | None = None
        self._challenges: list[tuple[Challenge, Fault | None]] = []
        self._keys_told = False
        self._notice: Callable[[], None] | None = None  # what is said again below the next verdict
        self._when = ''

    def run(self, happened: Iterable[Event]) -> int:
        """Show the exercise at hand, and follow what happens. Returns the exit code."""
        self._judge()
        prepare(self._course, self._shown)
        for event in happened:
            try:
                if event.kind == 'saved':
                    self._shown = self._course.exercise(event.text)
                    self._judge()
                elif event.kind == 'resized':
                    if not self._screen.is_plain:
                        self._show()
                elif not self._do(event.text):
                    break
            except InputError as error:  # such as: the disk is full
                self._screen.text(str(error))
        return 0

    def _judge(self) -> None:
        """Show the verdict on the exercise that is shown, then its challenges as they are tried."""
        screen, course, check = self._screen, self._course, self._shown
        self._verdict, self._challenges = None, []
        if not screen.is_plain:
            screen.text('Looking at src/%s.py …' % check.name, 'dim')
        self._verdict = course.judge(check)
        self._when = time.strftime('%H:%M:%S')
        self._show(is_final=False)
        if self._verdict.passed:
            for tried, fault in try_challenges(check, course.package.folder):
                if not self._challenges:
                    say.challenges_begin(screen)
                say.challenge(screen, course, check, tried, fault)
                self._challenges.append((tried, fault))
                course.note_challenge(check, tried, fault)
                if self._is_over():
                    return
        self._show_end()

    def _show(self, is_final: bool = True) -> None:
        """Everything, on an empty screen; without one, what is new. ``is_final``: with the challenges."""
        screen, course, check = self._screen, self._course, self._shown
        screen.clear()
        if screen.is_plain:
            screen.text()
        screen.progress(course.checks, course.progress, check)
        screen.text()
        if not (screen.is_plain and self._told is check):
            say.task(screen, check)
            screen.text()
        self._told = check
        if self._verdict is not None:
            say.verdict(screen, course, self._verdict, self._when)
        if is_final:
            for number, (tried, fault) in enumerate(self._challenges):
                if not number:
                    say.challenges_begin(screen)
                say.challenge(screen, course, check, tried, fault)
            self._show_end()

    def _show_end(self) -> None:
        screen, course = self._screen, self._course
        if self._passed:
            say.passed(screen, course, self._shown)
            after = course.after(self._shown)
            if after is not None and not self._can_type:  # nobody can ask for it
                screen.text()
                say.task(screen, after)
        if self._notice and not screen.is_plain:
            screen.text()
            self._notice()
        self._notice = None
        if self._can_type and not (screen.is_plain and self._keys_told):
            screen.text()
            screen.text(KEYS, 'dim')
            self._keys_told = True

    @property
    def _passed(self) -> bool:
        return self._verdict is not None and self._verdict.passed

    def _do(self, line: str) -> bool:
        """Do what was typed. Returns False if that was to quit."""
        screen, course = self._screen, self._course
        word, _, rest = line.partition(' ')
        check = course.exercise(rest.strip()) if rest.strip() else self._shown
        if word in ('q', 'quit', 'exit'):
            return False
        if word in ('h', 'hint'):
            say.hints(screen, check, course.hint(check))
        elif word in ('s', 'solution'):
            say.solution(screen, course, check, course.solution(check))
        elif word in ('r', 'reset'):
            kept = course.reset(check)
            say.was_reset(screen, course, check, kept)
            # The file is another one now, so there is a verdict, on an empty screen.
            self._notice = lambda: say.was_reset(screen, course, check, kept)
        elif word in ('n', 'next') or (not word and self._passed):
            self._shown = check if rest.strip() else course.after(check) or check
            prepare(course, self._shown)
            self._judge()
        elif not word:
            self._show()
        else:
            screen.text('"%s" is none of them. %s.' % (word, KEYS))
        return True


def prepare(course: Course, check: Exercise) -> None:
    """Render the frames that will be needed next, while the learner writes: then his verdict comes sooner."""
    place = course.checks.index(check)

    def render() -> None:
        for each in course.checks[place:place + 2]:
            if isinstance(each, Check):
                each.views()
                for challenge in each.challenges:
                    challenge.views()
    threading.Thread(target=render, daemon=True).start()


def watch(course: Course, screen: Screen) -> int:
    """Watch until Ctrl-C, or until the learner quits. Returns the exit code."""
    can_type = sys.stdin is not None and sys.stdin.isatty()
    files = Files(course)
    happened = events(files, screen, sys.stdin if can_type else None)
    return Watch(course, screen, can_type, files.is_any_newer).run(happened)
