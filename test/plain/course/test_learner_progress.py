"""Progress: what was done and when survives two programs at once, and a broken file."""
import json
import os
from concurrent.futures import ThreadPoolExecutor

import pytest
from aruco_course.learner import progress
from aruco_course.learner.package import Package


@pytest.fixture
def package(tmp_path):
    return Package(str(tmp_path))


def test_it_notes_attempts_until_the_pass(package):
    assert progress.read(package) == progress.Progress()
    for digest, fault in [('a', 'Frame 1: wrong.'), ('a', 'Frame 1: wrong.'), ('b', 'Frame 1: wrong.'),
                          ('c', None), ('d', 'Line 2: broken.')]:
        with progress.changed(package) as changing:
            changing.of('5.4').attempt(digest, fault)
    done = progress.read(package).of('5.4')
    assert done.attempts == 3  # a file that is saved again as it was is no other attempt
    assert done.faults == {'Frame 1: wrong.': 2}  # what is tried after the pass does not count
    assert done.passed and done.last == 'Line 2: broken.' and done.minutes >= 0


def test_two_programs_lose_nothing_of_each_other(package):
    def ask(_):
        with progress.changed(package) as changing:
            changing.of('5.2').hints += 1
    with ThreadPoolExecutor(8) as threads:
        list(threads.map(ask, range(40)))
    assert progress.read(package).of('5.2').hints == 40


@pytest.mark.parametrize('text', ['', '{', '[]', 'null', '{"started": 5, "exercises": {}}', '[' * 100000,
                                  '{"started": "", "exercises": []}', '\x00\xff', '{"started": "yesterday"}'])
def test_a_broken_file_is_kept_and_another_begun(package, tmp_path, text):
    path = tmp_path / '.learn' / 'progress.json'
    path.parent.mkdir()
    path.write_bytes(text.encode('latin-1'))
    assert progress.read(package) == progress.Progress()
    with progress.changed(package) as changing:
        changing.of('5.3').attempt('a', None)
    assert progress.read(package).of('5.3').passed
    kept, = (tmp_path / '.learn' / 'old').iterdir()
    assert kept.read_bytes() == text.encode('latin-1')


def test_an_entry_of_the_wrong_form_does_not_spoil_the_others(package, tmp_path):
    with progress.changed(package) as changing:
        changing.of('5.2').attempt('a', None)
        changing.of('5.3').attempt('a', 'wrong')
    path = tmp_path / '.learn' / 'progress.json'
    data = json.loads(path.read_text())
    data['exercises']['5.3'].update(attempts='many', passed='soon', hints=-1, faults={'a': 'b'})
    path.write_text(json.dumps(data))
    found = progress.read(package)
    assert found.of('5.2').passed and found.of('5.3').last == 'wrong' and found.of('5.3').attempts == 0
    with progress.changed(package):
        pass
    assert len(os.listdir(str(tmp_path / '.learn' / 'old'))) == 1


def test_a_change_that_fails_is_not_written(package):
    with pytest.raises(RuntimeError), progress.changed(package) as changing:
        changing.of('5.2').hints = 3
        raise RuntimeError
    assert progress.read(package).of('5.2').hints == 0
