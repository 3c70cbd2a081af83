"""The learner's package with ROS: catkin builds it, and its launch files start what their arguments say."""
import os
import shutil
import subprocess

import pytest
from aruco_course.exercises import CHECKS
from aruco_course.learner import package as learner
from roslaunch.config import load_config_default

NODES = [check for check in CHECKS if learner.has_node(check)]


@pytest.fixture
def package_path(tmp_path, monkeypatch):
    """The folder of a learner's package that ROS finds."""
    package = learner.start(str(tmp_path / 'src' / 'my_unit5'), CHECKS).package
    monkeypatch.setenv('ROS_PACKAGE_PATH', '%s:%s' % (package.folder, os.environ.get('ROS_PACKAGE_PATH', '')))
    return package.folder


def loaded(folder, check, arguments):
    return load_config_default([(os.path.join(folder, 'launch', check.name + '.launch'), arguments)], None)


@pytest.mark.parametrize('check', NODES, ids=lambda check: check.number)
@pytest.mark.parametrize('arguments, more', [
    ([], []),
    (['sim:=true'], ['/wall_camera']),
    (['bag:=/some/drive.bag'], ['/bag_player']),
    (['source:=0'], ['/video_camera']),
    (['ours:=true'], ['/%s']),
    (['page:=true'], ['/page', '/learn_verdict']),
    (['view:=true'], ['/view_my_%s']),
    (['sim:=true', 'page:=true', 'ours:=true'], ['/wall_camera', '/page', '/learn_verdict', '/%s'])])
def test_a_launch_file_starts_what_is_asked_for(package_path, check, arguments, more):
    config = loaded(package_path, check, arguments)
    wanted = ['/my_' + check.name, *[name.replace('%s', check.name) for name in more]]
    assert sorted(node.namespace + node.name for node in config.nodes) == sorted(wanted)


def test_another_camera_reaches_all_nodes(package_path):
    check = NODES[-1]
    config = loaded(package_path, check, ['camera:=/usb/image', 'sim:=true', 'page:=true', 'ours:=true'])
    for node in config.nodes:
        if node.name != 'learn_verdict':
            assert '/usb/image' in [to for _, to in node.remap_args], node.name


def test_catkin_builds_and_installs_it(package_path, tmp_path):
    if not shutil.which('cmake'):
        pytest.skip('cmake is not installed')
    build, prefix = str(tmp_path / 'build'), tmp_path / 'install'
    for command in (['cmake', '-S', package_path, '-B', build, '-DCMAKE_INSTALL_PREFIX=%s' % prefix,
                     '-DCATKIN_DEVEL_PREFIX=%s/devel' % build],
                    ['cmake', '--build', build, '--target', 'install']):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, done.stdout
    for check in CHECKS:
        assert os.access(str(prefix / 'lib' / 'my_unit5' / (check.name + '.py')), os.X_OK)
    assert (prefix / 'share' / 'my_unit5' / 'images' / 'earth.jpg').exists()


def test_catkin_lint_is_clean(package_path):
    if not shutil.which('catkin_lint'):
        pytest.skip('catkin_lint is not installed')
    done = subprocess.run(['catkin_lint', '--strict', '-W2', package_path], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
