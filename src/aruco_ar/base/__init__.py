"""Basics: array types, errors, files, progress, dicts of limited size, and the required versions."""
