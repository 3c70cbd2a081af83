"""The tests that need no ROS, with the oldest and the newest of what is allowed.

The environments stay in build/matrix. uv makes them, since pip cannot be asked for the lowest versions.
"""
import glob
import hashlib
import os
import shutil
import subprocess
import sys

import pytest

SYSTEM, OLDEST = 'of the system', '3.8'
# What is installed: of requirements, which versions.
LOWEST = ['--resolution', 'lowest-direct', '-r', 'requirements.txt']
NEWEST = ['-r', 'pyproject.toml', '--extra', 'print']
# Tests marked "long" run in .venv and with the oldest of everything: between those the versions change little.
ALL, SHORT = 'not clips', 'not clips and not long'
WAYS = {'3.8, lowest': (OLDEST, LOWEST, ALL), 'system, lowest': (SYSTEM, LOWEST, SHORT),
        'system, newest': (SYSTEM, NEWEST, SHORT)}


def interpreter(which):
    """The path of a Python, or None."""
    if which == SYSTEM:
        return os.path.realpath(sys.executable)
    pyenv = os.environ.get('PYENV_ROOT', os.path.expanduser('~/.pyenv'))
    # Before those on PATH, which may be of pyenv, too, and then only say that it is not the one in use.
    for python in [*glob.glob(pyenv + '/versions/3.8.*/bin/python3.8'), shutil.which('python3.8')]:
        if python and subprocess.run([python, '--version'], stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL).returncode == 0:
            return python
    return None


def run(*command, **environment):
    """What a command prints, without the ROS and the packages of this process."""
    own = 'PYTHON', 'ROS', 'VIRTUAL_ENV', 'LD_PRELOAD'
    clean = {key: value for key, value in os.environ.items() if not key.startswith(own)}
    done = subprocess.run(command, env={**clean, **environment}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return done.stdout


def environment_of(package, python, wanted):
    """The Python of an environment in which that is installed, and the newest of what the tests need."""
    text = '\n'.join([python, *wanted])
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
        run(*install, *wanted)
        with open(folder + '/installed.txt', 'w') as file:
            file.write(run(*uv, 'pip', 'freeze', '-q', '--python', made))
        run(*install, '-r', 'test/requirements.txt', '-c', folder + '/installed.txt')
        with open(folder + '/complete', 'w'):
            pass
    return made


@pytest.mark.parametrize('way', WAYS)
def test_all_that_needs_no_ros_passes_with(way, package, tmp_path, monkeypatch):
    which, wanted, chosen = WAYS[way]
    python = interpreter(which)
    if python is None:
        pytest.skip('no python3.8, on PATH or of pyenv')
    monkeypatch.chdir(package)
    said = run(environment_of(package, python, wanted), '-m', 'pytest', '-q', '-p', 'no:cacheprovider',
               '--basetemp', str(tmp_path / 'tests'), '-m', chosen, 'test/plain',
               PYTHONPATH=package + '/src')
    assert ' passed' in said.splitlines()[-1] and ' failed' not in said
