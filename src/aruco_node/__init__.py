"""The node layer: everything between ROS and ``aruco_ar``, which knows nothing of ROS."""
from .exercise import run

__all__ = ['run']
