"""What is wrong with the node around the learner's function."""
from __future__ import annotations

from aruco_course.check import Check, Fault


def fault_of_plumbing(path: str, check: Check) -> Fault | None:
    return None
