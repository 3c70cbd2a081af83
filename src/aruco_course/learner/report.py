"""What a learner has done, as JSON: for a teacher who collects that of a class."""
from __future__ import annotations

import json
from typing import Any, Callable, Sequence

from aruco_course.check import Exercise
from aruco_course.verdict import Verdict

from .package import Package
from .progress import now, read


def report(package: Package, checks: Sequence[Exercise],
           judge: Callable[[Exercise], Verdict] | None = None) -> str:
    """The report as a text of JSON. ``judge``: makes verdicts on what the files are now; None: without them."""
    exercises = []
    for check in checks:
        # First, since it counts as an attempt if the file has changed.
        verdict = judge(check) if judge else None
        done = read(package).of(check.number)
        entry: dict[str, Any] = {
            'number': check.number,
            'title': check.title,
            'passed': done.passed or None,
            'began': done.began or None,
            'minutes': None if done.minutes is None else round(done.minutes, 1),
            'attempts': done.attempts,
            'hints': done.hints,
            'solution_seen': done.solution_seen or None,
            'node_passed': done.node_passed or None,
            'challenges': done.challenges,
            'faults': [{'sentence': sentence, 'times': times} for sentence, times in done.faults.items()],
        }
        if verdict is not None:
            entry['now'] = {'passed': verdict.passed, 'fault': None if verdict.passed else str(verdict.fault)}
        exercises.append(entry)
    whole = {
        'package': package.name,
        'made': now(),
        'started': read(package).started or None,
        'done': sum(entry['passed'] is not None for entry in exercises),
        'exercises': exercises,
    }
    return json.dumps(whole, indent=2) + '\n'
