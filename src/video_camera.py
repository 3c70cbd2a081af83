#!/usr/bin/env python3
"""Publish a webcam, a video, a photo or a stream from the network as a camera.

This program checks its source, and then becomes image_publisher. A relative
path begins in the folder in which roslaunch was started. If there is no such
file or webcam, the program says so once, and waits for it.
"""
import argparse
import os
import sys
import time

import aruco_program  # noqa: F401  before all else
import roslib.packages
from aruco_ar import InputError

PUBLISHER = 'image_publisher'  # the name of its package, too
DEVICE = '/dev/video'
WAIT_S = 1.0


def find_source(text, folder=''):
    """The source for image_publisher: the number of a webcam, an address, or the full path of a file.

    ``folder``: the folder in which a relative path begins. Raises InputError if the source is not there.
    """
    if text.isdigit():
        if not os.path.exists(DEVICE + text):
            numbers = sorted(name[len('video'):] for name in os.listdir('/dev') if name.startswith('video'))
            raise InputError('There is no webcam %s. %s' % (text, (
                'There are: source:=%s.' % ', source:='.join(numbers)) if numbers else
                'None is connected. A video or a photo will do: source:=/full/path/of/wall.mp4.'))
        return text
    path = os.path.join(folder, os.path.expanduser(text))
    if '://' not in text and not os.path.exists(path):
        raise InputError('There is no file "%s". Give the path of a video or a photo: '
                         'source:=/full/path/of/wall.mp4.' % path)
    return text if '://' in text else path


def wait_for_source(text, folder):
    """Wait until the source is there, and return what find_source returns. Prints once what is missing."""
    told = None
    while True:
        try:
            return find_source(text, folder)
        except InputError as error:
            if str(error) != told:
                told = str(error)
                print('video_camera: %s Waiting for it.' % told, file=sys.stderr, flush=True)
        time.sleep(WAIT_S)


def main(argv):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('source', help='the number of a webcam, the path of a video or photo, or an address '
                                       'such as http://phone:8080/video')
    args, of_ros = parser.parse_known_args(argv)
    programs = roslib.packages.find_node(PUBLISHER, PUBLISHER)
    if not programs:
        sys.exit('video_camera: image_publisher is not installed. Run script/setup, or install the package '
                 'image-publisher of your ROS.')
    source = wait_for_source(args.source, os.environ.get('PWD', ''))
    os.execv(programs[0], [programs[0], source, *of_ros])


if __name__ == '__main__':
    main(sys.argv[1:])
