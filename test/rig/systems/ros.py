"""A stand-in for a ROS that is not in /usr: catkin makes its setup files, and the rest links to Debian's."""
import os
import re
import shutil
import subprocess
import sysconfig
from os.path import exists, join

from rig import PACKAGE

PYTHON = '/usr/bin/python3'
PACKAGES = 'lib/python3/dist-packages'
PROJECT = 'cmake_minimum_required(VERSION 3.0.2)\nproject(stand_in)\nfind_package(catkin REQUIRED)\n' \
          'catkin_package()\n'
MANIFEST = '<package format="2"><name>%s</name><version>0.0.0</version><description>A stand-in.</description>' \
           '<maintainer email="unit5@example.com">unit5</maintainer><license>MIT</license>' \
           '<buildtool_depend>catkin</buildtool_depend></package>'


def create_ros(prefix, distro, scratch):
    """Create a ROS in the folder prefix, with setup files, environment hooks, programs, and packages.

    ``distro``: the value for ROS_DISTRO. ``scratch``: a folder that may be filled.
    """
    os.makedirs(join(scratch, 'source'))
    for name, text in ('CMakeLists.txt', PROJECT), ('package.xml', MANIFEST % 'stand_in'):
        with open(join(scratch, 'source', name), 'w') as file:
            file.write(text)
    build = join(scratch, 'build')
    clean = {key: value for key, value in os.environ.items() if key != 'CMAKE_PREFIX_PATH'}
    for command in (['cmake', '-S', join(scratch, 'source'), '-B', build, '-DCMAKE_INSTALL_PREFIX=' + prefix,
                     '-DCATKIN_ENABLE_TESTING=OFF', '-DPYTHON_EXECUTABLE=' + PYTHON],
                    ['cmake', '--build', build, '--target', 'install']):
        done = subprocess.run(command, env=clean, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, done.stdout
    hooks = join(prefix, 'etc/catkin/profile.d')
    shutil.copytree('/etc/catkin/profile.d', hooks)
    with open(join(hooks, '1.ros_distro.sh'), 'w') as file:
        file.write('export ROS_DISTRO=%s\n' % distro)
    os.symlink('/etc/ros', join(prefix, 'etc/ros'))
    for name in os.listdir('/usr/share'):
        if exists('/usr/share/%s/package.xml' % name):
            os.symlink('/usr/share/' + name, join(prefix, 'share', name))
            if exists('/usr/lib/' + name):  # its nodes
                os.symlink('/usr/lib/' + name, join(prefix, 'lib', name))
    with open(join(PACKAGE, 'script/packages.txt')) as file:
        needed = re.findall(r'ros-noetic-(\S+)', file.read())
    for name in (each.replace('-', '_') for each in needed):
        if not exists(join(prefix, 'share', name)):  # such as ros_core, for which Debian has no folder
            os.makedirs(join(prefix, 'share', name))
            with open(join(prefix, 'share', name, 'package.xml'), 'w') as file:
                file.write(MANIFEST % name)
    os.makedirs(join(prefix, 'bin'))
    for name in 'roscore', 'roslaunch', 'rosrun', 'rospack', 'catkin_find':
        os.symlink('/usr/bin/' + name, join(prefix, 'bin', name))
    os.makedirs(join(prefix, PACKAGES))
    link_all(sysconfig.get_paths()['purelib'], join(prefix, PACKAGES))  # so that pip has nothing to fetch


def add_python(prefix):
    """Give the ROS in the folder prefix a Python of its own, as conda has. It has all that the system's has."""
    version = subprocess.run([PYTHON, '-c', 'import sys; print("python%d.%d" % sys.version_info[:2])'],
                             stdout=subprocess.PIPE, text=True, check=True).stdout.strip()
    for name in version, 'python3':
        shutil.copy(PYTHON, join(prefix, 'bin', name))  # a copy, for Python follows a link to find its folder
    os.makedirs(join(prefix, 'lib', version))
    link_all('/usr/lib/' + version, join(prefix, 'lib', version))
    link_all('/usr/' + PACKAGES, join(prefix, PACKAGES))


def link_all(folder, into):
    """Link everything in a folder into another one, except for what is there already, in any version."""
    there = {project(name) for name in os.listdir(into)} - {None}
    for name in os.listdir(folder):
        if not os.path.lexists(join(into, name)) and project(name) not in there:
            os.symlink(join(folder, name), join(into, name))


def project(name):
    """The Python package that a folder such as PyYAML-6.0.dist-info describes; None if it is no such folder."""
    name, kind = os.path.splitext(name)
    return re.sub('[-_.]+', '-', name.split('-')[0]).lower() if kind in ('.dist-info', '.egg-info') else None
