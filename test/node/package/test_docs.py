"""The documentation: Sphinx builds it without warnings, and the files exist to which README and docs/ link."""
import glob
import importlib.util
import os
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest
from aruco_ar.runner import Runner
from aruco_ar.settings.settings import AreaSettings
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera
from aruco_course.check import Shown
from aruco_course.exercises import CHECKS
from aruco_course.learner.package import without_solution

LINK = re.compile(r'\]\(([^)#\s]*)(?:#[^)\s]*)?\)')


def test_sphinx_builds_the_docs_without_warnings(package, tmp_path):
    if importlib.util.find_spec('myst_parser') is None:
        pytest.skip('myst_parser is not installed')
    clean = {key: value for key, value in os.environ.items() if key not in ('PYTHONDEVMODE', 'PYTHONWARNINGS')}
    done = subprocess.run([sys.executable, '-W', 'ignore', '-m', 'sphinx', '-q', '-W', '--keep-going', '-d',
                           str(tmp_path / 'doctrees'), 'docs', str(tmp_path / 'html')], cwd=package, env=clean,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    assert (tmp_path / 'html' / 'index.html').is_file()


def test_every_linked_file_exists(package):
    for page in glob.glob(package + '/*.md') + glob.glob(package + '/docs/**/*.md', recursive=True):
        with open(page, encoding='utf-8') as file:
            targets = {target for target in LINK.findall(file.read()) if target and '://' not in target}
        for target in targets:
            assert os.path.isfile(os.path.join(os.path.dirname(page), target)), '%s: %s' % (page, target)


def test_the_quality_declaration_names_commands_that_exist(package):
    with open(package + '/QUALITY_DECLARATION.md', encoding='utf-8') as page:
        commands = re.findall(r'`((?:script|\.ci)/[^`]+)`', page.read())
    assert len(commands) > 20
    known = {re.sub('^test_|_test$', '', name[:-len('.py')]) for _, _, names in os.walk(package + '/test')
             for name in names if name.endswith('.py')}
    for program, *names in map(str.split, commands):
        assert os.access(os.path.join(package, program), os.X_OK), program
        if program == 'script/test':
            assert set(names) <= known, names


def test_the_example_of_a_new_exercise_blurs_only_the_area(package, frame, wall, view):
    with open(package + '/docs/howto/new-exercise.md', encoding='utf-8') as page:
        source = re.search(r'```python\n(.*?)```', page.read(), re.DOTALL)[1]
    made = {'__name__': 'exercise'}
    exec(source, made)
    exercise = made['EXERCISE']
    sight, (image,) = Runner(exercise, [AreaSettings()], None).run(frame, 1.0, keeps_frame=True)
    assert sorted(tag.id for tag in sight.tags) == [1, 2, 3, 4]
    inside = np.zeros(frame.shape[:2], np.uint8)
    corners, _ = project(wall.area_corners, *view, Camera())
    cv2.fillPoly(inside, [np.int32(np.round(corners))], 255)
    rim = cv2.dilate(inside, np.ones((5, 5))) != cv2.erode(inside, np.ones((5, 5)))
    np.testing.assert_array_equal(image[(inside == 0) & ~rim], frame[(inside == 0) & ~rim])
    sharp, blurred = [cv2.Laplacian(each, cv2.CV_64F)[(inside > 0) & ~rim].std() for each in (frame, image)]
    assert blurred < sharp / 10


def test_the_example_of_a_new_check_knows_right_from_wrong(package):
    with open(package + '/docs/howto/teach.md', encoding='utf-8') as page:
        solution, check = re.findall(r'```python\n(.*?)```', page.read(), re.DOTALL)
    made = {'cv2': cv2, 'np': np, 'DICTIONARY': cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)}
    exec(solution, made)
    example = {'__name__': 'check'}
    exec(check, example)

    def sentence_for(function):
        shown = [Shown(number, view, (function(view.frame.copy()),))
                 for number, view in enumerate(example['CHECK'].views(), start=1)]
        fault = example['CHECK'].judge(shown)
        return None if fault is None else str(fault)

    assert sentence_for(made['blur_area']) is None
    exec(without_solution(solution), made)
    assert 'still as sharp' in sentence_for(made['blur_area'])  # the skeleton shows the frame
    assert 'outside of the area' in sentence_for(lambda image: cv2.GaussianBlur(image, (0, 0), 8))


def test_lessons_say_how_long_their_exercises_take(package):
    with open(package + '/docs/learn/start.md', encoding='utf-8') as page:
        overview = page.read()
    for check in CHECKS:
        path, = glob.glob('%s/docs/learn/%s_*.md' % (package, check.number.replace('.', '_')))
        with open(path, encoding='utf-8') as page:
            minutes = re.search(r'\*\*Time:\*\* (\d+) minutes', page.read())[1]
        row = re.search(r'\| \[%s\]\(.*\| (\d+) \|' % re.escape(check.number), overview)
        assert int(minutes) == int(row[1]) == check.minutes, check.number
