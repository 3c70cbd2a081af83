"""The watch: a verdict each time a file is saved, whatever the learner's editor and code do."""
import os
import pty
import re
import select
import signal
import subprocess
import sys

import pytest
from aruco_course.watch import Event, Files, Watch, events

ENOUGH_S = 120  # nothing here takes as long


@pytest.fixture
def watch(course, terminal):
    """A function that shows what the watch says to each step of a learner, given as a generator of events."""
    def run(steps, can_type=True, plain=True):
        screen, stream = terminal(plain=plain)
        said = []

        def happened():
            for event in steps:
                said.append(stream.getvalue())
                stream.seek(0)
                stream.truncate()
                yield event
        assert Watch(course, screen, can_type).run(happened()) == 0
        return [' '.join(text.split()) for text in [*said, stream.getvalue()]]
    return run


def test_it_shows_the_task_and_the_verdict_on_each_save(watch, solve):
    def steps():
        solve('5.4', 'image, [ordered', 'image, [centers')
        yield Event('saved', '5.4')
        solve('5.4')
        yield Event('saved', '5.4')
    first, wrong, right = watch(steps())
    assert '0 of 6 done' in first and '5.1 at hand' in first and 'Nothing is written yet' in first
    assert '5.4 is not right yet' in wrong and 'Frame' in wrong and '5_4.png' in wrong
    assert '5.4 is right' in right and '1 of 6 done' in right and 'Next: 5.5' in right
    assert 'no tag' in right.lower() and 'roslaunch my_unit5 exercise5_4.launch' in right


def test_words_can_be_typed(watch, course, solve):
    solve('5.1')
    typed = ['h', 'hint 5.4', 's', 's', 'r', 'n', 'what', '9.9', 'h 9.9', '', 'q', 'h']
    said = watch(Event('typed', line) for line in typed)
    assert 'Hint 1 of 3: ' + course.exercise('5.1').hints[0].split()[0] in said[1]
    assert course.exercise('5.4').hints[0].split()[0] in said[2]
    assert 'same as ours' in said[3] and 'is kept' in said[5] and '5.2' in said[6]
    assert 'none of them' in said[7] and 'none of them' in said[8] and 'no exercise' in said[9]
    assert '5.2' in said[10] and len(said) == len(typed)  # it has quit before the last one
    assert course.progress.of('5.1').hints == 1


def test_a_terminal_is_cleared_and_plain_text_is_not(watch):
    assert '\x1b[2J' in watch(iter([Event('resized')]), plain=False)[1]
    assert '\x1b' not in ''.join(watch(iter([Event('resized'), Event('typed', '')]), plain=True))


def test_a_file_that_is_replaced_touched_or_gone_has_changed(course):
    files, (first, second) = Files(course), [course.package.source(check) for check in course.checks[:2]]
    assert files.changed() == []
    os.utime(first)
    assert files.changed() == ['5.1'] and files.changed() == []
    os.replace(second, first)
    assert files.changed() == ['5.1', '5.2'] and files.changed() == []


def test_it_waits_until_an_editor_has_written_all(course):
    files, path = Files(course), course.package.source(course.checks[0])
    pieces = ['a = 1\n', 'b = 2\n', 'c = 3\n']

    def pause(_):
        if pieces:
            with open(path, 'a') as file:
                file.write(pieces.pop(0))
    with open(path, 'w'):
        pass
    assert files.changed(pause) == ['5.1'] and not pieces and files.changed() == []


def test_a_new_width_is_an_event(course, terminal, monkeypatch):
    screen, _ = terminal(80)
    happened = events(Files(course), screen, None)
    monkeypatch.setattr('aruco_course.watch.time.sleep', lambda _: monkeypatch.setenv('COLUMNS', '60'))
    assert next(happened) == Event('resized')


class Session:
    """learn.py on a terminal of its own."""

    def __init__(self, package, folder, *arguments):
        self.handle, child = pty.openpty()
        environment = {**os.environ, 'TERM': 'xterm', 'COLUMNS': '80', 'PYTHONIOENCODING': 'utf-8'}
        self.process = subprocess.Popen([sys.executable, package + '/nodes/learn.py', *arguments], cwd=folder,
                                        env=environment, stdin=child, stdout=child, stderr=child,
                                        start_new_session=True)
        os.close(child)
        self.said = b''

    def until(self, words):
        """What is said until these words come, and after them the line with the keys."""
        wanted = re.compile(words.encode() + b'.*then Enter', re.DOTALL)
        while not wanted.search(self.said):
            assert select.select([self.handle], [], [], ENOUGH_S)[0], self.said.decode()
            self.said += os.read(self.handle, 65536)
        said, self.said = self.said, b''
        return said.decode()

    def type(self, text):
        os.write(self.handle, text.encode())


@pytest.fixture
def session(course, package):
    started = Session(package, course.package.folder)
    yield started
    if started.process.poll() is None:
        started.process.kill()
    started.process.wait()
    os.close(started.handle)


def test_the_program_sees_a_save_and_ends_with_control_c(session, course, solve):
    session.until('Nothing is written yet')
    with open(course.package.source(course.exercise('5.2')), 'w') as file:
        file.write('def detect_tags(image)\n    return image\n')
    assert 'Line 1' in session.until('5.2 is not right yet')
    solve('5.2')
    session.until('5.2 is right')
    session.process.send_signal(signal.SIGINT)
    assert session.process.wait(ENOUGH_S) == 0


def test_the_program_does_what_is_typed(session):
    session.until('Nothing is written yet')
    session.type('n\n')
    session.until('5.2')
    session.type('q\n')
    assert session.process.wait(ENOUGH_S) == 0
