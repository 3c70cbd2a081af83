#!/usr/bin/env python3
"""Run a node in which some functions raise an error for as long as a file names them.

failing.py FILE MODULE:FUNCTION[,MODULE:FUNCTION...] NODE.py [argument...]
"""
import importlib
import runpy
import sys
from functools import reduce, wraps
from itertools import count

from rig.processes.started import program

NUMBERS = count()


def fail_at(place, file):
    """Make a function, MODULE:NAME or MODULE:CLASS.NAME, raise an error while the file names it."""
    module, _, path = place.partition(':')
    *owner, name = path.split('.')
    holder = reduce(getattr, owner, importlib.import_module(module))
    function = getattr(holder, name)

    @wraps(function)
    def may_fail(*arguments, **named):
        with open(file) as wanted:
            if place in wanted.read().split():
                raise RuntimeError('%s fails, number %d' % (place, next(NUMBERS)))
        return function(*arguments, **named)
    setattr(holder, name, may_fail)


if __name__ == '__main__':
    file, places, node = sys.argv[1:4]
    for each in places.split(','):
        fail_at(each, file)
    sys.argv = sys.argv[3:]
    runpy.run_path(program(node), run_name='__main__')
