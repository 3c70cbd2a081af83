"""A system that lacks what only Linux has: see rig/systems/without.py."""
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest
from rig.systems.without import install

pytestmark = pytest.mark.long

FILES = '''
import os, sys
import aruco_program
from aruco_ar import InputError
from aruco_ar.base.files import path_of, read_whole, write_whole
from aruco_ar.painting.sources import open_source
assert not hasattr(os, 'O_TMPFILE') and not os.path.isdir('/proc/self/fd')
os.chdir(sys.argv[1])
write_whole('new/file', b'one')
write_whole('new/file', b'another')
assert read_whole('new/file', 10) == b'another' and os.listdir('new') == ['file']
source = open_source('clip.avi')
print(*[int(source.at(stamp)[24, 32, 0]) for stamp in (0, 0.25)])
os.mkfifo('pipe')
try:
    read_whole('pipe', 10)
except InputError as error:
    print(error)
try:
    open_source(os.fsdecode(b'clip\\xff.avi'))
except InputError as error:
    print(str(error)[-60:])
'''
# It takes away what would end its process from within.
ENDLESS = '\nimport faulthandler\nfaulthandler.cancel_dump_traceback_later()\nwhile True:\n    pass\n'
LEARN = 'import sys; from aruco_course.command import aruco_learn; sys.exit(aruco_learn())'


@pytest.fixture
def run(package, tmp_path):
    """A function that runs Python without what only Linux has; returns (exit code, output)."""
    (tmp_path / 'site').mkdir()
    paths = [install(str(tmp_path / 'site')), package + '/src']

    def started(*arguments):
        environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(paths), 'PYTHONWARNINGS': 'ignore'}
        done = subprocess.run([sys.executable, *arguments], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=200)
        return done.returncode, done.stdout
    return started


def test_files_are_written_and_read_and_a_video_plays(run, tmp_path):
    writer = cv2.VideoWriter(str(tmp_path / 'clip.avi'), cv2.VideoWriter_fourcc(*'MJPG'), 5, (64, 64))
    for gray in 50, 200:
        writer.write(np.full((64, 64, 3), gray, np.uint8))
    writer.release()
    with open(os.fsencode(str(tmp_path)) + b'/clip\xff.avi', 'wb') as copy:
        copy.write((tmp_path / 'clip.avi').read_bytes())
    code, output = run('-c', FILES, str(tmp_path))
    assert code == 0, output
    colors, pipe, no_text = output.splitlines()
    first, second = map(int, colors.split())
    assert abs(first - 50) < 3 and abs(second - 200) < 3
    assert pipe == '"pipe" is not a file but a folder, pipe or device; give the path of a file.'
    assert no_text.endswith('Check its path and its permissions.')


def test_the_course_judges_a_solution_and_ends_what_never_ends(run, package, tmp_path):
    mine = str(tmp_path / 'mine')
    code, output = run('-c', LEARN, 'start', mine)
    assert code == 0, output
    with open(package + '/src/aruco_course/exercises/exercise5_3/solution.py') as solution:
        right = solution.read()
    source = os.path.join(mine, 'src', 'exercise5_3.py')
    with open(source, 'w') as file:
        file.write(right)
    code, output = run('-c', LEARN, 'check', '5.3', '--package', mine)
    assert code == 0, output
    with open(source, 'w') as file:
        file.write(right.replace('\nimport cv2', ENDLESS + 'import cv2', 1))
    code, output = run('-c', LEARN, 'check', '5.3', '--package', mine)
    assert code == 1 and 'was not imported within' in output, output
