"""Augmented reality with ArUco tags, in plain Python on arrays.

A frame goes one way: frame -> tags (Detector) -> area (find_area) -> picture
(overlay). A Tracker finds the area in a sequence of frames. What connects this
to ROS is in ``aruco_node``.
"""
import os
import sys


def _say(kind, error, trace, say=sys.excepthook):
    """Ctrl-C ends a program, also one that is just beginning: nobody wants to read where it was."""
    if not issubclass(kind, KeyboardInterrupt):
        say(kind, error, trace)


sys.excepthook = _say

# All matrices here are small. Threads of numpy's OpenBLAS would only wait for
# each other, and take up a whole core while they do; it has to know beforehand.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
# What OpenCV and its FFmpeg think of a broken file is said by us, once, in a sentence.
os.environ.setdefault('OPENCV_LOG_LEVEL', 'FATAL')
os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')

from .area import Area, find_area, find_four_centers
from .area_pose import AreaPose
from .detector import Detector
from .errors import InputError
from .lens import Lens
from .ordering import largest_quadrilateral, order_coordinates
from .paint import area_mask, fill_polygon, mark_centers, mark_tags, overlay, subtract
from .picture import load_picture
from .poses import CameraPose, PoseEstimator, TagPose
from .tags import DICTIONARIES, Tag, draw_tag, get_dictionary
from .tracker import Tracker

__all__ = [
    'DICTIONARIES', 'Area', 'AreaPose', 'CameraPose', 'Detector', 'InputError', 'Lens', 'PoseEstimator', 'Tag',
    'TagPose', 'Tracker', 'area_mask', 'draw_tag', 'fill_polygon', 'find_area', 'find_four_centers',
    'get_dictionary', 'largest_quadrilateral', 'load_picture', 'mark_centers', 'mark_tags', 'order_coordinates',
    'overlay', 'subtract',
]
