"""All image nodes, the poses, and the page with a camera, and the age of what they publish."""
import asyncio
import json
import struct
import subprocess
import sys
import threading
import time
from collections import deque
from contextlib import ExitStack, contextmanager, suppress

import numpy as np
import psutil
import rospy
from rig.page.server import free_port
from rig.processes.started import WAIT_S, program
from tornado.websocket import websocket_connect

EXERCISES = ['exercise5_%d' % number for number in range(2, 7)]
ALL = EXERCISES + ['tag_poses']
STAMP = struct.Struct('<III')  # a std_msgs/Header begins with seq, seconds, nanoseconds


class Ages:
    """The age of each message on a topic: the seconds from its stamp to its arrival."""

    def __init__(self, topic):
        self._received = deque()  # (time of arrival, age)
        # Deserializing the messages would distort the measurement.
        self._subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self._on_message, queue_size=None,
                                            tcp_nodelay=True)

    def _on_message(self, message):
        now = time.time()
        _, seconds, nanoseconds = STAMP.unpack_from(message._buff)
        self._received.append((now, now - seconds - nanoseconds / 1e9))

    def stop(self):
        """Unsubscribe. Returns (n, 2): the time of arrival and the age of each message."""
        self._subscriber.unregister()
        return np.array(self._received).reshape(-1, 2)


class Viewer:
    """A browser that shows all images of the page, each as soon as possible."""

    def __init__(self, port, topics):
        self._port, self._topics = port, topics
        self.shown, self.fault = 0, None
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        try:
            asyncio.run(self._view())
        except Exception as error:  # the caller reports it
            self.fault = repr(error)

    async def _connect(self):
        """The websocket of the page, or None if it does not listen yet."""
        with suppress(ConnectionRefusedError):
            return await websocket_connect('ws://localhost:%d/live' % self._port)

    async def _view(self):
        page, end = None, time.monotonic() + WAIT_S
        while page is None and time.monotonic() < end:  # its node may be ready a moment earlier
            page = await self._connect() or await asyncio.sleep(0.1)
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
    """Run a command while the block runs. Yields its psutil.Process."""
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        yield psutil.Process(running.pid)
    finally:
        running.terminate()
        running.wait(WAIT_S)


@contextmanager
def camera(width=640, height=480, rate=30):
    """Run a simulated camera while the block runs."""
    with process(sys.executable, '-m', 'torture.stress.camera_node', str(width), str(height), str(rate)):
        yield


@contextmanager
def nodes(names, page=True):
    """Run nodes while the block runs, and the page with a browser that shows them all.

    Yields ({name: Process}, Viewer or None).
    """
    port = free_port()
    with ExitStack() as stack:
        running = {name: stack.enter_context(process(sys.executable, program(name + '.py'),
                                                     *['_port:=%d' % port] * (name == 'page')))
                   for name in [*names, *['page'] * page]}
        for name in running:
            rospy.wait_for_service('/%s/set_parameters' % name, WAIT_S)
        yield running, Viewer(port, ['/%s/image' % name for name in names]) if page else None


def wait_for_all(topics, seconds=WAIT_S):
    """Wait until a message has arrived on each of the topics."""
    for topic in topics:
        rospy.wait_for_message(topic, rospy.AnyMsg, seconds)


def measure_ages(topics, seconds):
    """{topic: (n, 2)}: the ages of all messages that arrive within ``seconds``, see Ages."""
    listening = {topic: Ages(topic) for topic in topics}
    time.sleep(seconds)
    return {topic: each.stop() for topic, each in listening.items()}
