"""video_camera.py: what it opens, and what it says about what is not there."""
import errno
import os
import shutil
import struct
import subprocess
import sys
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import video_camera
from aruco_ar import InputError
from rig.processes.started import WAIT_S
from video_camera import find_source

VIDEO = b'\x00\x00\x00\x18ftypmp42'


def test_paths_addresses_and_relative_paths_are_found(tmp_path):
    path = tmp_path / 'wall clip.mp4'
    path.write_bytes(VIDEO)
    assert find_source(str(path)) == str(path)
    assert find_source('wall clip.mp4', str(tmp_path)) == str(path)
    assert find_source('http://phone:8080/video', str(tmp_path)) == 'http://phone:8080/video'
    for address in 'file://%s' % path, 'file:' + str(path), path.as_uri(), 'file://localhost%s' % path:
        assert find_source(address, '/elsewhere') == str(path)


def test_a_file_that_is_neither_a_photo_nor_a_video_is_named(tmp_path):
    for name, data in (('notes.png', b'Buy milk.\n'), ('empty.mp4', b''),
                       ('list.avi', b'ffconcat version 1.0\n')):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match='/%s" is neither a photo nor a video. Give the path of' % name):
            find_source(str(tmp_path / name))


def test_photos_and_videos_of_any_name_and_format_are_taken(tmp_path, package):
    image = np.random.RandomState(1).randint(0, 256, (48, 64, 3)).astype(np.uint8)
    for name in 'a.jpg', 'a.png', 'a.bmp', 'a.webp', 'a.tiff':
        cv2.imwrite(str(tmp_path / name), image)
        (tmp_path / name).rename(tmp_path / (name + '.old'))
        assert find_source(name + '.old', str(tmp_path)) == str(tmp_path / (name + '.old'))
    header = b'YUV4MPEG2 W64 H48 F25:1 Ip A1:1 C420\nFRAME\n'
    (tmp_path / 'raw.y4m').write_bytes(header + bytes(64 * 48 * 3 // 2))
    assert find_source('raw.y4m', str(tmp_path)) == str(tmp_path / 'raw.y4m')
    of_no_text = os.fsdecode(bytes(tmp_path) + b'/\xff.png')  # not UTF-8
    shutil.copy(package + '/images/earth.jpg', of_no_text)
    assert find_source(of_no_text) == find_source('file://%s/%%ff.png' % tmp_path) == of_no_text


def test_what_is_missing_is_named_with_the_remedy(tmp_path):
    with pytest.raises(InputError, match='no file ".*/none.mp4".*source:=/full/path'):
        find_source('none.mp4', str(tmp_path))
    with pytest.raises(InputError, match='no webcam 98'):
        find_source('98')


CAMERA, OF_DATA, OUTPUT, MANY_PLANES = 0x85200001, 0x84a00000, 0x85200002, 0x84201000


@pytest.fixture
def webcams(tmp_path, monkeypatch):
    """A function that puts files in place of webcams, {number: capabilities, or an error of opening it}."""
    def make(devices):
        folder = tmp_path / 'dev'
        folder.mkdir()
        monkeypatch.setattr(video_camera, 'DEVICE', str(folder / 'video'))
        of_path = {str(folder / 'video') + number: what for number, what in devices.items()}
        for path in of_path:
            open(path, 'wb').close()
        opened, paths = os.open, {}

        def open_device(path, *arguments, **others):
            if isinstance(of_path.get(path), OSError):
                raise of_path[path]
            paths[opened(path, *arguments, **others)] = path
            return max(paths)

        def answer(device, request, about):
            what = of_path[paths.pop(device)]
            if what is None:  # any other file
                raise OSError(errno.ENOTTY, 'Inappropriate ioctl for device')
            return struct.pack('=84x5I', 0x80000000 | CAMERA | what, what, 0, 0, 0)
        monkeypatch.setattr(video_camera.os, 'open', open_device)
        monkeypatch.setattr(video_camera.fcntl, 'ioctl', answer)
        return str(folder / 'video')
    return make


def test_a_webcam_is_found_by_its_number_its_path_and_a_link_to_it(webcams, tmp_path):
    device = webcams({'0': CAMERA, '1': OF_DATA, '12': MANY_PLANES})
    (tmp_path / 'by-name').symlink_to(device + '0')
    for given, number in ('0', '0'), (device + '0', '0'), (str(tmp_path / 'by-name'), '0'), ('12', '12'):
        assert find_source(given) == number


@pytest.mark.parametrize('what, words', [
    (OF_DATA, 'video1 gives no images. Many webcams have a second device.* There are: source:=0, source:=10.$'),
    (OUTPUT, 'video1 gives no images'), (None, 'video1 is not a camera. There are'),
    (PermissionError(errno.EACCES, 'Permission denied'),
     'video1 may not be read by this user. Run: sudo usermod -a -G .* [$]USER, and log in again. There are: '),
    (OSError(errno.EBUSY, 'Device or resource busy'),
     r'video1 cannot be opened \(Device or resource busy\). Does another program')])
def test_a_device_that_gives_no_images_is_named_with_the_reason_and_the_cameras_there_are(what, words, webcams):
    webcams({'0': CAMERA, '1': what, '10': CAMERA, '2': None, '3': PermissionError()})
    with pytest.raises(InputError, match=words):
        find_source('1')
    with pytest.raises(InputError, match='no webcam 7. There are: source:=0, source:=10.$'):
        find_source('7')


def test_a_device_that_gives_no_images_and_is_the_only_one(webcams):
    device = webcams({'0': None})
    with pytest.raises(InputError, match='%s0 is not a camera. No other webcam is connected. A video' % device):
        find_source('0')


def test_a_file_in_place_of_a_webcam_is_not_a_camera(tmp_path, monkeypatch):
    """It is really opened and asked."""
    (tmp_path / 'video0').write_bytes(b'')
    monkeypatch.setattr(video_camera, 'DEVICE', str(tmp_path / 'video'))
    with pytest.raises(InputError, match='video0 is not a camera'):
        find_source('0')


def test_the_group_of_the_device_is_named(tmp_path, monkeypatch):
    path = tmp_path / 'video0'
    path.write_bytes(b'')
    monkeypatch.setattr(video_camera.grp, 'getgrgid', lambda number: SimpleNamespace(gr_name='plugdev'))
    assert video_camera._group_of(str(path)) == 'plugdev'
    monkeypatch.setattr(video_camera.grp, 'getgrgid', lambda number: SimpleNamespace(gr_name='root'))
    assert video_camera._group_of(str(path)) == 'video'


def test_a_folder_and_a_file_that_may_not_be_read_are_named(tmp_path, monkeypatch):
    with pytest.raises(InputError, match='" is a folder'):
        find_source(str(tmp_path))
    path = tmp_path / 'secret.mp4'
    path.write_bytes(b'')
    monkeypatch.setattr(video_camera.os, 'access', lambda path, mode: False)
    with pytest.raises(InputError, match='secret.mp4" may not be read'):
        find_source(str(path))


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
        [sys.executable, package + '/nodes/video_camera.py', 'later.mp4', '__name:=eye'], text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, 'PWD': str(tmp_path), 'CMAKE_PREFIX_PATH': str(tmp_path),
             'ROS_PACKAGE_PATH': str(tmp_path / 'share')})
    said = process.stderr.readline()
    assert 'There is no file "%s"' % path in said and 'Waiting for it' in said
    (tmp_path / 'whole').write_bytes(VIDEO)
    (tmp_path / 'whole').rename(path)
    output, errors = process.communicate(timeout=WAIT_S)
    assert output == 'published: %s __name:=eye\n' % path and errors == ''
