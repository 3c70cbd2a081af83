"""The node layer: everything between ROS and ``aruco_ar``, which knows nothing of ROS."""
import aruco_ar  # noqa: F401  before all else: see there

from .exercise import run

__all__ = ['run']
