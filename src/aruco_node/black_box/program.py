"""Finds a node's program as rosrun and roslaunch do."""
import os

import rospkg
from aruco_ar.base.errors import InputError
from roslib.packages import find_node, find_resource


def program_of(node):
    """(path of the program, folder of its package or None) of a node: package/program, or the path of a file.

    Raises InputError, with a sentence, if it is not there or cannot be executed.
    """
    package, _, program = node.rpartition('/')
    if os.path.isabs(node) or node.startswith('.') or '/' in package or not package:
        path = os.path.abspath(os.path.expanduser(node))
        return _executable([path] if os.path.isfile(path) else [], path), rospkg.get_package_name(path) and \
            _folder_above(path)
    try:
        folder = rospkg.RosPack().get_path(package)
        found = find_node(package, program)
    except rospkg.ResourceNotFound:
        raise InputError('ROS does not know the package "%s". Is its name right, and has this terminal its '
                         'setup file: source ~/catkin_ws/devel/setup.bash?' % package) from None
    return _executable(found or find_resource(package, program), '%s/%s' % (package, program), folder), folder


def _executable(paths, name, folder=''):
    """The first of these files that can be executed. In devel space catkin's own start file is the first."""
    if not paths:
        raise InputError('There is no program %s%s.%s' % (
            name, ' below ' + folder if folder else '',
            ' If it is written in C++, build it first: catkin_make.' if not name.endswith('.py') else ''))
    path = next((path for path in paths if os.access(path, os.X_OK)), None)
    if path is None:
        raise InputError('%s is not executable, so rosrun and roslaunch cannot start it: chmod +x %s'
                         % (os.path.basename(paths[0]), paths[0]))
    return path


def _folder_above(path):
    """The folder of the package that a file is in."""
    folder = os.path.dirname(path)
    while not os.path.exists(os.path.join(folder, 'package.xml')):
        folder = os.path.dirname(folder)
    return folder
