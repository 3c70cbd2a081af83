#!/usr/bin/env python3
"""Run an exercise on all frames in bags.

Needs no roscore. For each NAME.bag it writes a NAME.bag with the images of the
exercise into a folder, for each NAME.mcap a NAME.mcap, and with --video a
NAME.mp4. The table tags.csv has every tag in every frame of all bags. If it is
interrupted, the same command continues.
"""
import argparse
import os
import re
import runpy
import signal
import sys
import time

import aruco_program  # noqa: F401  before all else
import yaml
from aruco_ar import InputError
from aruco_ar.settings.declaration import parameters_of
from aruco_bags.bag_reader import PIECE_S
from aruco_bags.job import jobs_of, locked
from aruco_bags.task import Task, check_picture
from aruco_bags.workers import work, workers
from aruco_node.messages.bridge import fault_of_bridge
from aruco_node.nodes.manual import parameter_rows, table
from aruco_node.parameters.parameters import read
from aruco_node.parameters.settings import BagSettings

MAX_PIECE_S = 100000
HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.join(os.path.dirname(HERE), 'src')
FOLDER = SOURCE if os.path.isdir(SOURCE) else HERE  # of the exercises; an install space has all programs in one
EXERCISES = [number.replace('_', '.')
             for number in sorted(re.findall(r'\bexercise(5_\d+)\.py\b', ' '.join(os.listdir(FOLDER))))]
# These parameters of nodes do not affect what is made of bags.
OF_NODES = ('image_transport', 'folder', 'scale', 'areas', 'camera_info', 'tag_frame', 'wall_frame',
            'robot_frame')
PARAMETERS = [name for name in parameters_of(BagSettings) if name not in OF_NODES]


def parse(argv):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog='parameters, such as _ids:=1,2,3,4 or _tag_size:=0.2:\n%s\n\n'
               'Only pictures that stand still can be painted into bags: JPEG and PNG.'
               % table([row for row in parameter_rows(BagSettings, '_') if row[0][1:] in PARAMETERS]))
    option = parser.add_argument
    option('bags', nargs='+', metavar='BAG',
           help='a bag, or an MCAP file of ROS 1, with images, raw or compressed')
    option('--out', required=True, metavar='FOLDER', help='folder for the output')
    option('--exercise', choices=EXERCISES, type=lambda text: text.replace('_', '.'), default='5.6',
           help='exercise to run; 5_2 is the same as 5.2 (default: 5.6)')
    option('--video', action='store_true', help='write MP4s as well')
    option('--mcap', action='store_true', help='write MCAP files for bags, too')
    who = parser.add_mutually_exclusive_group().add_argument
    who('--workers', type=int, metavar='N', default=os.cpu_count(),
        help='processes on this machine (default: as many as it has processor cores)')
    who('--scheduler', metavar='tcp://HOST:PORT', help='address of the Dask scheduler to use instead')
    option('--piece', type=float, metavar='SECONDS', default=PIECE_S,
           help='length of the pieces that each bag is cut into (default: %g)' % PIECE_S)
    args = parser.parse_args([arg for arg in argv if ':=' not in arg])
    if args.workers < 1:
        parser.error('--workers takes a number from 1, not %d' % args.workers)
    if not 1 <= args.piece <= MAX_PIECE_S:
        parser.error('--piece takes a number of seconds from 1 to %d, not %g' % (MAX_PIECE_S, args.piece))
    return args


def settings(argv):
    """BagSettings from the arguments of the form _NAME:=VALUE. Raises InputError."""
    given = {}
    for name, text in (arg.split(':=', 1) for arg in argv if ':=' in arg):
        if name.startswith('__'):  # roslaunch adds __name and __log
            continue
        if name[:1] != '_' or name[1:] not in PARAMETERS:
            raise InputError('There is no parameter "%s"; there are _%s.' % (name, ', _'.join(PARAMETERS)))
        try:
            given[name[1:]] = yaml.safe_load(text)
        except (yaml.YAMLError, ValueError):
            given[name[1:]] = text
    for name in 'picture', 'wall':
        if isinstance(given.get(name), str) and os.path.exists(given[name]):
            given[name] = os.path.abspath(given[name])  # otherwise it may be a file of the package
    return read(BagSettings, given.get)


def exercise(number):
    """The Exercise of a number, such as '5.2', that its file declares."""
    # Workers do not import programs. So Dask sends them what this file defines by value.
    path = os.path.join(FOLDER, 'exercise%s.py' % number.replace('.', '_'))
    return runpy.run_path(path, run_name='exercise')['EXERCISE']


def main(argv):
    args = parse(argv)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        fault = fault_of_bridge()
        if fault:
            print('annotate_bags: %s' % fault, file=sys.stderr)
        task = Task(exercise(args.exercise), settings(argv), FOLDER)
        check_picture(task)
        task.settings.remembered_wall()  # raises if it cannot be read
        jobs = jobs_of(args.bags, task, args.out, args.video, args.mcap, args.piece)
        began = time.monotonic()
        with locked(args.out), workers(args.scheduler, args.workers) as client:
            frames, is_all = work(jobs, client, args.out)
            count = len(client.nthreads())
    except InputError as error:
        sys.exit('annotate_bags: %s' % error)
    except KeyboardInterrupt:
        print('annotate_bags: interrupted. The same command continues from here.', file=sys.stderr)
        sys.exit(130)
    seconds = time.monotonic() - began
    if frames:
        print('%d frames in %.1f s: %.1f a second, %d worker%s'
              % (frames, seconds, frames / seconds, count, 's' * (count > 1)))
    sys.exit(not is_all)


if __name__ == '__main__':
    main(sys.argv[1:])
