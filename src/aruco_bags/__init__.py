"""Bags: their frames looked at without a roscore, piece by piece, on as many processor cores as there are."""
from aruco_ar.base.versions import need

need('distributed')
