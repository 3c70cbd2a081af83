"""The verdict: our own solutions pass, skeletons do not, and hostile code is a sentence."""
import os

import pytest
from aruco_course.exercises import CHECKS
from aruco_course.learner import package as learner
from aruco_course.verdict import judge_exercise, try_challenges

NUMBERS = [check.number for check in CHECKS]


def write(course, number, text):
    check = course.exercise(number)
    with open(course.package.source(check), 'w') as file:
        file.write(text)
    return judge_exercise(check, course.package.folder)


@pytest.mark.parametrize('number', NUMBERS)
def test_our_solution_passes_and_the_skeleton_does_not(course, solve, number):
    check = course.exercise(number)
    verdict = judge_exercise(check, course.package.folder)
    assert not verdict.passed and not verdict.challenges and len(str(verdict.fault)) > 20
    solve(number)
    verdict = judge_exercise(check, course.package.folder)
    assert verdict.passed, verdict.fault
    assert verdict.picture.ndim == 3 and verdict.picture.dtype == 'uint8'
    assert [challenge.name for challenge, _ in verdict.challenges] == [
        challenge.name for challenge in getattr(check, 'challenges', ())]


def test_what_is_expected_is_beside_what_the_code_shows(course):
    check = course.exercise('5.4')
    height, width = check.views()[0].frame.shape[:2]
    picture = judge_exercise(check, course.package.folder).picture
    assert picture.shape[0] > height and picture.shape[1] > 2 * width


def test_a_challenge_that_ends_the_run_does_not_hide_the_others(course):
    check = course.exercise('5.4')
    text = learner.solution(check)
    text = text.replace('if ids is None or len(ids) != 4:\n        return image',
                        'if len(ids) < 4:\n        raise ValueError("too few")')
    verdict = write(course, '5.4', text)
    assert verdict.passed
    outcomes = {challenge.name: fault for challenge, fault in verdict.challenges}
    assert list(outcomes) == [challenge.name for challenge in check.challenges]
    assert 'TypeError' in str(outcomes['no tag in sight']) or 'None' in str(outcomes['no tag in sight'])
    assert 'too few' in str(outcomes['three tags'])
    assert None in outcomes.values()


@pytest.mark.parametrize('line, words', [
    ('while True: pass', 'Line'), ('print("x" * 1000000000)', ''), ('import sys; sys.exit(3)', 'Line'),
    ('import os; os.abort()', ''), ('held = bytearray(1 << 36)', 'memory')])
def test_hostile_code_is_a_sentence(course, line, words):
    check = course.exercise('5.2')
    text = learner.skeleton(check).replace('    ' + learner.TO_DO, '    ' + line, 1)
    verdict = write(course, '5.2', text)
    assert not verdict.passed and words.lower() in str(verdict.fault).lower()
    assert len(verdict.printed) < 10000


@pytest.mark.parametrize('text', ['', '\x00', 'def detect_tags(:', 'detect_tags = 5\n', 'import nothing_like\n'])
def test_any_file_gets_a_sentence(course, text):
    verdict = write(course, '5.2', text)
    assert not verdict.passed and len(str(verdict.fault)) > 10


def test_a_file_that_is_gone_or_a_folder_gets_a_sentence(course):
    check = course.exercise('5.3')
    path = course.package.source(check)
    os.unlink(path)
    assert not judge_exercise(check, course.package.folder).passed
    os.mkdir(path)
    assert not judge_exercise(check, course.package.folder).passed


def test_files_that_an_older_version_wrote_are_not_taken_for_new(course, solve):
    check = solve('5.1')
    assert judge_exercise(check, course.package.folder).passed
    verdict = write(course, '5.1', learner.skeleton(check))
    assert not verdict.passed
    assert list(try_challenges(check, course.package.folder)) == []


def test_a_program_that_depends_on_where_it_is_started_is_told_so(course, solve, monkeypatch):
    monkeypatch.chdir(course.package.folder)
    check = solve('5.1', "os.path.join(TAGS, 'image_%d.jpg' % tag_id)", "'Tags/image_%d.jpg' % tag_id")
    verdict = judge_exercise(check, course.package.folder)
    assert not verdict.passed and 'started' in str(verdict.fault)
