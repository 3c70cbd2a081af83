"""Augmented reality with ArUco tags, in plain Python on arrays.

A frame goes one way: frame -> tags (Detector) -> area (find_area) -> picture
(overlay). A Tracker finds the area in a sequence of frames. What connects this
to ROS is in ``aruco_node``.
"""
from . import beginning  # noqa: F401  before all else
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
