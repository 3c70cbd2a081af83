"""The check of a node as its users start it: check.test, and check_node.py, which needs no roscore."""
import json
import os
import subprocess
from xml.etree import ElementTree

import pytest
from aruco_course.black_box.verdict import NodeVerdict, command_for_node
from aruco_course.exercises import CHECKS
from aruco_course.learner.package import start
from course.corpus import FOLDER
from rig.nodes.learners import learners_node
from rig.processes.started import WAIT_S

NOBODY = dict(os.environ, ROS_MASTER_URI='http://localhost:1')


def run(*command):
    return subprocess.run(command, env=NOBODY, capture_output=True, text=True, timeout=WAIT_S)


@pytest.mark.parametrize('changes, words', [
    ([], None),
    ([('[ordered.astype', '[centers.astype')], 'crosses itself')], ids=['right', 'wrong'])
def test_check_test_passes_only_what_is_right(tmp_path, changes, words):
    node, picture = learners_node(str(tmp_path), 'mine', *changes), tmp_path / 'verdict.png'
    done = run('rostest', '--results-base-dir', str(tmp_path), 'unit5', 'check.test', 'exercise:=5.4',
               'node:=' + node, 'image:=/my_exercise5_4/image', 'verdict:=%s' % picture)
    assert (done.returncode == 0) == (words is None), done.stdout
    case, = ElementTree.parse(str(tmp_path / 'unit5' / 'rosunit-check.xml')).iter('testcase')
    failure = case.find('failure')
    assert failure is None if words is None else words in failure.text
    assert picture.exists()


def test_a_verdict_needs_no_roscore(tmp_path):
    node = learners_node(str(tmp_path), 'mine', ("'~image'", "'/polygon'"))
    done = run(*command_for_node('5.4', node))
    verdict = NodeVerdict.of_output(done.stdout)
    assert done.returncode == 1 and 'give image:=/polygon' in verdict.fault, done
    right = run(*command_for_node('5.4', node, image='/polygon'))
    assert right.returncode == 0 and NodeVerdict.of_output(right.stdout).passed, right


def test_a_node_without_the_function_is_judged_alone(tmp_path):
    package = start(str(tmp_path / 'my_unit5'), CHECKS).package
    with open(os.path.join(FOLDER, 'right', 'course5_4.py')) as file:
        code = file.read().replace('order_centers', 'my_own_way')
    with open(package.path('src', 'exercise5_4.py'), 'w') as file:
        file.write(code)
    learn = 'rosrun', 'unit5', 'learn.py', '--package', package.folder, 'check', '5.4'
    alone = run(*learn)
    assert alone.returncode == 1 and 'no function order_centers' in alone.stdout, alone
    done = run(*learn, '--node')
    assert done.returncode == 0 and 'The node is right.' in done.stdout, done
    assert json.loads(run(*learn[:-2], 'report').stdout)['done'] == 1


@pytest.mark.parametrize('arguments, words', [
    (['5.9', 'unit5/page.py'], 'There is no exercise 5.9'),
    (['5.1', 'unit5/artag_generator.py'], 'The program of exercise 5.1 is no node'),
    (['5.4', 'unit5/page.py', '--bag=/no/such.bag'], '/no/such.bag')])
def test_what_cannot_be_judged_is_said(arguments, words):
    done = run('rosrun', 'unit5', 'check_node.py', *arguments)
    assert done.returncode == 2 and words in done.stderr, done
