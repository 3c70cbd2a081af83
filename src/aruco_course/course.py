"""One learner's course: his package, the exercises, and what is done with them. It prints nothing."""
from __future__ import annotations

import difflib
import hashlib
import os
import re
from contextlib import suppress
from typing import Sequence

import cv2
from aruco_ar import InputError
from aruco_ar.base.arrays import Image
from aruco_ar.base.files import read_whole, write_whole

from .check import Challenge, Exercise, Fault
from .judge.verdict_picture import verdict_picture
from .learner import package as learner
from .learner.package import MAX_SOURCE_BYTES, Package
from .learner.progress import Progress, changed, now, read
from .verdict import Verdict, judge_exercise

NUMBER = re.compile(r'(\d+)[._](\d+)')


class Course:
    """``checks``: in the order of their numbers."""

    def __init__(self, package: Package, checks: Sequence[Exercise]) -> None:
        self.package, self.checks = package, checks

    @property
    def progress(self) -> Progress:
        """What has been done until now, also by other programs."""
        return read(self.package)

    def exercise(self, text: str) -> Exercise:
        """The exercise of a text such as "5.4", "4" or "src/exercise5_4.py". Raises InputError."""
        found = NUMBER.search(os.path.basename(text))
        for check in self.checks:
            if check.number == ('%s.%s' % found.groups() if found else '5.' + text):
                return check
        raise InputError('There is no exercise "%s"; there are %s.'
                         % (text, ', '.join(check.number for check in self.checks)))

    def at_hand(self) -> Exercise | None:
        """The first exercise that is not done; None if all are."""
        progress = self.progress
        return next((check for check in self.checks if not progress.of(check.number).passed), None)

    def after(self, check: Exercise) -> Exercise | None:
        """The next exercise that is not done, first among those after this one; None if all are."""
        place, progress = self.checks.index(check), self.progress
        return next((each for each in [*self.checks[place + 1:], *self.checks[:place]]
                     if not progress.of(each.number).passed), None)

    def is_untouched(self, check: Exercise) -> bool:
        """Whether nothing was written into the file yet."""
        return learner.is_untouched(self.package, check)

    def judge(self, check: Exercise) -> Verdict:
        """The verdict on an exercise, without its challenges. It is noted, and its picture is written."""
        untouched, digest = self.is_untouched(check), self._digest(check)
        verdict = judge_exercise(check, self.package.folder, with_challenges=False)
        if not untouched:
            with changed(self.package) as progress:
                progress.of(check.number).attempt(digest, None if verdict.fault is None else str(verdict.fault))
        data = self.keep_picture(check, verdict)
        if data is not None and verdict.passed:
            write_whole(self.package.passed_picture(check), data)
        return verdict

    def keep_picture(self, check: Exercise, verdict: Verdict) -> bytes | None:
        """Write the picture of the newest verdict, if there is one. Returns it as a PNG."""
        if verdict.picture is None:
            with suppress(OSError):
                os.remove(self.package.picture(check))  # it shows an older version
            return None
        data = _png(verdict.picture)
        write_whole(self.package.picture(check), data)
        return data

    def note_challenge(self, check: Exercise, challenge: Challenge, fault: Fault | None) -> None:
        """Note whether the code survives a challenge, and write a picture of it if not."""
        picture = None if fault is None else verdict_picture(fault, None)
        if picture is not None:
            write_whole(self.package.challenge_picture(check, challenge), _png(picture))
        with changed(self.package) as progress:
            progress.of(check.number).challenges[challenge.name] = fault is None

    def note_node(self, check: Exercise) -> None:
        """Note that the node passed. It may do without the function that is judged otherwise."""
        digest = self._digest(check)
        with changed(self.package) as progress:
            done = progress.of(check.number)
            done.attempt(digest, None)
            done.node_passed = done.node_passed or now()

    def hint(self, check: Exercise) -> list[str]:
        """The hints that were seen, and one more; all of them if there are no more."""
        with changed(self.package) as progress:
            done = progress.of(check.number)
            done.hints = min(done.hints + 1, len(check.hints))
        return list(check.hints[:done.hints])

    def solution(self, check: Exercise) -> list[str] | None:
        """The difference between the learner's file and our plain solution, as lines of a unified diff.

        None if the exercise is not done, and this is the first time that somebody asks.
        """
        with changed(self.package) as progress:
            done = progress.of(check.number)
            done.solution_asked += 1
            may_see = done.passed or done.solution_asked > 1
            if may_see:
                done.solution_seen = done.solution_seen or now()
        if not may_see:
            return None
        try:
            yours = read_whole(self.package.source(check), MAX_SOURCE_BYTES).decode('utf-8', 'replace')
        except InputError:
            yours = ''
        return list(difflib.unified_diff(yours.splitlines(), learner.solution(check).splitlines(),
                                         'yours: src/%s.py' % check.name, 'ours', lineterm=''))

    def reset(self, check: Exercise) -> str | None:
        """Bring back the skeleton. Returns where the old file is kept, or None if there was none."""
        return learner.reset(self.package, check)

    def _digest(self, check: Exercise) -> str:
        try:
            return hashlib.sha256(read_whole(self.package.source(check), MAX_SOURCE_BYTES)).hexdigest()
        except InputError:
            return ''


def _png(image: Image) -> bytes:
    data: bytes = cv2.imencode('.png', image)[1].tobytes()
    return data
