"""The annotation of bags by one and by two workers: frames per second, and memory."""
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
from rig.accuracy.drives import FRAMES_PER_S, LIVELY, drive
from rig.processes.started import program
from std_msgs.msg import Header

CAMERA = '/camera/rgb/'
LOOP_S = 20   # length of the drive, which is repeated
BEGIN_S = 1000.0
SAMPLE_S = 0.1  # between two readings of the memory
RAW, JPEG = (image_from_frame, ''), (compressed_from_frame, '/compressed')
CASES = [  # how frames are recorded, seconds of the bag and of its pieces, number of workers
    (JPEG, 240, 60, 1), (JPEG, 240, 60, 2), (JPEG, 960, 60, 2), (RAW, 60, 15, 1), (RAW, 60, 15, 2)]


def run():
    """Measure all CASES, and print the table."""
    frames = [frame.image for frame in drive(LIVELY, LOOP_S * FRAMES_PER_S, noise=2.0)]
    print('\nBags of 640 x 480 at %d Hz, annotated by exercise 5.6, with poses' % FRAMES_PER_S)
    print('%-6s %8s %8s %10s %14s %12s %18s' % (
        'frames', 'seconds', 'workers', 'frames/s', 'x real time', 'efficiency', 'MB per worker'))
    alone = {}
    with tempfile.TemporaryDirectory() as folder:
        for encoding, seconds, piece, workers in CASES:
            path = os.path.join(folder, '%s%d.bag' % ('jpeg' if encoding[1] else 'raw', seconds))
            if not os.path.exists(path):
                for other in glob.glob(os.path.join(folder, '*.bag')):
                    os.unlink(other)  # they are large
                record(path, frames, seconds, *encoding)
            with tempfile.TemporaryDirectory(dir=folder) as out:
                rate, memory = annotate(path, out, piece, workers)
            alone.setdefault(encoding, rate / workers)
            tell('%-6s %8d %8d %10.1f %14.1f %10.0f %% %18.0f' % (
                'JPEG' if encoding[1] else 'raw', seconds, workers, rate, rate / FRAMES_PER_S,
                100 * rate / workers / alone[encoding], memory / 1e6))


def record(path, frames, seconds, message_of, suffix):
    """Write a bag that repeats the frames for ``seconds``."""
    with rosbag.Bag(path, 'w') as bag:
        messages = [message_of(frame, Header(frame_id='eye')) for frame in frames]
        for number in range(seconds * FRAMES_PER_S):
            message = messages[number % len(messages)]
            message.header.stamp = stamp = rospy.Time.from_sec(BEGIN_S + number / FRAMES_PER_S)
            bag.write(CAMERA + 'camera_info', camera_info(Camera(), message.header), stamp)
            bag.write(CAMERA + 'image_raw' + suffix, message, stamp)


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
