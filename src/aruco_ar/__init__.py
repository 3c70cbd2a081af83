"""Augmented reality with ArUco tags, in plain Python on arrays.

Each frame goes through the same steps: the Detector finds its tags, find_area
finds the area between them, and overlay paints the picture into the area. A
Tracker finds the area in a sequence of frames. The package ``aruco_node``
connects this one to ROS.

The subpackages are base, compiled, geometry, tags, settings, walls, tracking, poses,
painting, looks, hints, calibration, and simulation. The module ``exercise`` says what an exercise is.
"""
from .base import required  # noqa: F401  first: it explains which module is too old, before that module fails
from .base.errors import InputError
from .geometry.lens import Lens
from .geometry.ordering import largest_quadrilateral, order_coordinates
from .painting.marks import fill_polygon, mark_centers, mark_tags
from .painting.paint import area_mask, overlay, subtract
from .painting.picture_file import load_picture
from .poses.area_pose import AreaPose
from .poses.estimator import CameraPose, PoseEstimator, TagPose
from .tags.detector import Detector
from .tags.tag import DICTIONARIES, Tag, draw_tag, get_dictionary
from .tracking.area import Area, find_area, find_four_centers
from .tracking.tracker import Tracker

__all__ = [
    'DICTIONARIES', 'Area', 'AreaPose', 'CameraPose', 'Detector', 'InputError', 'Lens', 'PoseEstimator', 'Tag',
    'TagPose', 'Tracker', 'area_mask', 'draw_tag', 'fill_polygon', 'find_area', 'find_four_centers',
    'get_dictionary', 'largest_quadrilateral', 'load_picture', 'mark_centers', 'mark_tags', 'order_coordinates',
    'overlay', 'subtract',
]
