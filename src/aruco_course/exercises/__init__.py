"""The exercises: each folder has the solution and the check of one. To add an exercise, add a folder."""
from __future__ import annotations

import os
import re
from importlib import import_module

from aruco_course.check import Exercise

_HERE = os.path.dirname(os.path.abspath(__file__))


def _found() -> tuple[Exercise, ...]:
    names = [name for name in os.listdir(_HERE) if re.fullmatch(r'exercise\d+_\d+', name)
             and os.path.isfile(os.path.join(_HERE, name, 'check.py'))]
    names.sort(key=lambda name: [int(number) for number in re.findall(r'\d+', name)])
    return tuple(import_module('%s.%s.check' % (__name__, name)).CHECK for name in names)


# In the order of their numbers.
CHECKS: tuple[Exercise, ...] = _found()
