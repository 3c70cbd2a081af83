"""What a learner has done and when, kept in .learn/progress.json of his package."""
from __future__ import annotations

import json
import os
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from datetime import datetime
from typing import Any, Iterator

from aruco_ar import InputError
from aruco_ar.base.files import read_whole, write_whole
from aruco_ar.base.system import lock

from .package import HIDDEN, Package

FILE = 'progress.json'
MAX_BYTES = 4 * 1024 * 1024
MAX_FAULTS = 50     # different sentences that are kept for each exercise
MAX_TEXT = 1000     # characters of a sentence


@dataclass
class Done:
    """What was done of one exercise. Times are texts such as 2026-11-25T14:03:00+01:00, or nothing.

    ``attempts``: how many versions of the file were judged until it was right. ``hints``: how many were seen.
    ``solution_asked``: how often; ``solution_seen``: when first. ``faults``: how often each sentence was given
    until it was right, in the order of their first time. ``challenges``: for the name of each, whether the code
    survived it. ``last``: what the last verdict said; nothing if it was right. ``judged``: a digest of the
    version that was judged last.
    """

    began: str = ''
    attempts: int = 0
    hints: int = 0
    solution_asked: int = 0
    solution_seen: str = ''
    passed: str = ''
    node_passed: str = ''
    challenges: dict[str, bool] = field(default_factory=dict)
    faults: dict[str, int] = field(default_factory=dict)
    last: str = ''
    judged: str = ''

    def attempt(self, digest: str, fault: str | None) -> None:
        """Note a verdict on a version of the file. The same version again is no other attempt."""
        fault = None if fault is None else fault[:MAX_TEXT]
        if digest == self.judged and (fault or '') == self.last:
            return
        if digest != self.judged and not self.passed:
            self.attempts += 1
        self.judged = digest
        self.began = self.began or now()
        self.last = fault or ''
        if self.passed:
            return  # what is tried later is not needed for it
        if fault is None:
            self.passed = self.passed or now()
        elif fault in self.faults or len(self.faults) < MAX_FAULTS:
            self.faults[fault] = self.faults.get(fault, 0) + 1

    @property
    def minutes(self) -> float | None:
        """From the first verdict to the pass."""
        if not (self.began and self.passed):
            return None
        return (datetime.fromisoformat(self.passed) - datetime.fromisoformat(self.began)).total_seconds() / 60


@dataclass
class Progress:
    """That of a whole package. ``exercises``: by their numbers."""

    started: str = ''
    exercises: dict[str, Done] = field(default_factory=dict)

    def of(self, number: str) -> Done:
        """What was done of an exercise; a new entry if nothing was."""
        return self.exercises.setdefault(number, Done())


def now() -> str:
    """The time, to the second, with the zone."""
    return datetime.now().astimezone().isoformat(timespec='seconds')


def read(package: Package) -> Progress:
    """The progress of a package. What cannot be read of it counts as not done; see ``changed``."""
    return _read(package)[0]


@contextmanager
def changed(package: Package) -> Iterator[Progress]:
    """The progress, for a ``with`` block that changes it. It is written when the block ends without an error.

    Two programs may do so at the same time: ``watch`` in one terminal, ``hint`` in another. A file that was
    broken is kept in .learn/old. Raises InputError if nothing can be written.
    """
    folder = package.path(HIDDEN)
    try:
        os.makedirs(folder, exist_ok=True)
        handle = os.open(os.path.join(folder, 'lock'), os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError('Cannot write to "%s": %s. Your progress is kept there; make that folder writable.'
                         % (folder, error.strerror)) from None
    try:
        try:
            lock(handle)
        except (OSError, ImportError):
            pass  # some network drives and systems have no locks; then the file is at least never half written
        progress, is_whole = _read(package)
        progress.started = progress.started or now()
        yield progress
        if not is_whole:
            package.keep(package.path(HIDDEN, FILE))
        text = json.dumps(asdict(progress), indent=1, ensure_ascii=False)
        write_whole(package.path(HIDDEN, FILE), text.encode('utf-8', 'replace'))
    finally:
        os.close(handle)


def _read(package: Package) -> tuple[Progress, bool]:
    """The progress, and whether all of the file could be read. A file that is missing is whole."""
    path = package.path(HIDDEN, FILE)
    if not os.path.lexists(path):
        return Progress(), True
    try:
        data = json.loads(read_whole(path, MAX_BYTES).decode())
        entries = data['exercises']
        whole = isinstance(data['started'], str) and _is_time(data['started'])
        progress = Progress(data['started'] if whole else '', {})
        for number, entry in entries.items():
            progress.exercises[number], fine = _done(entry)
            whole = whole and fine
        return progress, whole
    except (InputError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return Progress(), False


def _done(entry: Any) -> tuple[Done, bool]:
    """An exercise's entry, and whether it is as ``changed`` writes them. What is not is left out."""
    fine = {each.name: entry[each.name] for each in fields(Done) if _is_fine(each.name, entry)}
    return Done(**fine), len(fine) == len(fields(Done))


def _is_fine(name: str, entry: Any) -> bool:
    """Whether the entry has that field, and its value is one of it."""
    if not isinstance(entry, dict) or type(entry.get(name)) is not type(getattr(Done(), name)):
        return False
    value = entry[name]
    if name in ('began', 'passed', 'node_passed', 'solution_seen'):
        return _is_time(value)
    if isinstance(value, dict):
        kind = bool if name == 'challenges' else int
        return all(type(each) is kind for each in value.values())
    return not isinstance(value, int) or value >= 0


def _is_time(text: str) -> bool:
    """Whether the text is a time with a zone, or empty."""
    try:
        return not text or datetime.fromisoformat(text).tzinfo is not None
    except ValueError:
        return False
