#!/usr/bin/env python3
"""Fuzz --target=NAME with atheris. The other arguments are those of libFuzzer, which ignores this one."""
import sys

import atheris

with atheris.instrument_imports(include=['aruco_ar', 'aruco_node', 'yaml', 'PIL']):
    from fuzz.targets import TARGETS

if __name__ == '__main__':
    target, = [argument.partition('=')[2] for argument in sys.argv if argument.startswith('--target=')]
    atheris.Setup(sys.argv, TARGETS[target])
    atheris.Fuzz()
