"""Geometry of the plane: homographies, putting points in order, the pose of flat things."""
