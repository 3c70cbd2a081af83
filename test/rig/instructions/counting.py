"""How many instructions the package executes, as valgrind's callgrind counts them.

Unlike seconds, they do not depend on what else the machine does. As a program, `python3 -m
rig.instructions.counting` in the folder test, this counts anew and records the numbers, which a test compares.
"""
import json
import os
import platform
import re
import subprocess
import sys
import tempfile

import aruco_program  # noqa: F401  before NumPy and OpenCV
import numpy as np
from aruco_ar.compiled.compiler import COMPILER, compile_to

from rig.accuracy.drives import WIDE, drive

HERE = os.path.dirname(os.path.abspath(__file__))
RECORD = os.path.join(HERE, 'record.json')
LIBRARY = 'libunit5.so'
FRAMES = 30           # of a tracked second
WARM_UP = 12          # frames before it
SIZE = 384, 216       # pixels
LEAST = 0.002         # of all instructions in the library: functions with a smaller share are not compared


def machine():
    """What the numbers depend on: the processor's kind, and the versions of the compiler and of Python."""
    compiler = subprocess.run([COMPILER, '-dumpfullversion', '-dumpversion'], stdout=subprocess.PIPE, text=True)
    with open('/proc/cpuinfo') as file:
        vectors = 'AVX2' if re.search(r'\bavx2\b', file.read()) else 'no AVX2'
    return '%s, %s, cc %s, Python %d.%d' % (platform.machine(), vectors, compiler.stdout.split('.')[0].strip(),
                                            *sys.version_info[:2])


def count(folder):
    """{name: instructions}, of each function of the library and of a tracked second with all of Python.

    ``folder``: a new one.
    """
    frames = [frame.image for frame in drive(WIDE, WARM_UP + FRAMES, size=SIZE, noise=2.0, light=0.3)]
    np.save(os.path.join(folder, 'frames.npy'), np.array(frames))  # rendering is slow under valgrind
    compile_to(os.path.join(folder, LIBRARY))
    short, _ = _run(folder, 'track', WARM_UP)
    long, _ = _run(folder, 'track', WARM_UP + FRAMES)
    _, functions = _run(folder, 'kernels', 0)
    whole = sum(functions.values())
    found = {name: number for name, number in functions.items() if number > LEAST * whole}
    return {'a tracked second': long - short, **found}


def _run(folder, part, frames):
    """All instructions of a part of program.py, and {name: instructions} of the library's functions in it."""
    out = os.path.join(folder, '%s%d.out' % (part, frames))
    program = [sys.executable, os.path.join(HERE, 'program.py'), part, folder, str(frames)]
    paths = [folder, *filter(None, [os.environ.get('LD_LIBRARY_PATH')])]
    environment = {**os.environ, 'PYTHONHASHSEED': '0', 'LD_LIBRARY_PATH': os.pathsep.join(paths)}
    environment.pop('COVERAGE_PROCESS_START', None)  # to note each line takes more than the line
    for before in [], ['valgrind', '--tool=callgrind', '--callgrind-out-file=' + out]:
        # The first time, Python compiles what is imported, if nothing has done so before.
        subprocess.run([*before, *program], env=environment, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.PIPE)
    listed = subprocess.run(['callgrind_annotate', '--threshold=100', out], check=True, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    functions, total = {}, 0
    for line in listed.splitlines():
        match = re.match(r'\s*([\d,]+) \(.*?%\)\s+(?:PROGRAM TOTALS|\S*:(\w+)\S* \[.*/(\S+)\])', line)
        if match and match[2] is None:
            total = int(match[1].replace(',', ''))
        elif match and match[3].startswith((LIBRARY, 'libffi')):
            # What ctypes calls by libffi is taken for a part of that.
            name = match[2] if match[3] == LIBRARY else 'functions of unit5.h'
            functions[name] = functions.get(name, 0) + int(match[1].replace(',', ''))
    return total, functions


def recorded():
    """{machine: {name: instructions}}."""
    with open(RECORD) as file:
        return json.load(file)


if __name__ == '__main__':
    with tempfile.TemporaryDirectory() as new:
        numbers = {**recorded(), machine(): count(new)}
    with open(RECORD, 'w') as file:
        json.dump(numbers, file, indent=1, sort_keys=True)
        file.write('\n')
