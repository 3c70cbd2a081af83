#!/usr/bin/env python3
"""Make the simulated camera's wall for Gazebo: a model, and a world that contains it.

This program needs neither a roscore nor Gazebo. Without arguments, it reads
config/wall.yaml and writes the files in the package's gazebo/, which
wall_gazebo.launch shows.
"""
import argparse
import os
import sys

import aruco_program  # noqa: F401  before all else
from aruco_ar import InputError
from aruco_ar.base.files import own_folder, package_folder, write_whole
from aruco_ar.simulation.gazebo import wall_files
from aruco_ar.walls.wall import load_wall


def parse(argv):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--wall', metavar='FILE.yaml',
                        help="file of the wall (default: the package's config/wall.yaml)")
    parser.add_argument('--output', metavar='FOLDER',
                        help="folder to write to (default: the package's gazebo/, or ./gazebo)")
    return parser.parse_args(argv)


def main(argv):
    # roslaunch adds arguments of its own, such as __name:=..., which are ignored here.
    args = parse([arg for arg in argv if not arg.startswith('__')])
    try:
        files = wall_files(load_wall(args.wall or os.path.join(package_folder(), 'config', 'wall.yaml')))
        folder = args.output or own_folder('gazebo')
        for path, data in files.items():
            write_whole(os.path.join(folder, path), data)
            print('Wrote %s' % os.path.abspath(os.path.join(folder, path)))
    except InputError as error:
        sys.exit('gazebo_wall: %s' % error)


if __name__ == '__main__':
    main(sys.argv[1:])
