"""The annotation of bags by one and by two workers: frames per second, and memory.

These depend on the machine, and on what else it does. So just before, a plain loop copies the first frames of
the same bag: it decodes, encodes and writes each of them. Another such loop paints them with the course's code.
"""
import glob
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from itertools import islice

import cv2
import psutil
import rosbag
import rospy
from aruco_ar import load_picture
from aruco_ar.base.progress import tell
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import TRANSPORTS, compressed_from_frame, image_from_frame
from aruco_node.messages.wall_messages import camera_info
from rig import PACKAGE
from rig.accuracy.drives import FRAMES_PER_S, LIVELY, drive
from rig.processes.started import program
from std_msgs.msg import Header

from benchmark.course import Course

CAMERA = '/camera/rgb/'
LOOP_S = 20   # length of the drive, which is repeated
BEGIN_S = 1000.0
SAMPLE_S = 0.1  # between two readings of the memory
PLAIN_FRAMES = 600  # that the plain loops take
MESSAGE_OF = {'compressed': compressed_from_frame, 'raw': image_from_frame}
CASES = [  # how frames are recorded, seconds of the bag and of its pieces, number of workers
    ('compressed', 240, 60, 1), ('compressed', 240, 60, 2), ('compressed', 960, 60, 2), ('raw', 60, 15, 1),
    ('raw', 60, 15, 2)]


def run():
    """Measure all CASES, and print the table."""
    frames = [frame.image for frame in drive(LIVELY, LOOP_S * FRAMES_PER_S, noise=2.0)]
    print('\nBags of 640 x 480 at %d Hz, annotated by exercise 5.6, with poses' % FRAMES_PER_S)
    print('A copy is a plain loop: decode, encode and write. The course: the same, painting by its code.')
    print('%-10s %8s %8s %10s %14s %12s %15s %18s %15s' % (
        'frames', 'seconds', 'workers', 'frames/s', 'x real time', 'efficiency', 'MB per worker',
        'ours / a copy', 'course / a copy'))
    alone = {}
    course = Course('DICT_6X6_250', load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg')))
    with tempfile.TemporaryDirectory() as folder:
        for transport, seconds, piece, workers in CASES:
            path = os.path.join(folder, '%s%d.bag' % (transport, seconds))
            if not os.path.exists(path):
                for other in glob.glob(os.path.join(folder, '*.bag')):
                    os.unlink(other)  # they are large
                record(path, frames, seconds, transport)
            copy = plain_rate(path, folder, transport, lambda frame: frame)
            painted = plain_rate(path, folder, transport, lambda frame: course.paint(frame)[0])
            with tempfile.TemporaryDirectory(dir=folder) as out:
                rate, memory = annotate(path, out, piece, workers)
            alone.setdefault(transport, rate / workers)
            tell('%-10s %8d %8d %10.1f %14.1f %10.0f %% %15.0f %18.1f %15.1f' % (
                transport, seconds, workers, rate, rate / FRAMES_PER_S, 100 * rate / workers / alone[transport],
                memory / 1e6, copy * workers / rate, copy / painted))


def record(path, frames, seconds, transport):
    """Write a bag that repeats the frames for ``seconds``."""
    with rosbag.Bag(path, 'w') as bag:
        messages = [MESSAGE_OF[transport](frame, Header(frame_id='eye')) for frame in frames]
        for number in range(seconds * FRAMES_PER_S):
            message = messages[number % len(messages)]
            message.header.stamp = stamp = rospy.Time.from_sec(BEGIN_S + number / FRAMES_PER_S)
            bag.write(CAMERA + 'camera_info', camera_info(Camera(), message.header), stamp)
            bag.write(_topic(transport), message, stamp)


def _topic(transport):
    return CAMERA + 'image_raw' + TRANSPORTS[transport][0]


def plain_rate(path, folder, transport, paint):
    """The frames per second of a loop that decodes the first PLAIN_FRAMES of a bag, paints, encodes and writes.

    ``paint``: a function that turns a frame into what is encoded.
    """
    threads, decode = cv2.getNumThreads(), TRANSPORTS[transport][2]()
    cv2.setNumThreads(1)  # as in a worker
    try:
        with rosbag.Bag(path) as bag, rosbag.Bag(os.path.join(folder, 'plain.bag'), 'w') as out:
            began = time.process_time()
            for _, message, stamp in islice(bag.read_messages([_topic(transport)]), PLAIN_FRAMES):
                out.write('/painted/compressed', compressed_from_frame(paint(decode(message)), message.header),
                          stamp)
            return PLAIN_FRAMES / (time.process_time() - began)
    finally:
        cv2.setNumThreads(threads)


def annotate(path, folder, piece, workers):
    """Annotate a bag. Returns the frames per second, and the bytes of memory that a worker used at most."""
    with subprocess.Popen(
            [sys.executable, program('annotate_bags.py'), path, '--out', folder,
             '--piece', str(piece), '--workers', str(workers)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        watch = _MemoryWatch(process.pid)
        output, errors = process.communicate()
    watch.end()
    rate = re.search(r': ([0-9.]+) a second', output)
    if process.returncode or not rate:
        raise RuntimeError('annotate_bags failed: %s%s' % (output, errors))
    return float(rate.group(1)), watch.peak


class _MemoryWatch:
    """Records the peak memory of the workers that a process has started."""

    def __init__(self, pid):
        self.peak, self._ended, self._parent = 0, threading.Event(), psutil.Process(pid)
        self._thread = threading.Thread(target=self._sample, daemon=True)
        self._thread.start()

    def end(self):
        self._ended.set()
        self._thread.join()

    def _sample(self):
        while not self._ended.wait(SAMPLE_S):
            with suppress(psutil.NoSuchProcess):
                for child in self._parent.children(recursive=True):
                    self.peak = max(self.peak, child.memory_info().rss)
