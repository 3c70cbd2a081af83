"""What runs in the learner's process: Python's own modules, NumPy and OpenCV, and nothing of this package.

``main.py`` is started as a script, and loads the others by their paths, so that none of their names is in the
way of what the learner imports.
"""
