"""Nodes in front of a camera: starting them, and comparing what they publish."""
