"""Every program first checks its requirements, and says in one sentence what is missing or too old."""
import glob
import os
import re
import subprocess
import sys

import pytest
from aruco_ar.base.files import package_folder
from aruco_ar.base.versions import LOWEST, SetupError, need

PACKAGE = package_folder()
PROGRAMS = sorted(glob.glob(PACKAGE + '/src/*.py') + glob.glob(PACKAGE + '/nodes/*.py'))


def create_stand_in(folder, name, version):
    """Create a module that only has a version."""
    (folder / (name + '.py')).write_text('version = __version__ = %r' % version)


def output_of_failure(folder, *command):
    """Run a command for which the modules in a folder come first; it must fail. Returns its output."""
    path = os.pathsep.join([str(folder), PACKAGE + '/src', os.environ.get('PYTHONPATH', '')])
    done = subprocess.run([sys.executable, *command], env=dict(os.environ, PYTHONPATH=path),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 1, done.stdout
    return done.stdout


@pytest.mark.parametrize('program', PROGRAMS, ids=os.path.basename)
def test_every_program_says_what_is_too_old_and_what_to_do(program, tmp_path):
    create_stand_in(tmp_path, 'cv2', '4.2.0')
    assert output_of_failure(tmp_path, program) == (
        'unit5 needs OpenCV 4.9 or later, but %s has 4.2.0. Run script/setup in the folder of unit5 and build '
        'it again, or: pip install "opencv-contrib-python-headless>=4.9,<4.12".\n' % sys.executable)


@pytest.mark.parametrize('module, version, sentence', [
    ('numpy', '1.17.4', 'unit5 needs NumPy 1.23 or later, but .* has 1.17.4.* "numpy>=1.23,<2".'),
    ('numpy', '1.9', 'unit5 needs NumPy 1.23 or later, but .* has 1.9.'),  # not compared as text
    ('PIL', '7.0.0', 'unit5 needs Pillow 9.1 or later, but .* has 7.0.0.'),
    ('cv2', '4.8.1-dev', 'unit5 needs OpenCV 4.9 or later, but .* has 4.8.1-dev.')])
def test_the_version_of_each_requirement_is_checked(module, version, sentence, tmp_path):
    create_stand_in(tmp_path, module, version)
    text = output_of_failure(tmp_path, '-c', 'import aruco_program')
    assert re.match(sentence, text) and text.count('\n') == 1


def test_importing_aruco_ar_raises_the_same_sentence(tmp_path):
    create_stand_in(tmp_path, 'cv2', '4.2.0')
    assert output_of_failure(tmp_path, '-c', 'import aruco_ar').splitlines()[-1].startswith(
        'aruco_ar.base.versions.SetupError: unit5 needs OpenCV 4.9 or later')


CHANGES = '''
import os, signal, sys, warnings
import cv2, numpy, PIL.Image, yaml  # these may change anything

def state():
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    return [sys.excepthook, dict(os.environ), handlers, signal.pthread_sigmask(signal.SIG_BLOCK, []),
            list(warnings.filters), PIL.Image.MAX_IMAGE_PIXELS, cv2.getNumThreads(), list(sys.path)]
before = state()
import aruco_ar, pkgutil, importlib
for module in pkgutil.walk_packages(aruco_ar.__path__, 'aruco_ar.'):
    importlib.import_module(module.name)
assert state() == before
'''


def test_importing_aruco_ar_changes_nothing():
    done = subprocess.run([sys.executable, '-c', CHANGES], env=dict(os.environ, PYTHONPATH=PACKAGE + '/src'),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout


def test_a_missing_requirement_is_named():
    text = output_of_failure('none', '-S', '-c', 'import aruco_program')  # -S hides all installed packages
    assert re.match('unit5 needs NumPy 1.23 or later, but .* has none', text) and text.count('\n') == 1


@pytest.mark.parametrize('version, good', [
    ('6.4.2', True), ('6.4.10', True), ('6.5', True), ('7.0.0rc1', True), ('10', True),
    ('6.4.1', False), ('6.4', False), ('5.9.9', False), ('unknown', False)])
def test_versions_are_compared_as_numbers(version, good, tmp_path, monkeypatch):
    create_stand_in(tmp_path, 'tornado', version)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, 'tornado', raising=False)
    if good:
        need('tornado')
    else:
        with pytest.raises(SetupError, match='needs Tornado 6.4.2 or later, but .* has ' + version):
            need('tornado')


def test_the_requirements_for_pip_are_the_same():
    def lines(name):
        with open(os.path.join(PACKAGE, name)) as file:
            return file.read()
    for module, (_, lowest, package) in LOWEST.items():
        number = '.'.join(map(str, lowest))
        if module == 'python':
            assert 'requires-python = ">=%s"' % number in lines('pyproject.toml')
            continue
        assert re.search('^%s($|;)' % re.escape(package), lines('requirements.txt'), re.MULTILINE)
        name = package.partition('>')[0]
        assert package == '%s>=%s,%s' % (name, number, package.partition(',')[2])
        if name not in ('tornado', 'distributed', 'av', 'mcap'):  # aruco_ar does not need these
            assert '"%s>=%s,' % (name, number) in lines('pyproject.toml')
