#!/usr/bin/env python3
"""Publish a webcam, a video, a photo or a stream from the network as a camera.

This program checks its source, and then becomes image_publisher. A relative
path begins in the folder in which roslaunch was started. If there is no such
file or webcam, the program says so once, and waits for it.
"""
import argparse
import fcntl
import grp
import os
import struct
import sys
import time

import aruco_program  # noqa: F401  before all else
import cv2
import roslib.packages
from aruco_ar import InputError
from aruco_ar.base.files import opened, path_of
from aruco_ar.painting.sources import TIMEOUTS, is_video

PUBLISHER = 'image_publisher'  # the name of its package, too
DEVICE = '/dev/video'
GROUP = 'video'  # users of this group may read webcams, in most distributions
# From linux/videodev2.h: the request VIDIOC_QUERYCAP, the size of its answer, and the bits of its capabilities.
QUERY, QUERY_BYTES, CAPABILITIES_AT = 0x80685600, 104, 84
HAS_DEVICE, CAPTURES = 0x80000000, 0x1 | 0x1000
WAIT_S = 1.0


def find_source(text, folder=''):
    """The source for image_publisher: the number of a webcam, an address, or the full path of a file.

    ``folder``: the folder in which a relative path begins. Raises InputError if the source is not there, or
    cannot be used.
    """
    if '://' in text and not text.startswith('file:'):
        return text
    path = DEVICE + text if text.isdigit() else os.path.join(folder, path_of(text))
    number = os.path.realpath(path)[len(DEVICE):] if os.path.realpath(path).startswith(DEVICE) else ''
    if text.isdigit() or number.isdigit():  # a name such as /dev/v4l/by-id/... is a link to a webcam
        number = number if number.isdigit() else text
        fault = fault_of_webcam(DEVICE + number)
        if fault:
            raise InputError('%s %s' % (fault, _other_sources()))
        return number
    if not os.path.exists(path):
        raise InputError('There is no file "%s". Give the path of a video or a photo: '
                         'source:=/full/path/of/wall.mp4.' % path)
    if os.path.isdir(path):
        raise InputError('"%s" is a folder. Give the path of a video or a photo in it: source:=%s.'
                         % (path, os.path.join(path, 'wall.mp4')))
    if not os.access(path, os.R_OK):
        raise InputError('The file "%s" may not be read. Allow it: chmod +r "%s".' % (path, path))
    if os.path.isfile(path) and not is_shown(path):
        raise InputError('"%s" is neither a photo nor a video. Give the path of one: '
                         'source:=/full/path/of/wall.mp4.' % path)
    return path


def is_shown(path):
    """Whether a file begins as a photo or a video does, or OpenCV can read it as one all the same."""
    with opened(path) as file:
        # OpenCV ends the process for a path that is not UTF-8, so it gets the descriptor.
        name = '/proc/self/fd/%d' % file.fileno()
        return is_video(file) or cv2.haveImageReader(name) or \
            cv2.VideoCapture(name, cv2.CAP_FFMPEG, TIMEOUTS).grab()


def fault_of_webcam(path):
    """Why the device at this path gives no images, in a sentence, and the remedy; None if it is a camera."""
    try:
        device = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    except FileNotFoundError:
        return 'There is no webcam %s.' % path[len(DEVICE):]
    except PermissionError:
        return 'The webcam %s may not be read by this user. Run: sudo usermod -a -G %s $USER, and log in ' \
            'again.' % (path, _group_of(path))
    except OSError as error:
        return 'The webcam %s cannot be opened (%s). Does another program use it? Is its plug loose?' \
            % (path, error.strerror)
    try:
        about = fcntl.ioctl(device, QUERY, bytes(QUERY_BYTES))
    except OSError:
        return '%s is not a camera.' % path
    finally:
        os.close(device)
    of_driver, of_device = struct.unpack_from('=II', about, CAPABILITIES_AT)
    if not (of_device if of_driver & HAS_DEVICE else of_driver) & CAPTURES:
        return '%s gives no images. Many webcams have a second device, for data.' % path
    return None


def _group_of(path):
    """The name of the group of users that may read a webcam."""
    try:
        group = grp.getgrgid(os.stat(path).st_gid).gr_name
    except (OSError, KeyError):
        return GROUP
    return GROUP if group == 'root' else group


def _other_sources():
    """A sentence that names the webcams that there are, or another source."""
    folder, start = os.path.split(DEVICE)
    names = [name[len(start):] for name in os.listdir(folder) if name.startswith(start)]
    webcams = [name for name in sorted(names, key=lambda name: (len(name), name))
               if name.isdigit() and fault_of_webcam(DEVICE + name) is None]
    if webcams:
        return 'There are: source:=%s.' % ', source:='.join(webcams)
    return 'No other webcam is connected. A video or a photo will do: source:=/full/path/of/wall.mp4.'


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
