"""Geometry of the plane: homographies, line crossings, the order of points, and the pose of flat things."""
