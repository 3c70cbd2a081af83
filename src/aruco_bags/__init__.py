"""Runs an exercise on the frames of bags, without a roscore: piece by piece, in several processes."""
from aruco_ar.base.versions import need

need('distributed')
