"""Finding libunit5.so. catkin builds it; without catkin, as in a wheel, it is compiled at the first import."""
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
NAME = 'libunit5.so'
COMPILER = 'cc'
FLAGS = ['-O3', '-fno-math-errno', '-fvisibility=hidden', '-shared', '-fPIC']  # as in CMakeLists.txt


def load() -> ctypes.CDLL:
    """The library that was built of the sources in this folder.

    A library of other sources is not used, since it may take other arguments. It is searched on
    LD_LIBRARY_PATH, where catkin's environment has it, and in the user's cache. Otherwise it is compiled and
    kept in that cache, if possible. Raises SetupError if it cannot be compiled or loaded.
    """
    version = version_of_sources()
    kept = os.path.join(_cache(), '%s-%s' % (version[:16], NAME))
    for path in [*_on_library_path(), kept]:
        found = _opened(path, version)
        if found is not None:
            return found
    return _built(kept)


def version_of_sources() -> str:
    """What the C function unit5_version returns if it was built of the sources in this folder."""
    digests = []
    for path in sources('*.[ch]'):
        with open(path, 'rb') as file:
            digests.append(hashlib.sha256(file.read()).hexdigest())
    return hashlib.sha256(''.join(digests).encode()).hexdigest()  # CMakeLists.txt does the same


def sources(pattern: str = '*.c') -> list[str]:
    """The paths of the files in C in this folder."""
    return sorted(glob.glob(os.path.join(glob.escape(HERE), pattern)))


def compile_to(path: str, *more_flags: str) -> None:
    """Compile the library. Raises SetupError if there is no compiler, or it fails."""
    version = '-DUNIT5_VERSION="%s"' % version_of_sources()
    try:
        subprocess.run([COMPILER, *FLAGS, *more_flags, version, '-o', path, *sources(), '-lm'],
                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
    except FileNotFoundError:
        old = ['"%s" is of another version.' % path for path in _on_library_path() if os.path.exists(path)]
        raise SetupError(' '.join([
            'unit5 is not built, and there is no C compiler "%s" to build %s with.' % (COMPILER, HERE), *old,
            'Run script/setup in the folder of unit5, or: sudo apt install build-essential'])) from None
    except subprocess.CalledProcessError as error:
        raise SetupError('The C compiler "%s" cannot build %s. Run script/setup in the folder of unit5. The '
                         'compiler says: %s' % (COMPILER, HERE, error.stderr)) from None


def _on_library_path() -> list[str]:
    """Where the library may be on LD_LIBRARY_PATH."""
    folders = os.environ.get('LD_LIBRARY_PATH', '').split(os.pathsep)
    return [os.path.join(folder, NAME) for folder in folders if folder]


def _cache() -> str:
    """The folder in which a compiled library is kept."""
    chosen = os.environ.get('XDG_CACHE_HOME', '')
    return os.path.join(chosen if os.path.isabs(chosen) else os.path.expanduser('~/.cache'), 'unit5')


def _opened(path: str, version: str) -> ctypes.CDLL | None:
    """The library at a path if it has that version, else None."""
    try:
        library = ctypes.CDLL(path)
        library.unit5_version.restype = ctypes.c_char_p
        return library if library.unit5_version() == version.encode() else None
    except (OSError, AttributeError):  # there is none, or it does not tell its version
        return None


def _built(kept: str) -> ctypes.CDLL:
    """The library, compiled and kept at that path. If it cannot be, it stays loaded though its file is gone."""
    problems = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            built = os.path.join(folder, NAME)
            compile_to(built)
            try:
                os.makedirs(os.path.dirname(kept), exist_ok=True)
                draft = '%s.%d' % (kept, os.getpid())  # other processes may do the same at this moment
                shutil.copy(built, draft)
                os.replace(draft, kept)
                return ctypes.CDLL(kept)
            except OSError as error:  # not writable, or mounted so that nothing in it may be run
                problems.append(str(error))
            return ctypes.CDLL(built)
    except OSError as error:
        problems.append(str(error))
    raise SetupError('unit5 is not built, and there is no folder in which it can be compiled and run (%s). Run '
                     'script/setup in the folder of unit5, or set XDG_CACHE_HOME to a folder in which programs '
                     'may be run.' % '; '.join(problems))
