"""How the library is compiled: by catkin, into a wheel, and at the first import without either of them.

Run as a program, this prints the flags for CMakeLists.txt. It needs nothing else of the package.
"""
from __future__ import annotations

import glob
import hashlib
import os
import subprocess
import sys
from typing import Sequence

HERE = os.path.dirname(os.path.abspath(__file__))
NAMES = {'win32': 'unit5.dll', 'darwin': 'libunit5.dylib', 'linux': 'libunit5.so'}  # for each sys.platform
NAME = NAMES.get(sys.platform, NAMES['linux'])
COMPILER = 'cc'
FLAGS = ['-O3', '-fno-math-errno', '-fno-trapping-math', '-fvisibility=hidden', '-Wall', '-Wextra',
         '-Werror=vla']


class CompilerError(Exception):
    """Its message is a sentence that says what is missing or wrong, and what to do."""


def version_of_sources() -> str:
    """What the C function unit5_version returns if it was built of the files in this folder."""
    digest = hashlib.sha256()
    for path in [*sources('*.[ch]'), os.path.abspath(__file__)]:
        with open(path, 'rb') as file:
            digest.update(hashlib.sha256(file.read()).digest())
    return digest.hexdigest()


def sources(pattern: str = '*.c') -> list[str]:
    """The paths of the files in C in this folder."""
    return sorted(glob.glob(os.path.join(glob.escape(HERE), pattern)))


def flags() -> list[str]:
    """The compiler's flags, for every build."""
    return [*FLAGS, '-DUNIT5_VERSION="%s"' % version_of_sources()]


def compile_to(path: str, *more_flags: str, compiler: Sequence[str] = (COMPILER,)) -> None:
    """Compile the library. Raises CompilerError if there is no compiler, or it fails."""
    try:
        subprocess.run([*compiler, *flags(), '-shared', '-fPIC', *more_flags, '-o', path, *sources(), '-lm'],
                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
    except FileNotFoundError:
        raise CompilerError('unit5 is not built, and there is no C compiler "%s" to build %s with. Run '
                            'script/setup in the folder of unit5, or install a wheel that was made for this '
                            'system, or a compiler: sudo apt install build-essential (on macOS: xcode-select '
                            '--install)' % (compiler[0], HERE)) from None
    except subprocess.CalledProcessError as error:
        raise CompilerError('The C compiler "%s" cannot build %s. Run script/setup in the folder of unit5. The '
                            'compiler says: %s' % (compiler[0], HERE, error.stderr)) from None


if __name__ == '__main__':
    print(';'.join(flags()))
