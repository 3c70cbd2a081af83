"""What to say when the learner's code ended its process, or had to be ended."""
from __future__ import annotations

import re
import signal
from typing import TYPE_CHECKING, Any

from aruco_course.check import Fault
from aruco_course.trial.limits import Limits

if TYPE_CHECKING:
    from aruco_course.trial.process import Ending

ENTRY = re.compile(r'^  File "(.*)", line (\d+) in ')


def fault_of_ending(ending: Ending, left: dict[str, Any], now: dict[str, Any], path: str, function: str | None,
                    limits: Limits) -> Fault:
    """Why the process ended before all was done.

    ``left``: what os._exit told, if anything. ``now``: the stage it was in, and the number of the call.
    """
    line = line_in_trace(ending.trace, path)
    place = 'Line %d' % line if line else 'Frame %d' % now['call'] if now['stage'] == 'call' else ''
    what = 'the program' if function is None else 'the file'
    if now['stage'] == 'call' and function:
        what = function
    if now['stage'] == 'start' and ending.how == 'slow':
        return Fault('Python did not start with NumPy and OpenCV within %g seconds. Is the computer very busy?'
                     % limits.load)
    if now['stage'] == 'start':
        return Fault('Python could not start with NumPy and OpenCV: %s'
                     % (last_line(ending.printed) or 'it ended.'))
    if ending.how == 'slow':
        if now['stage'] == 'call':
            return Fault('%s did not come to its end within %g seconds. Does a loop '
                         'here never end, or does something wait? A function of one '
                         'frame must not wait.' % (function, limits.call), place)
        if function is None:
            return Fault('the program did not come to its end within %g seconds. Does a loop here never end, '
                         'or does something wait?' % limits.load, place)
        return Fault('the file was not imported within %g seconds: something at its left margin waits, or '
                     'loops without end. What the node does belongs into main().' % limits.load, place)
    if ending.how == 'printed':
        return Fault('%s prints without end: it was stopped after %d kB. Is there a print in a loop that '
                     'never ends?'
                     % (what, limits.printed >> 10), place)
    if left:
        return Fault('%s ends its own process with os._exit, so no frame comes after that. Leave the '
                     'call out.' % what,
                     'Line %d' % left['line'] if left.get('line') else place)
    if ending.status < 0:
        return Fault(of_signal(-ending.status, what), place)
    return Fault('%s ended its own process, with exit code %d.' % (what, ending.status), place)


def of_signal(number: int, what: str) -> str:
    """The sentence for a process that a signal has ended."""
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = 'signal %d' % number
    if name in ('SIGSEGV', 'SIGBUS', 'SIGILL', 'SIGFPE'):
        return ('Python itself crashed here (%s): a function that is not written in Python got what it cannot '
                'use. Look at the arrays that it gets: their shape, and whether they are empty.' % name)
    if name == 'SIGABRT':
        return ('Python itself was aborted here (SIGABRT): a function that is not written in Python gave up. '
                'Look at the arrays that it gets.')
    if name == 'SIGKILL':
        return '%s was killed by the system, most likely since it took too much memory.' % what
    return '%s ended its own process with the signal %s.' % (what, name)


def line_in_trace(trace: str, path: str) -> int:
    """The innermost line of the file in what faulthandler wrote, in the thread that called it, or 0."""
    written = path.encode('ascii', 'backslashreplace').decode('ascii')[:500]
    found = 0
    for thread in trace.split('\n\n'):
        for entry in thread.split('\n'):
            match = ENTRY.match(entry)
            if match and match.group(1).rstrip('.') == written.rstrip('.'):
                found = int(match.group(2))
                break
        if found and 'main.py' in thread:
            break
    return found


def last_line(text: str) -> str:
    """The last line that is not empty."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:300] if lines else ''
