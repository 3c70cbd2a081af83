"""The nodes: processor time, latency, and memory."""
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
from rig.accuracy.drives import WIDE, drive
from rig.nodes.master import processor_seconds
from rig.processes.started import program
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from . import steps

FRAMES_PER_S = 15
COUNT = 300        # measured frames, after WARM_UP
WARM_UP = 30
SIZES = ((1280, 720), (640, 360))
WAIT_S = 30
MEMORY_FRAMES = 20000
EXERCISE = 'exercise5_6.py'
LOAD_HEAD = ('\nNodes, bgr8 at %d Hz: processor time per frame, and latency from stamp to receipt.\n'
             % FRAMES_PER_S)
MAX_CLIP_FRAMES = 300


def commands(dictionary='DICT_6X6_250', ids=()):
    """{name: command} of the nodes under test. ``ids``: the tags that span the area, if there are others."""
    ids_args = ['_ids:=[%s]' % ', '.join(map(str, ids))] if ids else []
    return {
        'bare relay': [sys.executable, '-m', 'benchmark.ros.relay_node'],
        "course's code": [sys.executable, '-m', 'benchmark.ros.course_node', dictionary, *map(str, ids)],
        EXERCISE: [sys.executable, program(EXERCISE), 'exercise5_6/image:=result',
                   '_dictionary:=' + dictionary, *ids_args]}


class Node:
    """A node under test while the block runs, and its answers to the frames that are published."""

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
        """Drop the answers that were not read."""
        while not self._answers.empty():
            self._answers.get()

    def connect(self, frame):
        """Publish a frame until the node answers."""
        end = time.monotonic() + WAIT_S
        while time.monotonic() < end:
            self.publish(frame)
            try:
                return self.answer(0.2)
            except queue.Empty:
                continue
        raise RuntimeError('the node did not answer within %d s' % WAIT_S)

    def processor_seconds(self):
        return processor_seconds(self._process.pid)

    def resident_bytes(self):
        return psutil.Process(self._process.pid).memory_info().rss


def there_and_back(size):
    """The frames of a drive, and the same frames backward, so that they can be repeated."""
    frames = [frame.image for frame in drive(WIDE, 60, noise=5.0, light=0.3, size=size)]
    return frames + frames[::-1]


def load(name, command, frames):
    """Publish frames at FRAMES_PER_S: (ms of processor time per frame, latencies in ms)."""
    endless = cycle(frames)
    with Node(command) as node:
        node.connect(frames[0])
        rate = rospy.Rate(FRAMES_PER_S)
        for number in progress(range(WARM_UP + COUNT), name):
            if number == WARM_UP:
                node.forget_answers()
                began = node.processor_seconds()
            rate.sleep()
            node.publish(next(endless))
        latencies = []
        try:
            while len(latencies) < COUNT:
                received, stamp = node.answer(0.5)
                latencies.append(1000 * (received - stamp))
        except queue.Empty:
            pass  # it has dropped some frames
        return 1000 * (node.processor_seconds() - began) / COUNT, np.array(latencies)


def run_load():
    """Print processor time and latency of all nodes, on the frames of a simulated drive."""
    print(LOAD_HEAD)
    for size in SIZES:
        name, frames = '%d x %d' % size, there_and_back(size)
        compare(name, commands(), frames)
        steps.run(name, frames, FRAMES_PER_S, 'DICT_6X6_250')


def run_clips(clips):
    """Print the same for real clips (see clips.Clip): at their own size, and at the smaller ones of SIZES."""
    print(LOAD_HEAD)
    for clip in clips:
        frames = clip.frames()[0][:MAX_CLIP_FRAMES]
        own = frames[0].shape[1::-1]
        for size in [own, *(size for size in SIZES if size < own)]:
            resized = [cv2.resize(frame, size, interpolation=cv2.INTER_AREA) for frame in frames]
            name, resized = '%s, %d x %d' % (os.path.basename(clip.path), *size), resized + resized[::-1]
            compare(name, commands(clip.dictionary, clip.ids), resized)
            steps.run(name, resized, FRAMES_PER_S, clip.dictionary, clip.ids)


def compare(name, nodes, frames):
    """Print processor time and latency of nodes, {name: command}, on these frames, and their ratios."""
    spent = {}
    for node, command in nodes.items():
        spent[node], latencies = load(node, command, frames)
        print('%-24s %-16s %6.2f ms   latency %6.2f ms, 99th percentile %6.2f ms   %d of %d frames' % (
            name, node, spent[node], np.median(latencies), np.percentile(latencies, 99), len(latencies), COUNT),
            flush=True)
    relay, course, ours = spent.values()
    print("%-24s %s takes 1/%.1f of the course's, %.1f times the relay's\n" % (
        '', EXERCISE, course / ours, ours / relay))


def run_memory():
    """Print how the resident size of exercise5_6.py changes over many frames."""
    print('\nMemory of exercise5_6.py, 640 x 480:')
    frames = there_and_back((640, 480))
    endless = cycle(frames)
    with Node(commands()[EXERCISE]) as node:
        node.connect(frames[0])
        first = None
        for number in progress(range(1, MEMORY_FRAMES + 1), 'memory'):
            node.publish(next(endless))
            node.answer()
            if number in (MEMORY_FRAMES // 20, MEMORY_FRAMES // 2, MEMORY_FRAMES):
                size = node.resident_bytes()
                first = first or size
                tell('after %6d frames %6.1f MB, %+.2f %%' % (number, size / 1e6, 100 * (size / first - 1)))
