"""The tests that need no ROS, with the oldest and the newest allowed Python and packages.

They are those of script/test --quick. The environments stay in build/matrix. uv creates them, since pip cannot
choose the lowest versions.
"""
import glob
import hashlib
import os
import shutil
import subprocess
import sys

import pytest
from runner import QUICK

SYSTEM, OLDEST = 'of the system', '3.8'
# The arguments of "uv pip install".
LOWEST = ['--resolution', 'lowest-direct', '-r', 'requirements.txt']
NEWEST = ['-r', 'pyproject.toml']
WAYS = {'3.8, lowest': (OLDEST, LOWEST), 'system, newest': (SYSTEM, NEWEST)}


def interpreter(which):
    """The path of a Python, or None if there is none."""
    if which == SYSTEM:
        return os.path.realpath(sys.executable)
    pyenv = os.environ.get('PYENV_ROOT', os.path.expanduser('~/.pyenv'))
    # Those of pyenv come first: if PATH leads to pyenv, too, it may only say that this version is not in use.
    for python in [*glob.glob(pyenv + '/versions/3.8.*/bin/python3.8'), shutil.which('python3.8')]:
        if python and subprocess.run([python, '--version'], stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL).returncode == 0:
            return python
    return None


def run(*command, **environment):
    """Run a command without the ROS and the packages of this process; returns its output."""
    own = 'PYTHON', 'ROS', 'VIRTUAL_ENV', 'LD_PRELOAD'
    clean = {key: value for key, value in os.environ.items() if not key.startswith(own)}
    done = subprocess.run(command, env={**clean, **environment}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return done.stdout


def environment_of(package, python, requirements):
    """The Python of an environment with these requirements, and the newest packages that the tests need."""
    text = '\n'.join([python, *requirements])
    for name in 'requirements.txt', 'pyproject.toml', 'test/requirements.txt':
        with open(os.path.join(package, name)) as file:
            text += file.read()
    folder = '%s/build/matrix/%s' % (package, hashlib.sha256(text.encode()).hexdigest()[:12])
    made = folder + '/bin/python'
    if not os.path.exists(folder + '/complete'):
        shutil.rmtree(folder, ignore_errors=True)
        uv = [sys.executable, '-m', 'uv']
        install = [*uv, 'pip', 'install', '--python', made, '--only-binary', ':all:']
        run(*uv, 'venv', '--python', python, folder)
        run(*install, *requirements)
        with open(folder + '/installed.txt', 'w') as file:
            file.write(run(*uv, 'pip', 'freeze', '-q', '--python', made))
        run(*install, '-r', 'test/requirements.txt', '-c', folder + '/installed.txt')
        with open(folder + '/complete', 'w'):
            pass
    return made


@pytest.mark.parametrize('way', WAYS)
def test_the_plain_tests_pass_with(way, package, tmp_path, monkeypatch):
    which, requirements = WAYS[way]
    python = interpreter(which)
    if python is None:
        pytest.skip('there is no python3.8 on PATH or in pyenv')
    monkeypatch.chdir(package)
    output = run(environment_of(package, python, requirements), '-m', 'pytest', '-q', '-p', 'no:cacheprovider',
                 '--basetemp', str(tmp_path / 'tests'), '-m', QUICK, 'test/plain',
                 PYTHONPATH=package + '/src')
    assert ' passed' in output.splitlines()[-1] and ' failed' not in output
