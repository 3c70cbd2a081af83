"""Hostile messages of a camera."""
