import io

import pytest
from aruco_course.course import Course
from aruco_course.exercises import CHECKS
from aruco_course.learner import package as learner
from aruco_course.terminal import Screen


@pytest.fixture
def course(tmp_path):
    """A learner's course that has just been started, in the folder my_unit5."""
    return Course(learner.start(str(tmp_path / 'my_unit5'), CHECKS).package, CHECKS)


@pytest.fixture
def solve(course):
    """A function that writes our solution of an exercise into the learner's file, some text replaced."""
    def write(number, old='', new=''):
        check = course.exercise(number)
        text = learner.solution(check)
        assert old in text
        with open(course.package.source(check), 'w') as file:
            file.write(text.replace(old, new))
        return check
    return write


class Terminal(io.StringIO):
    """What is written to a terminal."""

    encoding = 'utf-8'

    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    """A function that makes a Screen of some width, and what is written to it."""
    def make(columns=80, plain=False, encoding='utf-8'):
        monkeypatch.setenv('COLUMNS', str(columns))
        monkeypatch.setenv('TERM', 'xterm')
        monkeypatch.delenv('NO_COLOR', raising=False)
        stream = Terminal()
        stream.encoding = encoding
        return Screen(stream, plain), stream
    return make
