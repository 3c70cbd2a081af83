"""Finding the library. catkin and wheels build it; otherwise it is compiled at the first import."""
from __future__ import annotations

import ctypes
import os
import shutil
import tempfile

from aruco_ar.base.versions import SetupError

from .compiler import HERE, NAME, CompilerError, compile_to, version_of_sources


def load() -> ctypes.CDLL:
    """The library that was built of the sources in this folder.

    A library of other sources is not used, since it may take other arguments. It is searched beside this file,
    where a wheel or an install space has it, on LD_LIBRARY_PATH, where catkin's devel space has it, and in the
    user's cache.
    Otherwise it is compiled and kept in that cache, if possible. Raises SetupError if it cannot be compiled or
    loaded.
    """
    version = version_of_sources()
    kept = os.path.join(_cache(), '%s-%s' % (version[:16], NAME))
    for path in [os.path.join(HERE, NAME), *_on_library_path(), kept]:
        found = _opened(path, version)
        if found is not None:
            return found
    return _built(kept)


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
    except CompilerError as error:
        old = ['"%s" is of another version.' % path for path in _on_library_path() if os.path.exists(path)]
        raise SetupError(' '.join([str(error), *old])) from None
    except OSError as error:
        problems.append(str(error))
    raise SetupError('unit5 is not built, and there is no folder in which it can be compiled and run (%s). Run '
                     'script/setup in the folder of unit5, or set XDG_CACHE_HOME to a folder in which programs '
                     'may be run.' % '; '.join(problems))
