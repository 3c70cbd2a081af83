#!/usr/bin/env python3
"""Write the nodes of the course yourself, and be told whether they are right: rosrun unit5 learn.py start.

This program needs no roscore.
"""
import sys

import aruco_program  # noqa: F401  before all else
from aruco_course.command import main

if __name__ == '__main__':
    sys.exit(main())
