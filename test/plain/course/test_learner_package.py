"""The learner's package: started once, buildable, with skeletons that run, and never overwritten."""
import ast
import os
import stat
from pathlib import Path

import pytest
from aruco_ar import InputError
from aruco_course.exercises import CHECKS
from aruco_course.learner import package as learner


@pytest.fixture
def started(tmp_path):
    return learner.start(str(tmp_path / 'my_unit5'), CHECKS)


def content(folder):
    found = {}
    for path in sorted(folder.rglob('*')):
        if path.is_file():
            found[str(path.relative_to(folder))] = path.read_bytes()
    return found


def test_it_has_what_the_course_asks_for(started, tmp_path):
    folder = tmp_path / 'my_unit5'
    for check in CHECKS:
        path = folder / 'src' / (check.name + '.py')
        assert path.stat().st_mode & stat.S_IXUSR
        assert (folder / 'launch' / (check.name + '.launch')).exists() == (check.number != '5.1')
    for name in 'package.xml', 'CMakeLists.txt', 'README.md', 'images/earth.jpg', 'Tags':
        assert (folder / name).exists()
    assert not [name for name, data in content(folder).items() if name.count('.jpg') == 0 and b'@' in
                data.replace(b'me@example.com', b'')]


@pytest.mark.parametrize('check', CHECKS, ids=lambda check: check.number)
def test_a_skeleton_has_the_tasks_but_not_the_solution(check):
    text = learner.skeleton(check)
    functions = {node.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)}
    assert {check.function, 'main'} <= {'', *functions}
    assert '# Task 1:' in text and learner.TO_DO in text and 'SOLUTION' not in text
    ours = learner.solution(check)
    assert 'SOLUTION' not in ours and len(ours) > len(text)
    ast.parse(ours)


def test_starting_again_changes_nothing_but_brings_back_what_is_gone(started, tmp_path):
    folder = tmp_path / 'my_unit5'
    mine = folder / 'src' / 'exercise5_4.py'
    mine.write_text('print("mine")\n')
    (folder / 'README.md').unlink()
    before = content(folder)
    again = learner.start(str(folder), CHECKS)
    assert again.made == ['README.md'] and 'src/exercise5_4.py' in again.kept
    after = content(folder)
    assert after.pop('README.md') and after == before


def test_a_reset_brings_the_skeleton_back_and_keeps_the_old_file(started, tmp_path):
    check, package = CHECKS[-1], started.package
    path = package.source(check)
    olds = []
    for number in range(3):  # within one second
        with open(path, 'w') as file:
            file.write('mine = %d\n' % number)
        assert not learner.is_untouched(package, check)
        olds.append(learner.reset(package, check))
        assert learner.is_untouched(package, check) and os.access(path, os.X_OK)
    assert [Path(old).read_text() for old in olds] == ['mine = 0\n', 'mine = 1\n', 'mine = 2\n']
    os.unlink(path)
    assert learner.reset(package, check) is None and learner.is_untouched(package, check)


@pytest.mark.parametrize('folder, words', [
    ('unit5', 'the package with the answers'),
    ('taken', 'already a package'),
    ('taken/src/my_unit5', 'inside the package'),
    ('file', 'is a file'),
    ('file/my_unit5', 'Cannot make the folder')])
def test_a_folder_that_is_no_place_for_it_is_refused(tmp_path, folder, words):
    (tmp_path / 'file').write_text('')
    (tmp_path / 'taken' / 'src').mkdir(parents=True)
    (tmp_path / 'taken' / 'package.xml').write_text('<package><name>taken</name></package>')
    before = content(tmp_path)
    with pytest.raises(InputError, match=words):
        learner.start(str(tmp_path / folder), CHECKS)
    assert content(tmp_path) == before


@pytest.mark.parametrize('folder, name', [('my_unit5', 'my_unit5'), ('My Course', 'my_course'),
                                          ('5-ü', 'my_unit5_5'), ('***', 'my_unit5')])
def test_the_package_has_a_name_that_ros_takes(tmp_path, folder, name):
    package = learner.start(str(tmp_path / folder), CHECKS).package
    assert package.name == name
    assert 'project(%s)' % name in (tmp_path / folder / 'CMakeLists.txt').read_text()


def test_it_is_found_from_the_folders_in_it(started, tmp_path):
    folder = tmp_path / 'my_unit5'
    for inside in folder, folder / 'src', folder / 'launch' / 'deeper':
        assert learner.find(str(inside)).folder == str(folder)
    assert learner.find(str(tmp_path)) is None


@pytest.mark.parametrize('source', ['### BEGIN SOLUTION\n', '### END SOLUTION\n',
                                    '### BEGIN SOLUTION\n### BEGIN SOLUTION\n### END SOLUTION\n'])
def test_a_solution_with_wrong_marks_makes_no_skeleton(source):
    with pytest.raises(ValueError):
        learner.without_solution(source)
