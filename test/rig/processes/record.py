"""A record of what a part of the benchmark prints, for the documentation."""
import os
import sys
from contextlib import contextmanager

from rig import PACKAGE

FOLDER = os.path.join(PACKAGE, 'docs', 'results')


class _Tee:
    """Writes to several files at once."""

    def __init__(self, *files):
        self._files = files

    def write(self, text):
        for file in self._files:
            file.write(text)

    def flush(self):
        for file in self._files:
            file.flush()


@contextmanager
def recorded(name, wanted=True):
    """Print as usual while the block runs. If ``wanted``, docs/results/NAME.txt then holds the output, too."""
    if not wanted:
        yield
        return
    path = os.path.join(FOLDER, name + '.txt')
    os.makedirs(FOLDER, exist_ok=True)
    with open(path + '.new', 'w') as file:
        before, sys.stdout = sys.stdout, _Tee(sys.stdout, file)
        try:
            yield
        finally:
            sys.stdout = before
    os.replace(path + '.new', path)
