"""The parts written in C. catkin builds them; without catkin, they are compiled at the first import.

They are called by ctypes, so that one library serves every version of Python. Numba would take 0.3 s to import
and 110 MB more in each node. Cython's output works with one version of Python only, and is no easier to read.
"""
from __future__ import annotations

import ctypes
import glob
import hashlib
import os
import shutil
import subprocess
import tempfile

from aruco_ar.base.versions import SetupError

HERE = os.path.dirname(os.path.abspath(__file__))
COMPILER = 'cc'
FLAGS = ['-O3', '-fno-math-errno', '-shared', '-fPIC']


def library(name: str) -> ctypes.CDLL:
    """The library of NAME.c in this folder. Raises SetupError if it is not built and there is no compiler.

    catkin builds libunit5_NAME.so, which is found through the workspace's environment. Otherwise, as in a
    wheel, it is compiled once. It is kept in ``__pycache__``, if that is writable.
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
            draft = '%s.%d' % (kept, os.getpid())  # other processes may do the same at this moment
            shutil.copy(built, draft)
            os.replace(draft, kept)
        except OSError:
            pass  # not writable, so the next process compiles it again
    return found


def _compile(source: str, built: str) -> None:
    try:
        subprocess.run([COMPILER, *FLAGS, '-o', built, source, '-lm'], stdout=subprocess.DEVNULL,
                       stderr=subprocess.PIPE, text=True, check=True)
    except FileNotFoundError:
        raise SetupError('unit5 is not built, and there is no C compiler "%s" to build %s with. Run '
                         'script/setup in the folder of unit5, or: sudo apt install build-essential'
                         % (COMPILER, source)) from None
    except subprocess.CalledProcessError as error:
        raise SetupError('The C compiler "%s" cannot build %s. Run script/setup in the folder of unit5. The '
                         'compiler says: %s' % (COMPILER, source, error.stderr)) from None
