"""All image nodes, the poses and the page before a camera, and how old what they publish is."""
import asyncio
import json
import os
import struct
import subprocess
import sys
import threading
import time
from collections import deque
from contextlib import ExitStack, contextmanager

import numpy as np
import psutil
import rospy
from rig.page.server import free_port
from rig.processes.started import WAIT_S
from tornado.websocket import websocket_connect

HERE = os.path.dirname(os.path.abspath(__file__))
EXERCISES = ['exercise5_%d' % number for number in range(2, 7)]
ALL = EXERCISES + ['tag_poses']
STAMP = struct.Struct('<III')  # a std_msgs/Header begins with seq, seconds, nanoseconds


class Ages:
    """How old what comes on a topic is, seconds since its stamp, when it comes."""

    def __init__(self, topic):
        self.taken = deque()  # (when, age)
        # As it is: to make messages of it would take the time that is measured.
        self._subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self._take, queue_size=None, tcp_nodelay=True)

    def _take(self, message):
        now = time.time()
        _, seconds, nanoseconds = STAMP.unpack_from(message._buff)
        self.taken.append((now, now - seconds - nanoseconds / 1e9))

    def stop(self):
        """Leave the topic; (n, 2): when what came has come, and how old it was then."""
        self._subscriber.unregister()
        return np.array(self.taken).reshape(-1, 2)


class Viewer:
    """A browser that shows all pictures of the page, each as soon as it can."""

    def __init__(self, port, topics):
        self._port, self._topics = port, topics
        self.shown, self.fault = 0, None
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        try:
            asyncio.run(self._look())
        except Exception as error:  # told by who looks at the figures
            self.fault = repr(error)

    async def _look(self):
        page = await websocket_connect('ws://localhost:%d/live' % self._port)
        await page.write_message(json.dumps({'look': self._topics}))
        while True:
            message = await page.read_message()
            if message is None:
                raise ConnectionError('the page has closed the websocket')
            if isinstance(message, bytes):
                length, = struct.unpack('>I', message[:4])
                self.shown += 1
                await page.write_message(json.dumps({'shown': json.loads(message[4:4 + length])['topic']}))


@contextmanager
def process(*command):
    """A process while the block runs; a psutil.Process."""
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        yield psutil.Process(running.pid)
    finally:
        running.terminate()
        running.wait(WAIT_S)


@contextmanager
def camera(width=640, height=480, rate=30):
    """A camera while the block runs."""
    with process(sys.executable, os.path.join(HERE, 'camera_node.py'), str(width), str(height), str(rate)):
        yield


@contextmanager
def nodes(names, page=True):
    """Nodes while the block runs, and the page with a browser that shows them all.

    ({name: Process}, Viewer or None).
    """
    source = os.path.join(HERE, '..', '..', 'src')
    port = free_port()
    with ExitStack() as stack:
        running = {name: stack.enter_context(process(sys.executable, os.path.join(source, name + '.py'),
                                                     *['_port:=%d' % port] * (name == 'page')))
                   for name in [*names, *['page'] * page]}
        for name in running:
            rospy.wait_for_service('/%s/set_parameters' % name, WAIT_S)
        yield running, Viewer(port, ['/%s/image' % name for name in names]) if page else None


def first_of(topics, seconds=WAIT_S):
    """Wait until something has come on each of the topics."""
    for topic in topics:
        rospy.wait_for_message(topic, rospy.AnyMsg, seconds)


def ages(topics, seconds):
    """{topic: (n, 2)} of what has come within so many seconds: see Ages."""
    listening = {topic: Ages(topic) for topic in topics}
    time.sleep(seconds)
    return {topic: each.stop() for topic, each in listening.items()}
