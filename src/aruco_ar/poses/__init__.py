"""Poses: of tags, of the wall, and of the camera before it."""
