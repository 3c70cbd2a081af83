"""The poses of tags, of the wall, and of the camera in front of it."""
