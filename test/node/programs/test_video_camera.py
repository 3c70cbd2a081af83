"""video_camera.py: what it opens, and what it says about what is not there."""
import os
import subprocess
import sys

import pytest
from aruco_ar import InputError
from rig.processes.started import WAIT_S
from video_camera import find_source


def test_paths_addresses_and_relative_paths_are_found(tmp_path):
    path = tmp_path / 'wall clip.mp4'
    path.write_bytes(b'')
    assert find_source(str(path)) == str(path)
    assert find_source('wall clip.mp4', str(tmp_path)) == str(path)
    assert find_source('http://phone:8080/video', str(tmp_path)) == 'http://phone:8080/video'


def test_what_is_missing_is_named_with_the_remedy(tmp_path):
    with pytest.raises(InputError, match='no file ".*/none.mp4".*source:=/full/path'):
        find_source('none.mp4', str(tmp_path))
    with pytest.raises(InputError, match='no webcam 98'):
        find_source('98')


def test_it_says_so_once_waits_and_then_becomes_image_publisher(package, tmp_path):
    path = tmp_path / 'later.mp4'
    # ROS finds the programs of a package in its libexec folder: here is one that prints its arguments.
    program = tmp_path / 'lib' / 'image_publisher' / 'image_publisher'
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\necho "published: $@"\n')
    program.chmod(0o755)
    (tmp_path / '.catkin').write_text('')
    share = tmp_path / 'share' / 'image_publisher'
    share.mkdir(parents=True)
    (share / 'package.xml').write_text(
        '<package format="2"><name>image_publisher</name><version>1.0.0</version><description>a stand-in'
        '</description><maintainer email="a@b.c">a</maintainer><license>BSD</license></package>')
    process = subprocess.Popen(
        [sys.executable, package + '/src/video_camera.py', 'later.mp4', '__name:=eye'], text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, 'PWD': str(tmp_path), 'CMAKE_PREFIX_PATH': str(tmp_path),
             'ROS_PACKAGE_PATH': str(tmp_path / 'share')})
    said = process.stderr.readline()
    assert 'There is no file "%s"' % path in said and 'Waiting for it' in said
    path.write_bytes(b'')
    output, errors = process.communicate(timeout=WAIT_S)
    assert output == 'published: %s __name:=eye\n' % path and errors == ''
