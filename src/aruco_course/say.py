"""What is said about a learner's course: its sentences, for a Screen."""
from __future__ import annotations

import os
from typing import Iterable

from .check import Challenge, Exercise, Fault
from .course import Course
from .learner.package import has_node
from .terminal import Screen
from .verdict import Verdict

PRINTED_LINES = 6  # of what the learner's code printed


def task(screen: Screen, check: Exercise) -> None:
    """What is to be done, and where."""
    screen.title('%s %s' % (check.number, check.title))
    screen.text('About %d minutes. Write in src/%s.py.' % (check.minutes, check.name), 'dim')
    screen.text()
    screen.text(check.task)


def verdict(screen: Screen, course: Course, judged: Verdict, when: str = '') -> None:
    """Whether the file is right, the first thing that is wrong, and where the picture is.

    ``when``: the time of the verdict, so that one who watches sees that it is a new one.
    """
    check = judged.check
    when = ' (%s)' % when if when else ''
    if judged.fault is None:
        screen.right('%s is right.%s' % (check.number, when))
    elif course.is_untouched(check):
        screen.text('Nothing is written yet.%s' % when, 'yellow')
    else:
        screen.wrong('%s is not right yet.%s' % (check.number, when))
    if judged.fault is not None:
        screen.text(str(judged.fault), indent=0 if screen.is_plain else 2)
    if judged.printed.strip():
        # What is printed for each frame is shown once.
        lines = list(dict.fromkeys(judged.printed.rstrip().splitlines()))
        screen.text('Your code printed:', 'dim')
        screen.lines('\n'.join(lines[:PRINTED_LINES]))
        if len(lines) > PRINTED_LINES:
            screen.lines('and more lines', 'dim')
    if judged.picture is not None:
        both = judged.fault is not None and judged.fault.expected is not None
        what = 'What is expected, and what yours shows' if both else 'What yours shows'
        screen.text('%s: %s' % (what, shortest(course.package.picture(check))), 'dim')


def challenges_begin(screen: Screen) -> None:
    """What comes next: the results of the challenges."""
    screen.text()
    screen.text('Challenges. It is right without them, but a robot will meet them:')


def challenge(screen: Screen, course: Course, check: Exercise, tried: Challenge, fault: Fault | None) -> None:
    """Whether the code survives a challenge, and if not, why."""
    if fault is None:
        screen.right('%s: yours survives it.' % _upper(tried.name))
        return
    screen.open('%s: yours does not survive it.' % _upper(tried.name))
    screen.text('%s %s' % (fault, tried.why), indent=0 if screen.is_plain else 2)
    if fault.shown is not None:
        path = shortest(course.package.challenge_picture(check, tried))
        screen.text('Its picture: %s' % path, 'dim', indent=0 if screen.is_plain else 2)


def passed(screen: Screen, course: Course, check: Exercise) -> None:
    """What can be done with an exercise that is right."""
    screen.text()
    if has_node(check):
        screen.text('See it run, on the simulated robot and beside ours, at http://localhost:8080:')
        screen.lines('roslaunch %s %s.launch sim:=true page:=true ours:=true'
                     % (course.package.name, check.name))
    after = course.after(check)
    if after is None:
        screen.text('All exercises are done. The command "page" makes a page of them, to print.', 'bold')
    else:
        screen.text('Next: %s %s, in src/%s.py.' % (after.number, after.title, after.name), 'bold')


def hints(screen: Screen, check: Exercise, seen: Iterable[str]) -> None:
    """The hints that were asked for."""
    for number, text in enumerate(seen, start=1):
        screen.text('Hint %d of %d: %s' % (number, len(check.hints), text))


def solution(screen: Screen, course: Course, check: Exercise, lines: list[str] | None) -> None:
    """The difference between the learner's file and ours."""
    if lines is None:
        screen.text('%s is not right yet. Hints may help more than the solution. To see it anyway, ask again.'
                    % check.number)
        return
    if not lines:
        screen.text('Your file is the same as ours.')
    else:
        screen.text('Lines that begin with - are in your file only, and those with + in ours only. There are '
                    'other ways that are as right.')
        screen.text()
        screen.difference(lines)
        screen.text()
    ours = 'artag_generator' if check.number == '5.1' else check.name
    screen.text('To compare: src/%s.py of unit5 does the same for a real robot.' % ours)


def was_reset(screen: Screen, course: Course, check: Exercise, kept: str | None) -> None:
    """That the skeleton is back."""
    screen.text('src/%s.py is as in the beginning.%s'
                % (check.name, '' if kept is None else ' Your file is kept: ' + shortest(kept)))


def shortest(path: str) -> str:
    """A path as one would type it here."""
    return min(os.path.relpath(path), path, key=len)


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
