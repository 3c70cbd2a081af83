"""Stands in for what there is not while the function is judged: ROS, and a screen.

ROS's real modules are taken where they can be imported. A node is never made, neither with them nor without.
"""
from __future__ import annotations

import importlib.machinery
import os
import sys

import cv2

ROS = frozenset(['actionlib', 'actionlib_msgs', 'catkin_pkg', 'cv_bridge', 'diagnostic_msgs',
                 'dynamic_reconfigure', 'genpy', 'geometry_msgs', 'image_geometry', 'image_transport',
                 'message_filters', 'nav_msgs', 'rosbag', 'rosgraph', 'roslib', 'rospkg', 'rospy', 'rostopic',
                 'sensor_msgs', 'std_msgs', 'std_srvs', 'tf', 'tf2_geometry_msgs', 'tf2_ros',
                 'tf_conversions', 'unit5', 'visualization_msgs'])
# What `from … import *` brings.
STARS = {'sensor_msgs.msg': ['CameraInfo', 'CompressedImage', 'Image', 'RegionOfInterest'],
         'std_msgs.msg': ['Bool', 'Float32', 'Header', 'Int32', 'String', 'UInt8'],
         'geometry_msgs.msg': ['Point', 'Pose', 'PoseStamped', 'Twist'],
         'cv_bridge': ['CvBridge', 'CvBridgeError'],
         'message_filters': ['ApproximateTimeSynchronizer', 'Cache', 'Subscriber', 'TimeSynchronizer']}

WINDOWS = ('imshow', 'namedWindow', 'waitKey', 'waitKeyEx', 'pollKey', 'moveWindow', 'resizeWindow',
           'destroyWindow', 'destroyAllWindows', 'startWindowThread', 'setMouseCallback', 'setWindowTitle',
           'selectROI')
MOST_PATHS = 20

unread: list[object] = []   # [path, line] of the image that was last asked for and is not there
written: list[str] = []     # the paths of images that were written
refused: list[str] = []     # those of images that could not be


class NodeNeededError(BaseException):
    """The learner's code asks for what only a running node has.

    It is no Exception, so that ``except Exception`` lets it by.
    """


class NoScreenError(cv2.error):
    """The learner's code wants to show a window."""


class Nothing:
    """A thing of ROS that does nothing."""

    def __init__(self, *_args, **_named):
        pass

    def __call__(self, *_args, **_named):
        return Nothing()

    def __getattr__(self, name):
        if name.startswith('__'):
            raise AttributeError(name)
        return Nothing()

    def __iter__(self):
        return iter(())

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        return False


class NothingMeta(type):
    """Lets a class that stands in have whatever attribute is asked for, such as a constant of a message."""

    def __getattr__(cls, name):
        if name.startswith('__'):
            raise AttributeError(name)
        return Nothing()


def stand_in(name):
    """What stands in for a name of a ROS module: a kind of error, or a class that does nothing."""
    if name.endswith(('Error', 'Exception')):
        return type(name, (Exception,), {})
    return NothingMeta(name, (Nothing,), {})


class Loader:
    """Loads the real module if there is one that can be loaded, else one whose names all do nothing."""

    def __init__(self, real):
        self._real = real

    def create_module(self, spec):
        return self._real.create_module(spec) if self._real else None

    def exec_module(self, module):
        is_real = False
        if self._real:
            try:
                self._real.exec_module(module)
                is_real = True
            except Exception:
                is_real = False
        if not is_real:
            empty(module)
        if module.__name__ == 'rospy':
            without_node(module, is_real)


class Finder:
    """Finds the modules of ROS before anything else does."""

    def __init__(self, folder):
        self._folder = folder

    def find_spec(self, name, path=None, target=None):
        root = name.partition('.')[0]
        if root not in ROS:
            return None
        parent = sys.modules.get(name.rpartition('.')[0])
        if parent is not None and getattr(parent, '__stands_in__', False):
            return importlib.machinery.ModuleSpec(name, Loader(None), is_package=True)
        if '.' in name:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is None or spec.loader is None or not hasattr(spec.loader, 'exec_module'):
            return importlib.machinery.ModuleSpec(name, Loader(None), is_package=True)
        if os.path.dirname(spec.origin or '') == self._folder:
            return None  # a file of the learner's own has this name
        spec.loader = Loader(spec.loader)
        return spec


def empty(module):
    """Let a module have whatever is asked of it."""
    made = {}

    def get(name):
        if name == '__all__':
            return STARS.get(module.__name__, [])
        if name.startswith('__'):
            raise AttributeError('module %r has no attribute %r' % (module.__name__, name))
        return made.setdefault(name, stand_in(name))

    module.__path__ = []
    module.__stands_in__ = True
    module.__getattr__ = get


def without_node(rospy, is_real):
    """Let the functions that make a node, or wait for one, stop the code."""

    def stop(name):
        def stopped(*_args, **_named):
            raise NodeNeededError(name)
        return stopped

    for name in 'init_node', 'spin', 'wait_for_message', 'wait_for_service':
        setattr(rospy, name, stop(name))

    def get_param(name, default=None):
        if default is None:
            raise NodeNeededError('get_param')
        return default

    rospy.get_param = get_param
    for name in 'Publisher', 'Subscriber', 'Service', 'ServiceProxy', 'Timer':
        setattr(rospy, name, stand_in(name))
    if not is_real:
        rospy.is_shutdown = lambda: False


def line_of(path):
    """The line of the learner's file that is being run, or 0."""
    return sys.modules['_trial_describe'].line_now(path)


def put_in(path):
    """Put all that stands in for something else in its place; ``path`` is the learner's file."""
    sys.meta_path.insert(0, Finder(os.path.dirname(path)))

    def without_screen(name):
        def shown(*_args, **_named):
            raise NoScreenError(name)
        return shown

    # They fail in the OpenCV without windows, and without a screen. Elsewhere they would wait for a key.
    for name in WINDOWS:
        setattr(cv2, name, without_screen(name))

    imread, imwrite = cv2.imread, cv2.imwrite

    def reading(filename, *args, **named):
        image = imread(filename, *args, **named)
        if image is None:
            unread[:] = [str(filename)[:500], line_of(path)]
        return image

    def writing(filename, *args, **named):
        is_written = imwrite(filename, *args, **named)
        paths = written if is_written else refused
        if len(paths) < MOST_PATHS:
            paths.append(os.path.abspath(filename)[:500] if is_written else str(filename)[:500])
        return is_written

    cv2.imread, cv2.imwrite = reading, writing
