"""Nodes as learners write them: our solutions, changed at one place."""
import os

from aruco_course.exercises import CHECKS
from aruco_course.learner.package import solution

CHECK_OF = {check.number: check for check in CHECKS}


def learners_node(folder, name, *changes, number='5.4', executable=True):
    """Write the solution of an exercise to a file NAME.py, with some changes; returns its path.

    ``changes``: pairs of a text of the solution and what replaces it.
    """
    source = solution(CHECK_OF[number])
    for text, other in changes:
        assert text in source, text
        source = source.replace(text, other)
    path = os.path.join(folder, name + '.py')
    with open(path, 'w') as file:
        file.write(source)
    os.chmod(path, 0o755 if executable else 0o644)
    return path
