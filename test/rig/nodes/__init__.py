"""Nodes in front of a camera: a master for them, starting them, and comparing what they publish."""
