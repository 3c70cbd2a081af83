"""aruco_ar and the course, installed by pip in an environment without ROS and other packages."""
import ctypes
import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile

import cv2
import numpy as np
import pytest
from aruco_ar import Detector, find_area
from aruco_ar.compiled.compiler import version_of_sources
from rig import VERSION
from rig.page.server import ask, free_port
from rig.processes.started import Started


@pytest.fixture(params=['here', pytest.param('by script/wheels', marks=[
    pytest.mark.long, pytest.mark.xdist_group('wheels')])])
def installable(request, package, tmp_path):
    """What pip installs: the sources, which it compiles here, or the wheel that script/wheels makes."""
    if request.param == 'by script/wheels':
        wheel, = request.getfixturevalue('wheels').glob('*-manylinux_2_17_%s.*' % os.uname().machine)
        return str(wheel)
    # A copy, since building leaves files behind.
    return shutil.copytree(package, str(tmp_path / 'unit5'), symlinks=True, ignore=shutil.ignore_patterns(
        '.git', '.venv', 'build', 'bags', 'dist', '__pycache__'))


def test_the_example_of_the_docs_and_the_course_run_with_the_wheel_alone(package, frame, tmp_path, installable):
    clean = {key: value for key, value in os.environ.items() if not key.startswith(('PYTHON', 'LD_'))}

    def run(*command, **environment):
        done = subprocess.run(command, cwd=str(tmp_path), env={**clean, **environment}, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, done.stdout
        return done.stdout
    venv.create(str(tmp_path / 'env'), with_pip=True)
    python = str(tmp_path / 'env' / 'bin' / 'python')
    # Only the sources need a compiler.
    run(python, '-m', 'pip', 'install', '-q', installable,
        **{'PATH': ''} if installable.endswith('.whl') else {})
    with open(package + '/docs/reference/aruco_ar.md', encoding='utf-8') as page:
        example = re.search(r'```python\n(import cv2\nfrom aruco_ar .*?)```', page.read(), re.DOTALL)[1]
    cv2.imwrite(str(tmp_path / 'photo.jpg'), frame, [cv2.IMWRITE_JPEG_QUALITY, 95])
    os.symlink(package + '/images', str(tmp_path / 'images'))
    library, = (tmp_path / 'env').glob('lib/python*/site-packages/aruco_ar/compiled/libunit5.so')
    before = sorted(library.parent.rglob('*'))
    # It needs no compiler then, which it would not find, and it writes nothing beside itself or into the cache.
    run(python, '-c', example, PATH='', XDG_CACHE_HOME=str(tmp_path / 'cache'))
    assert sorted(library.parent.rglob('*')) == before and not (tmp_path / 'cache').exists()
    painted = cv2.imread(str(tmp_path / 'painted.png'))
    mask = cv2.fillConvexPoly(np.zeros(frame.shape[:2], np.uint8),
                              np.int32(find_area(Detector().detect(frame)).corners.round()), 255)
    off = np.abs(painted.astype(int) - frame).max(axis=2)
    inside, outside = cv2.erode(mask, np.ones((9, 9))) > 0, cv2.dilate(mask, np.ones((9, 9))) == 0
    assert np.median(off[inside]) > 30 > 20 > off[outside].mean()
    # So does the command, with a picture, an exercise and a generator of tags of its own.
    command = str(tmp_path / 'env' / 'bin' / 'aruco-ar')
    said = run(command, 'paint', 'photo.jpg', '--out', 'command.png', PATH='')
    assert said == 'Wrote command.png: the picture is in 1 of 1 frames, between tags of DICT_6X6_250.\n'
    assert np.abs(cv2.imread(str(tmp_path / 'command.png')).astype(int) - painted).mean() < 2
    run(command, 'tags', PATH='')
    assert (tmp_path / 'wall.pdf').read_bytes().startswith(b'%PDF')
    # The page is served, too, also while there is no camera.
    port = free_port()
    serving = Started(command, 'paint', '--camera', 'none.avi', '--port', str(port))
    serving.wait_for('The page is at http://localhost:%d' % port)
    for path, words in ('/', b'A picture in its place'), ('/page/page.js', b'import'), (
            '/picture?name=earth.jpg', b'JFIF'):
        status, _, body = ask(port, path)
        assert status == 200 and words in body
    serving.stop()
    # The course needs no more than that.
    learn = str(tmp_path / 'env' / 'bin' / 'aruco-learn')
    run(learn, 'start', 'mine', PATH='')
    installed, = (tmp_path / 'env').glob('lib/python*/site-packages/aruco_course')
    solution = installed / 'exercises' / 'exercise5_6' / 'solution.py'
    shutil.copyfile(str(solution), str(tmp_path / 'mine' / 'src' / 'exercise5_6.py'))
    run(learn, 'check', '5.6', '--package', 'mine', PATH=os.path.dirname(learn))


def test_the_wheel_contains_what_needs_no_ros_and_nothing_else(package, tmp_path):
    done = subprocess.run([sys.executable, '-m', 'uv', 'build', '-q', '--wheel', '--out-dir', str(tmp_path),
                           package], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    wheel, = tmp_path.glob('aruco_ar-%s-py3-none-linux_%s.whl' % (VERSION, os.uname().machine))
    with zipfile.ZipFile(str(wheel)) as archive:
        assert {name.split('/')[0] for name in archive.namelist()} == {
            'aruco_ar', 'aruco_course', 'aruco_desk', 'aruco_program', 'page_server',
            'aruco_ar-%s.dist-info' % VERSION}
        archive.extract('aruco_ar/compiled/libunit5.so', str(tmp_path))
    library = ctypes.CDLL(str(tmp_path / 'aruco_ar' / 'compiled' / 'libunit5.so'))
    library.unit5_version.restype = ctypes.c_char_p
    assert library.unit5_version().decode() == version_of_sources()  # of the sources and the flags
