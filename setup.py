"""Called by catkin (catkin_python_setup); not meant to be called by hand."""
from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=['aruco_ar', 'aruco_node', 'aruco_bags', 'page_server'],
                                 package_dir={'': 'src'}))
