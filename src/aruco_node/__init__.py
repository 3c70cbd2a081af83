"""Everything between ROS and ``aruco_ar``, which does not use ROS."""
import aruco_program  # noqa: F401  before all else

from .nodes.exercise import run

__all__ = ['run']
