"""What is written in C: as catkin has built it, or else compiled when it is first imported.

C called by ctypes, since one library then serves every Python. Numba would take 0.3 s to import and 110 MB more
in each node; what Cython builds is for one Python alone, and no easier to read.
"""
from __future__ import annotations

import ctypes
import glob
import hashlib
import os
import shutil
import subprocess
import tempfile

from aruco_ar.base.versions import TooOld

HERE = os.path.dirname(os.path.abspath(__file__))
COMPILER = 'cc'
FLAGS = ['-O3', '-shared', '-fPIC']


def library(name: str) -> ctypes.CDLL:
    """What NAME.c beside this file says. Raises TooOld where it is not built and there is no compiler.

    catkin builds libunit5_NAME.so, which is found by the workspace's environment. Without, as in a wheel, it is
    compiled once, and kept as Python keeps what it compiles: in ``__pycache__``, if that can be written.
    """
    try:
        return ctypes.CDLL('libunit5_%s.so' % name)
    except OSError:
        pass
    source = os.path.join(HERE, name + '.c')
    version = hashlib.sha256()
    for path in sorted(glob.glob(os.path.join(HERE, '*.[ch]'))):
        with open(path, 'rb') as file:
            version.update(file.read())
    kept = os.path.join(HERE, '__pycache__', '%s-%s.so' % (name, version.hexdigest()[:12]))
    try:
        return ctypes.CDLL(kept)
    except OSError:
        pass
    with tempfile.TemporaryDirectory() as folder:
        built = os.path.join(folder, name + '.so')
        _compile(source, built)
        found = ctypes.CDLL(built)  # stays loaded when the file is gone
        try:
            os.makedirs(os.path.dirname(kept), exist_ok=True)
            ours = '%s.%d' % (kept, os.getpid())  # others may be at it, too
            shutil.copy(built, ours)
            os.replace(ours, kept)
        except OSError:
            pass  # the next one compiles it again
    return found


def _compile(source: str, built: str) -> None:
    try:
        subprocess.run([COMPILER, *FLAGS, '-o', built, source, '-lm'], stdout=subprocess.DEVNULL,
                       stderr=subprocess.PIPE, text=True, check=True)
    except FileNotFoundError:
        raise TooOld('unit5 is not built, and there is no C compiler "%s" to build %s with. Run script/setup '
                     'in the folder of unit5, or: sudo apt install build-essential'
                     % (COMPILER, source)) from None
    except subprocess.CalledProcessError as error:
        raise TooOld('The C compiler "%s" does not build %s: %s' % (COMPILER, source, error.stderr)) from None
