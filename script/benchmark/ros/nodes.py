"""Nodes under a roscore: processor time, latency and memory."""
import os
import queue
import subprocess
import sys
import time
from itertools import cycle

import cv2
import numpy as np
import psutil
import rospy
from aruco_ar.base.progress import progress, tell
from aruco_node.messages.images import image_from_frame
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from benchmark import PACKAGE
from benchmark.simulated.drives import WIDE, drive

from .master import processor_seconds

FRAMES_PER_S = 15
COUNT = 300        # frames that count, after WARM_UP
WARM_UP = 30
SIZES = ((1280, 720), (640, 360))
WAIT_S = 30
MEMORY_FRAMES = 20000
EXERCISE = 'exercise5_6.py'
LOAD_HEAD = ('\nNodes, bgr8 at %d Hz: processor time a frame, and latency from stamp to receipt.\n'
             % FRAMES_PER_S)
MOST_FRAMES = 300  # of a clip


def commands(dictionary='DICT_6X6_250', ids=()):
    """{name: command} of the nodes under test, for tags of that dictionary; with ``ids`` those alone count."""
    of_ids = ['_ids:=[%s]' % ', '.join(map(str, ids))] if ids else []
    return {
        'bare relay': [sys.executable, '-m', 'benchmark.ros.relay_node'],
        "course's code": [sys.executable, '-m', 'benchmark.ros.course_node', dictionary, *map(str, ids)],
        EXERCISE: [sys.executable, os.path.join(PACKAGE, 'src', EXERCISE), 'exercise5_6/image:=result',
                   '_dictionary:=' + dictionary, *of_ids]}


class Node:
    """A node under test, and what it answers."""

    def __init__(self, command):
        self._answers = queue.Queue()
        self._publisher = rospy.Publisher('camera/rgb/image_raw', Image, queue_size=1)
        self._subscriber = rospy.Subscriber('result', Image, self._on_answer, buff_size=1 << 26)
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL)

    def _on_answer(self, message):
        self._answers.put((time.time(), message.header.stamp.to_sec()))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait()
        self._subscriber.unregister()
        self._publisher.unregister()

    def publish(self, frame):
        self._publisher.publish(image_from_frame(frame, Header(stamp=rospy.Time.from_sec(time.time()))))

    def answer(self, seconds=WAIT_S):
        """(time of receipt, stamp) of the next answer."""
        return self._answers.get(timeout=seconds)

    def forget_answers(self):
        """Drop those that nobody has taken."""
        while not self._answers.empty():
            self._answers.get()

    def connect(self, frame):
        """Wait until a frame is answered."""
        end = time.monotonic() + WAIT_S
        while time.monotonic() < end:
            self.publish(frame)
            try:
                return self.answer(0.2)
            except queue.Empty:
                continue
        raise RuntimeError('the node does not answer within %d s' % WAIT_S)

    def processor_seconds(self):
        return processor_seconds(self._process.pid)

    def resident_bytes(self):
        return psutil.Process(self._process.pid).memory_info().rss


def there_and_back(size):
    """Frames of a drive, and the same backward, so that they can go round."""
    frames = [frame.image for frame in drive(WIDE, 60, noise=5.0, light=0.3, size=size)]
    return frames + frames[::-1]


def load(name, command, frames):
    """(ms of processor time a frame, latencies in ms, answers) at FRAMES_PER_S."""
    pictures = cycle(frames)
    with Node(command) as node:
        node.connect(frames[0])
        rate = rospy.Rate(FRAMES_PER_S)
        for number in progress(range(WARM_UP + COUNT), name):
            if number == WARM_UP:
                node.forget_answers()
                began = node.processor_seconds()
            rate.sleep()
            node.publish(next(pictures))
        late = []
        try:
            while len(late) < COUNT:
                received, stamp = node.answer(0.5)
                late.append(1000 * (received - stamp))
        except queue.Empty:
            pass  # it dropped some
        return 1000 * (node.processor_seconds() - began) / COUNT, np.array(late)


def run_load():
    """Print processor time and latency of all nodes, on frames of a drive in simulation."""
    print(LOAD_HEAD)
    for size in SIZES:
        compare('%d x %d' % size, commands(), there_and_back(size))


def run_clips(clips):
    """The same on real clips, see real.Clip: at their own size, and at SIZES where they are larger."""
    print(LOAD_HEAD)
    for clip in clips:
        frames = clip.frames()[0][:MOST_FRAMES]
        own = frames[0].shape[1::-1]
        for size in [own, *(size for size in SIZES if size < own)]:
            resized = [cv2.resize(frame, size, interpolation=cv2.INTER_AREA) for frame in frames]
            compare('%s, %d x %d' % (os.path.basename(clip.path), *size), commands(clip.dictionary, clip.ids),
                    resized + resized[::-1])


def compare(name, nodes, frames):
    """Print processor time and latency of nodes, {name: command}, on these frames, and how they compare."""
    spent = {}
    for node, command in nodes.items():
        spent[node], late = load(node, command, frames)
        print('%-24s %-16s %6.2f ms   latency %6.2f ms, 99 %% below %6.2f ms   %d of %d frames' % (
            name, node, spent[node], np.median(late), np.percentile(late, 99), len(late), COUNT), flush=True)
    relay, course, ours = spent.values()
    print("%-24s %s takes 1/%.1f of the course's, %.1f times the relay's\n" % (
        '', EXERCISE, course / ours, ours / relay))


def run_memory():
    """Print the resident size of exercise5_6.py over many frames."""
    print('\nMemory of exercise5_6.py, 640 x 480:')
    frames = there_and_back((640, 480))
    pictures = cycle(frames)
    with Node(commands()[EXERCISE]) as node:
        node.connect(frames[0])
        first = None
        for number in progress(range(1, MEMORY_FRAMES + 1), 'memory'):
            node.publish(next(pictures))
            node.answer()
            if number in (MEMORY_FRAMES // 20, MEMORY_FRAMES // 2, MEMORY_FRAMES):
                size = node.resident_bytes()
                first = first or size
                tell('after %6d frames %6.1f MB, %+.2f %%' % (number, size / 1e6, 100 * (size / first - 1)))
