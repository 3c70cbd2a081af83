"""Every wrong solution is told its own mistake, and every right one passes."""
import importlib
import os
import re

import pytest
from aruco_course.verdict import judge_exercise
from course import corpus

pytestmark = pytest.mark.long

WRONG = [(number, wrong) for number in corpus.NUMBERS for wrong in corpus.wrong_solutions(number)]
RIGHT = [(number, path) for number in corpus.NUMBERS for path in corpus.right_solutions(number)]


def judged(folder, number, *code):
    check = importlib.import_module('aruco_course.exercises.%s.check' % corpus.name_of(number)).CHECK
    return judge_exercise(check, corpus.write_package(folder, number, *code))


@pytest.mark.parametrize('number, wrong', WRONG, ids=['%s: %s' % (each[0], each[1].what) for each in WRONG])
def test_wrong_solution_is_told_its_mistake(tmp_path, number, wrong):
    verdict = judged(tmp_path / 'my_unit5', number, corpus.code_of(number, wrong), wrong.executable)
    assert not verdict.passed
    assert re.fullmatch(wrong.pattern(), verdict.fault.what)
    assert verdict.fault.place.startswith(wrong.place)
    assert bool(verdict.fault.place) == bool(wrong.place)


@pytest.mark.parametrize('number, path', RIGHT, ids=[os.path.basename(path) for _, path in RIGHT])
def test_right_solution_passes(tmp_path, number, path):
    with open(path, encoding='utf-8') as file:
        verdict = judged(tmp_path / 'my_unit5', number, file.read())
    assert verdict.passed, verdict.fault
