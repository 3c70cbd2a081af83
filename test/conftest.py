import os

import aruco_program  # noqa: F401  every program of the package imports this first
import aruco_ar
import cv2
import numpy as np
import pytest
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import load_wall
from rig import PACKAGE


def pytest_configure(config):
    cv2.setNumThreads(1)  # as in the nodes, since other tests run at the same time
    # Errors that no caller can catch: those in finalizers and in threads.
    for kind in 'ResourceWarning', 'pytest.PytestUnraisableExceptionWarning', \
            'pytest.PytestUnhandledThreadExceptionWarning':
        config.addinivalue_line('filterwarnings', 'error::' + kind)


@pytest.fixture(scope='session')
def package():
    return PACKAGE


@pytest.fixture(scope='session')
def wall():
    return load_wall(os.path.join(PACKAGE, 'config', 'wall.yaml'))


@pytest.fixture(scope='session')
def view():
    """(R, t) of the wall, seen at a slant with all four tags in sight."""
    return wall_to_camera(Pose(-1.9, 0.6, -0.3))


@pytest.fixture(scope='session')
def frame(wall, view):
    return WallRenderer(wall, Camera(), noise=1.0).render(*view)


@pytest.fixture
def earth():
    """The picture that is painted unless another is chosen."""
    return aruco_ar.load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg'))


@pytest.fixture
def random():
    return np.random.RandomState(7)


@pytest.fixture
def assert_refused(tmp_path):
    """A function that checks that reading a YAML file with this text raises an InputError with these words."""
    def check(read, text, words):
        path = tmp_path / 'some.yaml'
        path.write_text(text)
        with pytest.raises(aruco_ar.InputError, match=words) as error:
            read(str(path))
        assert str(path) in str(error.value)
    return check
