"""The package for ROS: catkin_lint, launch arguments, the benchmark, what nodes load, an install space."""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from aruco_ar import draw_tag
from aruco_ar.compiled.compiler import flags, sources
from rig.processes.started import program

EXERCISES = ['exercise5_%d.launch' % number for number in range(2, 7)]
SHARED_ARGS = {'camera', 'transport', 'folder', 'dictionary', 'ids', 'scale', 'search', 'correction',
               'confidence', 'min_side', 'border', 'respawn', 'view', 'bag', 'sim'}
LENS_ARGS = {'lens', 'camera_info', 'rectified'}
OWN_ARGS = {'exercise5_4.launch': LENS_ARGS,
            'exercise5_5.launch': LENS_ARGS | {'hold', 'upright', 'wall'},
            'exercise5_6.launch': LENS_ARGS | {'hold', 'upright', 'wall', 'picture', 'fit', 'opacity',
                                                 'foreground', 'light', 'grain', 'tags', 'settle', 'areas'}}


def launch_args(package, name):
    return {arg.get('name'): arg for arg in
            ElementTree.parse(os.path.join(package, 'launch', name)).getroot().findall('arg')}


def test_catkin_lint_is_clean(package, tmp_path):
    if not shutil.which('catkin_lint'):
        pytest.skip('catkin_lint is not installed')
    # catkin_lint wants the folder to have the package's name.
    shutil.copytree(package, str(tmp_path / 'unit5'),
                    ignore=shutil.ignore_patterns('.git', '.venv', 'build', '__pycache__'))
    done = subprocess.run(['catkin_lint', '--strict', '-W2', 'unit5'], cwd=str(tmp_path),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout


def test_every_launch_argument_is_documented(package):
    for name in (name for name in os.listdir(os.path.join(package, 'launch')) if name.endswith('.launch')):
        for key, arg in launch_args(package, name).items():
            assert arg.get('doc'), '%s: %s' % (name, key)


def test_the_exercises_have_the_same_arguments(package):
    for name in EXERCISES:
        assert set(launch_args(package, name)) == SHARED_ARGS | OWN_ARGS.get(name, set())


def test_the_benchmark_lists_its_options(package):
    clean = {key: value for key, value in os.environ.items() if key != 'PYTHONPATH'}
    done = subprocess.run([package + '/script/bench', '--help'], env=clean, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0 and '--video FILE' in done.stdout, done.stdout


def test_the_benchmark_compares_detectors_on_a_folder(package, tmp_path):
    """A photo of one tag, and a folder that does not exist."""
    tag = np.pad(draw_tag('DICT_4X4_50', 8, 60), 30, constant_values=255)
    cv2.imwrite(str(tmp_path / 'one.png'), tag)
    (tmp_path / 'one.txt').write_text('8\n9\n')

    def bench(folder):
        return subprocess.run(
            [sys.executable, '-m', 'benchmark', '--dictionary', 'DICT_4X4_50', '--peers', str(folder)],
            cwd=package + '/test', capture_output=True, text=True)
    done = bench(tmp_path)
    assert done.returncode == 0, done.stderr
    assert '1 photo, ids known, DICT_4X4_50' in done.stdout
    assert len(re.findall(r'^  (?:OpenCV|ours).* 1 of 2 +0 +0 ', done.stdout, re.MULTILINE)) == 7, done.stdout
    done = bench(tmp_path / 'none')
    assert done.returncode == 1
    assert re.fullmatch(r'bench: There is no folder ".*none" with photos and clips\.\n', done.stderr)


def test_the_nodes_of_a_real_robot_load_nothing_of_the_simulation(package):
    script = 'import sys, camera_relay, exercise5_6, tag_poses; ' \
             'print([name for name in sys.modules if name.startswith("aruco_ar.simulation")])'
    done = subprocess.run([sys.executable, '-c', script], cwd=package + '/nodes', capture_output=True,
                          text=True)
    assert done.stdout == '[]\n', done


def test_an_install_space_is_complete(package, tmp_path):
    prefix, build = str(tmp_path / 'install'), str(tmp_path / 'build')
    for command in (['cmake', '-S', package, '-B', build, '-DCMAKE_INSTALL_PREFIX=' + prefix,
                     '-DCATKIN_DEVEL_PREFIX=%s/devel' % build, '-DCATKIN_ENABLE_TESTING=OFF',
                     '-DPYTHON_EXECUTABLE=' + sys.executable, '-DCMAKE_EXPORT_COMPILE_COMMANDS=ON'],
                    ['cmake', '--build', build, '--target', 'install']):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, done.stdout
    with open(build + '/compile_commands.json') as file:
        commands = {each['file']: shlex.split(each['command']) for each in json.load(file)}
    for path in sources():  # see test_compiled.py, too
        assert set(flags()) < set(commands[path]), path
    script = ('source %s/setup.bash && cd %s && rosrun unit5 artag_generator.py --ids 5 --output made'
              ' && rosrun unit5 gazebo_wall.py --output wall'
              ' && roslaunch --nodes unit5 exercise5_6.launch sim:=true'
              ' && roslaunch --nodes unit5 demo.launch && roslaunch --ros-args unit5 exercise5_6.launch'
              ' && python3 -c "from aruco_desk.command import main; main([\'tags\'])"'
              ' && python3 -c "import aruco_ar, aruco_node.page.node; print(aruco_ar.__file__); '
              'print(open(\'/proc/self/maps\').read())"'
              % (prefix, tmp_path))
    clean = {key: value for key, value in os.environ.items()
             if key not in ('CMAKE_PREFIX_PATH', 'PYTHONPATH', 'ROS_PACKAGE_PATH')}
    done = subprocess.run(['bash', '-c', script], env=clean, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    assert (tmp_path / 'made' / 'image_5.jpg').is_file()
    assert (tmp_path / 'wall' / 'worlds' / 'wall.world').is_file()
    assert (tmp_path / 'wall.pdf').is_file()  # aruco-ar finds the lessons
    assert os.path.isfile(prefix + '/share/unit5/gazebo/worlds/wall.world')
    for name in ('/exercise5_6', '/wall_camera', '/page'):
        assert name in done.stdout.splitlines()
    assert os.path.isfile(prefix + '/share/unit5/web/index.html')
    assert prefix + '/share/unit5/images/earth.jpg' in done.stdout
    assert prefix + '/lib/python3/dist-packages/aruco_ar' in done.stdout
    # So its version is that of the sources.
    assert prefix + '/lib/python3/dist-packages/aruco_ar/compiled/libunit5.so' in done.stdout
    for name in ('artag_generator.py', 'exercise5_2.py', 'gazebo_wall.py', 'wall_camera.py'):
        with open('%s/lib/unit5/%s' % (prefix, name)) as installed, \
                open(program(name)) as source:
            assert installed.readline() == '#!/usr/bin/env python3\n'
            source.readline()
            assert installed.read() == source.read()


def test_a_shell_with_the_environment_has_roscd_and_completes_our_programs(package):
    asked = 'source script/env; roscd unit5; pwd; complete -p rosrun roslaunch; ' \
            'COMP_WORDS=(rosrun unit5 artag); COMP_CWORD=2; _roscomplete_exe rosrun artag unit5; ' \
            'echo ${COMPREPLY[@]}'
    done = subprocess.run(['bash', '-c', asked], cwd=package, capture_output=True, text=True)
    lines = done.stdout.splitlines()
    assert lines[0] == package and lines[-1] == 'artag_generator.py', done
    assert len(lines) == 4
