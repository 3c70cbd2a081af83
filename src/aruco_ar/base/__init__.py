"""Basics: array types, errors, files, progress, stale frames, dicts of limited size, and required versions."""
