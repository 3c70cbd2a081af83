"""Where cv_bridge cannot work with the NumPy and OpenCV that are here, a node says so before it begins."""
import os
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_node.bridge import check_bridge


@pytest.fixture
def bridge(tmp_path, monkeypatch):
    """Makes a cv_bridge whose compiled part has these bytes, before the real one."""
    def make(data):
        folder = tmp_path / 'cv_bridge' / 'boost'
        folder.mkdir(parents=True)
        (tmp_path / 'cv_bridge' / '__init__.py').write_text('')
        (folder / 'cv_bridge_boost.cpython-38-x86_64-linux-gnu.so').write_bytes(b'\x7fELF' + data)
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, 'cv_bridge', raising=False)
    return make


def test_the_one_of_this_system_will_do():
    check_bridge()


FOR_1, FOR_2 = b'numpy.core._multiarray_umath', b'numpy._core._multiarray_umath\0numpy.core._multiarray_umath'


@pytest.mark.parametrize('numpy, data', [('1.17.4', FOR_1), ('1.26.4', FOR_2), ('2.4.6', FOR_2)])
def test_what_fits_is_taken(numpy, data, bridge, monkeypatch):
    bridge(data)
    monkeypatch.setattr(np, '__version__', numpy)
    check_bridge()


def test_one_for_numpy_1_is_refused_with_numpy_2(bridge, monkeypatch):
    bridge(FOR_1)
    monkeypatch.setattr(np, '__version__', '2.4.6')
    with pytest.raises(InputError, match=re.escape(
            'cv_bridge is built for NumPy 1, but NumPy 2.4.6 is here; run script/setup, or: pip install '
            '"numpy<2" "opencv-contrib-python-headless<4.12".')):
        check_bridge()


def test_opencv_5_is_refused(monkeypatch):
    monkeypatch.setattr(cv2, '__version__', '5.0.0')
    with pytest.raises(InputError, match='built for OpenCV 4, but OpenCV 5.0.0 is here'):
        check_bridge()


def test_a_program_without_cv_bridge_says_so(package, tmp_path):
    script = '''
import runpy
import sys
from importlib.machinery import PathFinder
class Without:
    def find_spec(self, name, *others):
        return None if name == 'cv_bridge' else PathFinder.find_spec(name, *others)
sys.meta_path[:] = [each for each in sys.meta_path if each is not PathFinder] + [Without()]
runpy.run_path(sys.argv[0], run_name='__main__')
'''
    name = package + '/src/annotate_bags.py'
    done = subprocess.run([sys.executable, '-c', 'import sys; sys.argv[:] = %r\n%s' % (
        [name, 'none.bag', '--out', str(tmp_path)], script)], env=os.environ, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 1 and 'Traceback' not in done.stdout
    assert done.stdout.startswith('annotate_bags: There is no cv_bridge for ' + sys.executable)
