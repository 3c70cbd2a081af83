#!/usr/bin/env python3
"""Calibrates a camera from a video or photos of a flat sheet of tags; see --help."""
import sys

import aruco_program  # noqa: F401  before all else
from aruco_program.calibrate_command import main

if __name__ == '__main__':
    main(sys.argv[1:])
