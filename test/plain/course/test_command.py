"""The commands: what they say, and what they return."""
import json
import os
import subprocess
import sys

import cv2
import pytest
from aruco_course.command import main
from aruco_course.judge.views import area_views
from aruco_course.learner import package as learner
from aruco_course.learner import progress

RIGHT, WRONG, USAGE = 0, 1, 2
# What a learner may write for exercise 5.4.
CROSSED = 'ordered = centers[[0, 2, 1, 3]]'


@pytest.fixture
def learn(course, monkeypatch, capsys):
    """A function that runs a command in the learner's package: its exit code and what it says."""
    monkeypatch.chdir(course.package.folder)

    def run(*arguments):
        code = main(arguments)
        said = capsys.readouterr()
        return code, ' '.join((said.out + said.err).split())
    return run


@pytest.mark.parametrize('arguments', [['check'], ['watch'], [], ['hint'], ['report'], ['page'],
                                       ['reset', '5.4']])
def test_without_a_package_it_says_how_to_make_one(tmp_path, monkeypatch, capsys, arguments):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', str(tmp_path))
    assert main(arguments, called='aruco-learn') == USAGE
    assert 'aruco-learn start' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_start_uses_the_workspace_if_there_is_one(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', str(tmp_path))
    workspace = tmp_path / 'catkin_ws' / 'src'
    workspace.mkdir(parents=True)
    assert main(['start']) == RIGHT
    assert (workspace / 'my_unit5' / 'src' / 'exercise5_6.py').exists()
    assert 'rosrun unit5 learn.py' in capsys.readouterr().out
    assert main(['report']) == RIGHT  # from anywhere
    assert main(['start', str(tmp_path / 'unit5')]) == USAGE


def test_start_within_unit5_makes_a_package_beside_it(tmp_path, monkeypatch, capsys):
    clone = tmp_path / 'unit5' / 'docs'
    clone.mkdir(parents=True)
    (tmp_path / 'unit5' / 'package.xml').touch()
    monkeypatch.setenv('HOME', str(tmp_path))
    for folder in clone.parent, clone:
        monkeypatch.chdir(folder)
        assert main(['start']) == RIGHT
        assert main(['report']) == RIGHT
    assert (tmp_path / 'my_unit5' / 'src' / 'exercise5_6.py').exists()
    assert main(['start', 'my_unit5']) == USAGE
    assert 'is inside the package' in capsys.readouterr().err


def test_a_recording_is_judged_as_well(learn, solve, tmp_path):
    frames = tmp_path / 'frames'
    frames.mkdir()
    for number, view in enumerate(area_views()[:3]):
        cv2.imwrite(str(frames / ('%d.png' % number)), view.frame)
    for number in '5.4', '5.6':
        solve(number)
        code, said = learn('check', number, '--on', str(frames))
        assert code == RIGHT and 'On your recording it is right' in said
    # This is right on all of our own frames, but not on this one, which is smaller.
    small = str(frames / 'small.png')
    cv2.imwrite(small, cv2.resize(area_views()[0].frame, None, fx=0.8, fy=0.8))
    solve('5.4', 'return image\n\n\ndef main', 'return image if len(image) == 480 else image * 0\n\n\ndef main')
    code, said = learn('check', '5.4', '--on', small)
    assert code == WRONG and 'On your recording it is not right yet' in said and 'black all over' in said
    solve('5.4')
    cv2.imwrite(str(frames / 'gray.png'), area_views()[0].frame[:40])
    code, said = learn('check', '5.4', '--on', str(frames / 'gray.png'))
    assert code == USAGE and 'In no frame of' in said
    code, said = learn('check', '5.4', '--on', str(frames / 'none.mp4'))
    assert code == USAGE and 'There is no file' in said
    code, said = learn('check', '5.4', '--on', 'wall.bag')
    assert code == USAGE and '--node' in said


def test_a_right_solution_passes_and_a_wrong_one_is_told_why(learn, solve, course):
    code, said = learn('check', '5.4')
    assert code == WRONG and 'Nothing is written yet' in said
    solve('5.4', 'ordered = centers[[np.argmin(total), np.argmin(difference), np.argmax(total), '
                 'np.argmax(difference)]]', CROSSED)
    code, said = learn('check', '5.4')
    assert code == WRONG and '5.4 is not right yet' in said and 'crosses itself' in said
    assert os.path.getsize(course.package.picture(course.exercise('5.4'))) > 1000
    solve('5.4')
    code, said = learn('check', '5.4')
    assert code == RIGHT and '5.4 is right' in said and 'Challenges' in said
    done = course.progress.of('5.4')
    assert done.passed and done.attempts == 2 and any('crosses itself' in fault for fault in done.faults)
    assert done.challenges and not all(done.challenges.values())


def test_what_is_no_exercise_is_refused(learn):
    code, said = learn('check', '7.1')
    assert code == USAGE and 'there are 5.1, 5.2, 5.3, 5.4, 5.5, 5.6' in said


@pytest.mark.parametrize('text', ['5.4', '4', 'exercise5_4', 'src/exercise5_4.py', '5_4'])
def test_an_exercise_may_be_named_in_several_ways(course, text):
    assert course.exercise(text).number == '5.4'


def test_each_hint_tells_more(learn, course):
    hints = course.exercise('5.4').hints
    for count in 1, 2, 3, 3:
        code, said = learn('hint', '5.4')
        assert code == RIGHT
        assert [' '.join(hint.split()) in said for hint in hints] == [True] * count + [False] * (3 - count)
    assert course.progress.of('5.4').hints == 3


def test_the_solution_is_shown_when_asked_for_twice(learn, course):
    code, said = learn('solution', '5.4')
    assert code == WRONG and 'ask again' in said and 'argmin' not in said
    code, said = learn('solution', '5.4')
    assert code == RIGHT and '+ total = centers' in said and 'src/exercise5_4.py of unit5' in said
    assert course.progress.of('5.4').solution_seen


def test_the_solution_is_shown_at_once_after_a_pass(learn, course, solve):
    solve('5.3')
    assert learn('check', '5.3')[0] == RIGHT
    code, said = learn('solution', '5.3')
    assert code == RIGHT and 'the same as ours' in said


def test_a_reset_says_where_the_old_file_is(learn, course, solve):
    check = solve('5.4')
    code, said = learn('reset', '5.4')
    assert code == RIGHT and learner.is_untouched(course.package, check)
    with open(said.rpartition('kept: ')[2]) as file:
        assert file.read() == learner.solution(check)


def test_the_exercise_at_hand_is_the_first_that_is_not_done(learn, course, solve):
    for number in '5.1', '5.2':
        solve(number)
        assert learn('check')[0] == RIGHT
    assert course.at_hand().number == '5.3'
    assert len(os.listdir(course.package.path('Tags'))) == 4


def test_a_report_tells_what_was_done(learn, course, solve):
    solve('5.1')
    learn('check', '5.1')
    learn('hint', '5.2')
    with open(course.package.source(course.exercise('5.1')), 'w') as file:
        file.write('def draw_tag(:\n')
    data = json.loads(learn('report', '--judge')[1])
    assert data['package'] == 'my_unit5' and data['done'] == 1
    first, second = data['exercises'][:2]
    assert first['passed'] and first['attempts'] == 1 and first['minutes'] >= 0
    assert not first['now']['passed'] and 'Line 1' in first['now']['fault']
    assert second['hints'] == 1 and second['passed'] is None and not second['now']['passed']


def test_a_progress_that_cannot_be_written_is_a_sentence(learn, course):
    os.rmdir(course.package.path('.learn'))
    with open(course.package.path('.learn'), 'w'):
        pass
    code, said = learn('--package', course.package.folder, 'hint')
    assert code == USAGE and 'Traceback' not in said


def test_options_may_come_before_or_after_the_command(learn, course, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    options = ['--package', course.package.folder]
    for arguments in [*options, 'report'], ['report', *options]:
        assert json.loads(learn(*arguments)[1])['package'] == 'my_unit5'


def test_reading_only_the_beginning_of_the_output_is_no_error(course, package):
    with progress.changed(course.package) as changing:
        changing.of('5.4').passed = progress.now()
    done = subprocess.run('%s %s/nodes/learn.py solution 5.4 | head -n 1' % (sys.executable, package),
                          shell=True, cwd=course.package.folder, capture_output=True, text=True)
    assert done.stderr == '' and done.stdout.count('\n') == 1
