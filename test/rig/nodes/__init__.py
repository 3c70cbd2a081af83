"""Nodes before a camera: starting them, and comparing what they publish."""
