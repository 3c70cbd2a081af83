"""The check of a running node, as far as it needs no ROS: its process, and which frame an image shows."""
import os
import threading

import cv2
import numpy as np
import pytest
from aruco_course.black_box import sentences
from aruco_course.black_box.matching import Background, has_exchanged_colors
from aruco_course.black_box.running import Program
from aruco_course.black_box.verdict import NodeVerdict, command_for_node
from aruco_course.judge.views import area_of, area_views
from rig.processes.started import WAIT_S


@pytest.fixture
def run(tmp_path):
    """A function that runs a source as a program, and waits until it ends, or has printed some words."""
    running = []

    def start(source, words=None, interpreter='#!/usr/bin/env python3'):
        path = tmp_path / 'node.py'
        path.write_text('%s\n%s' % (interpreter, source))
        path.chmod(0o755)
        changed = threading.Condition()
        program = Program([str(path)], dict(os.environ, PYTHONFAULTHANDLER='1'), str(tmp_path), changed)
        running.append(program)
        with changed:
            assert changed.wait_for(lambda: program.code is not None if words is None
                                    else words in program.printed, WAIT_S)
        return program
    yield start
    for program in running:
        program.stop(politely=False)


@pytest.mark.parametrize('source, words', [
    ('import cv2\nimport numpy\ncv2.drawContours(numpy.eye(9), [numpy.ones((4, 2))], -1, 0)', 'Line 4: '),
    ('import cv2\ncv2.aruco.Dictionary_get(0)', 'Line 3: OpenCV'),
    ('import nump as np', 'there is no module nump'),
    ('def f(:\n    pass', 'Line 2: '),
    ('print(1)', 'The node ends by itself'),
    ('import sys\nsys.exit("no camera")', 'The node ended with the exit code 1. It printed last: no camera'),
    ('import os\nos.kill(os.getpid(), 11)', 'The node crashed: it got the signal SIGSEGV'),
    ('import os\nprint("%s.", flush=True)\nos.abort()' % sentences.NO_QT,
     'Line 4: there is no screen to show a window on')])
def test_the_end_of_a_program_is_said_in_a_sentence(run, source, words):
    assert words in str(sentences.ended(run(source)))


def test_an_exception_of_cpp_is_said(run):
    printed = "terminate called after throwing an instance of 'cv::Exception'\n  what():  OpenCV(4.6.0) bad"
    assert 'cv::Exception: OpenCV(4.6.0) bad' in str(sentences.ended(run('print("""%s""")' % printed)))


def test_what_starts_no_program_is_said(tmp_path):
    path = tmp_path / 'node.py'
    for first, words in ((b'import rospy\n', '#!/usr/bin/env python3'),
                         (b'#!/usr/bin/env python3\r\n', 'line ends of Windows'),
                         (b'#!/no/such/python\n', 'cannot be started')):
        path.write_bytes(first)
        assert words in str(sentences.not_startable(str(path), OSError(2, 'No such file or directory')))


def test_a_loop_without_end_is_at_its_line(run):
    program = run('number = 0\n'
                  'while True:\n'
                  '    number += 1\n'
                  '    if number == 9:\n'
                  '        print("on", flush=True)', 'on')
    assert program.line_at_work() in (3, 4, 5, 6)


def test_output_without_end_is_cut(run):
    program = run('while True:\n    print("line " * 1000)', 'line')
    with program._changed:
        assert program._changed.wait_for(lambda: program.count > 1 << 20, WAIT_S)
    assert len(program.printed) <= 64 * 1024


def test_what_a_program_has_started_ends_with_it(run):
    program = run('import subprocess\nchild = subprocess.Popen(["sleep", "1000"])\n'
                  'print(child.pid, flush=True)\nchild.wait()', '\n')
    child = int(program.printed)
    program.stop(politely=False)
    with pytest.raises(ProcessLookupError):
        while True:  # until its parent, the init process, has taken note of its end
            os.kill(child, 0)
            with open('/proc/%d/stat' % child) as file:
                if file.read().rpartition(')')[2].split()[0] == 'Z':
                    raise ProcessLookupError


def test_an_image_shows_its_frame_whatever_is_drawn_on_it():
    views = area_views()
    background = Background([view.frame for view in views])
    for number, view in enumerate(views):
        image = view.frame.copy()
        cv2.fillConvexPoly(image, np.int32(area_of(view)), (200, 0, 90))
        small = cv2.resize(image, None, fx=0.7, fy=0.7)
        for shown in image, small, small[..., ::-1], cv2.cvtColor(image, cv2.COLOR_BGR2GRAY):
            assert background.number(shown) == number


def test_exchanged_colors_are_noticed():
    frames = [view.frame for view in area_views()]
    assert has_exchanged_colors(frames, [frame[..., ::-1] for frame in frames])
    assert not has_exchanged_colors(frames, frames)
    assert not has_exchanged_colors(frames, [np.zeros_like(frame) for frame in frames])
    assert not has_exchanged_colors(frames, [frame[..., 1] for frame in frames])


def test_a_verdict_is_read_from_what_the_command_prints():
    verdict = NodeVerdict('5.4', 'my_unit5/exercise5_4.py', False, 'it crosses itself', 'Frame 2')
    assert NodeVerdict.of_output('Remark: {none}\n%s\n' % verdict.line()) == verdict
    assert NodeVerdict.of_output('{"other": 1}\n') is None
    command = command_for_node('5.4', 'my_unit5/exercise5_4.py', verdict='/tmp/v.png')
    assert os.path.exists(command[1]) and command[2:] == ['--json', '--verdict=/tmp/v.png', '5.4',
                                                         'my_unit5/exercise5_4.py']
