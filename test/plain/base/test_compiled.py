"""The C code also works if catkin has not built it."""
import os
import shutil
import subprocess
import sys

import pytest

FIT = '''
import cv2, numpy
from aruco_ar import Detector, draw_tag
tag, = Detector().detect(cv2.copyMakeBorder(draw_tag('DICT_6X6_250', 7), 50, 50, 50, 50, 0, value=255))
assert tag.id == 7 and abs(tag.corners - 399.5).max() < 350.6
'''


@pytest.fixture
def copied(package, tmp_path):
    """A function that runs FIT with a copy of aruco_ar and this PATH, and returns (exit code, output)."""
    shutil.copytree(package + '/src/aruco_ar', str(tmp_path / 'aruco_ar'),
                    ignore=shutil.ignore_patterns('__pycache__'))

    def run(path):
        clean = {key: value for key, value in os.environ.items() if key != 'LD_LIBRARY_PATH'}
        clean.update(PYTHONPATH=str(tmp_path), PATH=path)
        done = subprocess.run([sys.executable, '-c', FIT], env=clean, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout
    return run


def test_it_is_compiled_only_once(copied, tmp_path):
    if shutil.which('cc') is None:
        pytest.skip('no C compiler')
    assert copied(os.environ['PATH']) == (0, '')
    assert len(list((tmp_path / 'aruco_ar' / 'compiled' / '__pycache__').glob('edges-*.so'))) == 1
    assert copied('') == (0, '')  # no compiler is found now


def test_without_a_compiler_one_sentence_says_what_to_do(copied):
    code, output = copied('')
    assert code == 1
    assert 'SetupError: unit5 is not built, and there is no C compiler "cc"' in output.splitlines()[-1]
    assert 'sudo apt install build-essential' in output
