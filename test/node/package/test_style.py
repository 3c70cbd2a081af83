"""ruff and mypy find nothing; .ruff.toml and .mypy.ini say what they check."""
import importlib.util
import os
import subprocess
import sys

import pytest

HAS_TYPES = os.path.exists(os.path.join(os.path.dirname(importlib.util.find_spec('cv2').origin), 'py.typed'))


@pytest.mark.parametrize('command', [['ruff', 'check'], ['mypy']], ids=['ruff', 'mypy'])
def test_the_linter_finds_no_fault(command, package):
    if command == ['mypy'] and sys.version_info < (3, 10):
        pytest.skip('mypy 2 needs Python 3.10')
    if command == ['mypy'] and not HAS_TYPES:
        pytest.skip('this OpenCV has no type hints, like that of Debian')
    done = subprocess.run([sys.executable, '-m', *command], cwd=package, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
