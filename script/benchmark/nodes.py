"""Nodes under a roscore: processor time, latency and memory."""
import os
import queue
import subprocess
import sys
import time
from itertools import cycle

import numpy as np
import psutil
import rospy
from aruco_ar.progress import progress, tell
from aruco_node.messages import image_from_frame
from drives import WIDE, drive
from master import processor_seconds
from sensor_msgs.msg import Image
from std_msgs.msg import Header

HERE = os.path.dirname(os.path.abspath(__file__))
FRAMES_PER_S = 15
COUNT = 300        # frames that count, after WARM_UP
WARM_UP = 30
SIZES = ((1280, 720), (640, 360))
WAIT_S = 30
MEMORY_FRAMES = 20000
NODES = {
    'bare relay': [sys.executable, os.path.join(HERE, 'relay_node.py')],
    "course's code": [sys.executable, os.path.join(HERE, 'course_node.py')],
    'exercise5_6.py': [sys.executable, os.path.join(HERE, '..', '..', 'src', 'exercise5_6.py'),
                       'exercise5_6/image:=result'],
}


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
    """Print processor time and latency of all nodes."""
    print('\nNodes, bgr8 at %d Hz: processor time a frame, and latency from stamp to receipt.\n' % FRAMES_PER_S)
    for size in SIZES:
        frames = there_and_back(size)
        spent = {}
        for name, command in NODES.items():
            spent[name], late = load(name, command, frames)
            print('%-12s %-16s %6.2f ms   latency %6.2f ms, 99 %% below %6.2f ms   %d of %d frames' % (
                '%d x %d' % size, name, spent[name], np.median(late), np.percentile(late, 99), len(late),
                COUNT), flush=True)
        relay, course, ours = (spent[name] for name in NODES)
        print("%-12s exercise5_6.py takes 1/%.1f of the course's, %.1f times the relay's (at most 1/5, 3)\n"
              % ('', course / ours, ours / relay))


def run_memory():
    """Print the resident size of exercise5_6.py over many frames."""
    print('\nMemory of exercise5_6.py, 640 x 480:')
    frames = there_and_back((640, 480))
    pictures = cycle(frames)
    with Node(NODES['exercise5_6.py']) as node:
        node.connect(frames[0])
        first = None
        for number in progress(range(1, MEMORY_FRAMES + 1), 'memory'):
            node.publish(next(pictures))
            node.answer()
            if number in (MEMORY_FRAMES // 20, MEMORY_FRAMES // 2, MEMORY_FRAMES):
                size = node.resident_bytes()
                first = first or size
                tell('after %6d frames %6.1f MB, %+.2f %%' % (number, size / 1e6, 100 * (size / first - 1)))
