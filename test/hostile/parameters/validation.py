"""Reads and validates parameters and the files that they name, as a node does before it starts working."""
import os
import resource
import runpy
import signal
from contextlib import contextmanager
from unittest import mock
from xmlrpc.client import Binary

import numpy as np
import yaml
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import package_folder
from aruco_ar.exercise import AREA, PICTURE, TAGS, Exercise, Result
from aruco_ar.runner import Runner
from aruco_ar.settings.settings import LEARN
from aruco_ar.simulation.robot import load_path
from aruco_ar.walls.wall import load_wall
from aruco_node.nodes.camera_lens import CameraLens
from aruco_node.nodes.pictures import open_picture
from aruco_node.parameters.parameters import read, ros_values
from aruco_node.parameters.settings import PictureSettings, load_areas
from page_server.access import is_loopback
from rig.processes.started import program

MAX_SENTENCE = 500
FRAME = np.full((48, 64, 3), 180, np.uint8)


class Stuck(BaseException):
    """Raised if something takes too long. It is no Exception, since that might be caught."""


class _Writer(yaml.Dumper):
    """Writes YAML as without ROS: its rosparam, once imported, makes PyYAML fail at an empty Binary."""


_Writer.add_representer(Binary, lambda writer, binary: writer.represent_binary(binary.data))


def settings_of(node):
    """The settings class of a node, which is known by running the node's program."""
    found = []

    def record(name, work, manual):
        found.append(manual.settings)
    nodes = 'aruco_node.nodes.'
    with mock.patch(nodes + 'node.run_node', record), mock.patch(nodes + 'exercise.run_node', record):
        runpy.run_path(program(node + '.py'), run_name='__main__')
    return found[0]


def read_with(kind, name, value):
    """Settings of a class in which one parameter has this value, and the others their defaults."""
    return read(kind, lambda other, default: value if other == name else default)


def taken(kind, name, value):
    """The Settings with this value of a parameter, after opening everything that they name.

    Raises InputError if a node would refuse the value.
    """
    settings = read_with(kind, name, value)
    assert read(kind, ros_values(settings).get) == settings, 'the parameter server gives it back differently'
    has = {each: getattr(settings, each) for each in ros_values(settings)}
    if has.get('areas', 'none') != 'none':
        for area in load_areas(settings.areas):
            _look(read(kind, lambda other, default: area.get(other, has[other])))
    elif 'search' in has:
        _look(settings)
    if 'camera_info' in has:
        CameraLens(settings, '/camera/rgb/image_raw')
    if has.get('wall', LEARN) != LEARN:
        load_wall(os.path.join(package_folder(), os.path.expanduser(settings.wall)))
    if has.get('path', 'none') != 'none':
        load_path(settings.path)
    if 'address' in has:
        is_loopback(settings.address)
    return settings


def area_taken(path, name, value):
    """Write a file of areas to a path, the first of which has this entry, and read it.

    Raises InputError if a node would refuse it.
    """
    with open(path, 'w') as file:
        yaml.dump({'areas': [{'ids': [1, 2, 3, 4], name: value}, {'ids': [5, 6, 7, 8]}]}, file, _Writer)
    for area in load_areas(path):
        _look(read(PictureSettings, area.get))


def _look(settings):
    needs = [TAGS] + [AREA] * hasattr(settings, 'hold') + [PICTURE] * hasattr(settings, 'picture')
    runner = Runner(Exercise('any', lambda scene: Result([scene.image], scene.tags), needs), [settings],
                    open_picture)
    for stamp in 0.0, 0.1:
        runner.run(FRAME, stamp)


def refusal(take, *arguments):
    """The sentence with which a function refuses a value, or None. Other errors are not caught."""
    try:
        take(*arguments)
    except InputError as error:
        return str(error)
    return None


def fault_of(sentence, name=None):
    """What is wrong with a sentence that refuses a value, or None. It must name the parameter ``name``."""
    if len(sentence) > MAX_SENTENCE:
        return 'it has %d characters' % len(sentence)
    if not sentence.isprintable():
        return 'it has characters that cannot be printed'
    if name and '~' + name not in sentence:
        return 'it does not name ~' + name
    return None


@contextmanager
def bounded(seconds=60, more_bytes=1 << 30):
    """Raise Stuck or MemoryError in the main thread if the block takes more time or memory."""
    def stop(number, frame):
        raise Stuck('it took longer than %d s' % seconds)
    with open('/proc/self/statm') as file:
        now = int(file.read().split()[0]) * resource.getpagesize()
    limits = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    resource.setrlimit(resource.RLIMIT_AS, (now + more_bytes, limits[1]))
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, limits)
