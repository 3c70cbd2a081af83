"""Bags annotated with one and with two workers: frames a second, and the memory that they take."""
import glob
import os
import re
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress

import psutil
import rosbag
import rospy
from aruco_ar.base.progress import tell
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import compressed_from_frame, image_from_frame
from aruco_node.messages.wall_messages import camera_info
from std_msgs.msg import Header

from benchmark import PACKAGE
from benchmark.simulated.drives import FRAMES_PER_S, LIVELY, drive

CAMERA = '/camera/rgb/'
ROUND = 20    # seconds of a drive, which is repeated
BEGIN_S = 1000.0
LOOK_S = 0.1  # at memory
RAW, JPEG = (image_from_frame, ''), (compressed_from_frame, '/compressed')
CASES = [  # how frames are recorded, seconds of the bag, of its pieces, workers
    (JPEG, 240, 60, 1), (JPEG, 240, 60, 2), (JPEG, 960, 60, 2), (RAW, 60, 15, 1), (RAW, 60, 15, 2)]


def run():
    """Print a table of CASES."""
    frames = [frame.image for frame in drive(LIVELY, ROUND * FRAMES_PER_S, noise=2.0)]
    print('\nBags of 640 x 480 at %d Hz through exercise 5.6, with poses' % FRAMES_PER_S)
    print('%-6s %8s %8s %10s %14s %12s %18s' % (
        'frames', 'seconds', 'workers', 'frames/s', 'x real time', 'efficiency', 'MB of a worker'))
    alone = {}
    with tempfile.TemporaryDirectory() as folder:
        for way, seconds, piece, workers in CASES:
            path = os.path.join(folder, '%s%d.bag' % ('jpeg' if way[1] else 'raw', seconds))
            if not os.path.exists(path):
                for other in glob.glob(os.path.join(folder, '*.bag')):
                    os.unlink(other)  # they are large
                record(path, frames, seconds, *way)
            with tempfile.TemporaryDirectory(dir=folder) as out:
                rate, memory = annotated(path, out, piece, workers)
            alone.setdefault(way, rate / workers)
            tell('%-6s %8d %8d %10.1f %14.1f %10.0f %% %18.0f' % (
                'JPEG' if way[1] else 'raw', seconds, workers, rate, rate / FRAMES_PER_S,
                100 * rate / workers / alone[way], memory / 1e6))


def record(path, frames, seconds, message_of, suffix):
    """Write a bag of those frames, over and over for so many seconds."""
    with rosbag.Bag(path, 'w') as bag:
        made = [message_of(frame, Header(frame_id='eye')) for frame in frames]
        for number in range(seconds * FRAMES_PER_S):
            message = made[number % len(made)]
            message.header.stamp = stamp = rospy.Time.from_sec(BEGIN_S + number / FRAMES_PER_S)
            bag.write(CAMERA + 'camera_info', camera_info(Camera(), message.header), stamp)
            bag.write(CAMERA + 'image_raw' + suffix, message, stamp)


def annotated(path, folder, piece, workers):
    """(frames a second, the most bytes of memory that a worker has had)."""
    with subprocess.Popen(
            [sys.executable, os.path.join(PACKAGE, 'src', 'annotate_bags.py'), path, '--out', folder,
             '--piece', str(piece), '--workers', str(workers)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        watch = _Watch(process.pid)
        said, wrong = process.communicate()
    watch.end()
    told = re.search(r': ([0-9.]+) a second', said)
    if process.returncode or not told:
        raise RuntimeError('annotate_bags says: %s%s' % (said, wrong))
    return float(told.group(1)), watch.most


class _Watch:
    """The most memory that any of the workers that a process has started has taken."""

    def __init__(self, pid):
        self.most, self._ended, self._parent = 0, threading.Event(), psutil.Process(pid)
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def end(self):
        self._ended.set()
        self._thread.join()

    def _look(self):
        while not self._ended.wait(LOOK_S):
            with suppress(psutil.NoSuchProcess):
                for child in self._parent.children(recursive=True):
                    self.most = max(self.most, child.memory_info().rss)
