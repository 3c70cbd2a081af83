"""A cv_bridge that does not fit NumPy, OpenCV or Python is explained, and what does not need it still works."""
import os
import re
import subprocess
import sys
from importlib.machinery import EXTENSION_SUFFIXES

import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_node.messages.bridge import fault_of_bridge
from aruco_node.messages.images import frame_from_image, image_from_frame
from sensor_msgs.msg import Image
from std_msgs.msg import Header


@pytest.fixture(autouse=True)
def fresh_cache():
    """Clears the cached result of the check of cv_bridge before and after each test."""
    fault_of_bridge.cache_clear()
    yield
    fault_of_bridge.cache_clear()


@pytest.fixture
def bridge(tmp_path, monkeypatch):
    """A function that puts a cv_bridge, whose compiled part has these bytes, before the real one."""
    def make(data, suffix=EXTENSION_SUFFIXES[0]):
        folder = tmp_path / 'cv_bridge' / 'boost'
        folder.mkdir(parents=True)
        (tmp_path / 'cv_bridge' / '__init__.py').write_text('')
        (folder / ('cv_bridge_boost' + suffix)).write_bytes(b'\x7fELF' + data)
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, 'cv_bridge', raising=False)
    return make


def test_the_cv_bridge_of_this_system_fits():
    assert fault_of_bridge() is None


SENTENCE = 'cv_bridge is built for NumPy 1, but NumPy 2.4.6 is here; run script/setup, or: pip install ' \
    '"numpy<2" "opencv-contrib-python-headless<4.12".'
FOR_1, FOR_2 = b'numpy.core._multiarray_umath', b'numpy._core._multiarray_umath\0numpy.core._multiarray_umath'


@pytest.mark.parametrize('numpy, data', [('1.17.4', FOR_1), ('1.26.4', FOR_2), ('2.4.6', FOR_2)])
def test_a_cv_bridge_that_fits_is_used(numpy, data, bridge, monkeypatch):
    bridge(data)
    monkeypatch.setattr(np, '__version__', numpy)
    assert fault_of_bridge() is None


def test_a_cv_bridge_for_numpy_1_is_refused_with_numpy_2(bridge, monkeypatch):
    bridge(FOR_1)
    monkeypatch.setattr(np, '__version__', '2.4.6')
    assert fault_of_bridge() == SENTENCE
    pixels = np.full((2, 2, 3), 7, np.uint8)
    np.testing.assert_array_equal(frame_from_image(image_from_frame(pixels, Header())), pixels)
    with pytest.raises(InputError, match='encoding "mono16" cannot be used without cv_bridge. ' +
                       re.escape(SENTENCE)):
        frame_from_image(Image(width=1, height=1, encoding='mono16', step=2, data=bytes(2)))


def test_opencv_5_is_refused(monkeypatch):
    monkeypatch.setattr(cv2, '__version__', '5.0.0')
    assert 'built for OpenCV 4, but OpenCV 5.0.0 is here' in fault_of_bridge()


def test_a_cv_bridge_for_another_python_is_refused(bridge, monkeypatch):
    bridge(FOR_1, '.cpython-36m-x86_64-linux-gnu.so')
    assert fault_of_bridge() == "cv_bridge is not built for Python %d.%d; run script/setup, which takes the " \
        "system's own." % sys.version_info[:2]


def test_a_program_says_that_cv_bridge_does_not_fit(package, tmp_path):
    """The only cv_bridge that the program finds is built for another Python."""
    (tmp_path / 'cv_bridge' / 'boost').mkdir(parents=True)
    (tmp_path / 'cv_bridge' / '__init__.py').write_text('')
    path = os.pathsep.join([str(tmp_path), os.environ['PYTHONPATH']])
    command = [sys.executable, package + '/nodes/annotate_bags.py', 'none.bag', '--out', str(tmp_path / 'out')]
    done = subprocess.run(command, env=dict(os.environ, PYTHONPATH=path), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 1 and 'Traceback' not in done.stdout
    assert done.stdout.startswith('annotate_bags: cv_bridge is not built for Python')
