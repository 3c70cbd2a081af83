"""The page: its processor time, and its latency compared with that of a subscriber."""
import asyncio
import json
import signal
import struct
import subprocess
import time
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
from rig.nodes.master import processor_seconds
from rig.page.server import free_port
from sensor_msgs.msg import CompressedImage
from tornado.websocket import websocket_connect

from .nodes import WAIT_S

TOPICS = ['/camera/rgb/image_raw'] + ['/exercise5_%d/image' % number for number in range(2, 7)]
WARM_UP_S, SECONDS = 3.0, 10.0


def run():
    """Print the frames per second, the latency, and the processor time of page.py."""
    port = free_port()
    launch = subprocess.Popen(['roslaunch', 'unit5', 'demo.launch', 'port:=%d' % port],
                              stdout=subprocess.DEVNULL)
    try:
        rospy.wait_for_service('/page/get_loggers', WAIT_S)
        pid = ServerProxy(rosgraph.Master('/bench').lookupNode('/page')).getPid('/bench')[2]
        direct, _ = measure(pid, subscribe)
        shown, spent = measure(pid, lambda seconds: asyncio.run(view(port, seconds)))
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait()
    print('\nPage: all six images at 640 x 480 and 30 Hz, as JPEG. The latency is from stamp to receipt.\n')
    for name, latencies in (('rospy subscriber', direct), ('browser', shown)):
        print('%-17s %6.1f frames/s   latency %6.2f ms, 99th percentile %6.2f ms'
              % (name, len(latencies) / SECONDS, np.median(latencies), np.percentile(latencies, 99)))
    print('page.py takes %.2f ms of processor time per frame, %.0f %% of a core'
          % (1000 * spent / len(shown), 100 * spent / SECONDS))


def measure(pid, receive):
    """Receive frames for SECONDS: (latencies in ms, seconds of processor time).

    ``receive``: a function that receives for a number of seconds, and returns the latencies in seconds.
    """
    receive(WARM_UP_S)
    began = processor_seconds(pid)
    latencies = receive(SECONDS)
    return 1000 * np.array(latencies), processor_seconds(pid) - began


def subscribe(seconds):
    """Subscribe to all topics for that time. Returns the latencies of all frames in seconds."""
    latencies = []

    def on_message(message):
        latencies.append(time.time() - message.header.stamp.to_sec())
    subscribers = [rospy.Subscriber(topic + '/compressed', CompressedImage, on_message, buff_size=1 << 24)
                   for topic in TOPICS]
    time.sleep(seconds)
    for subscriber in subscribers:
        subscriber.unregister()
    return list(latencies)


async def view(port, seconds):
    """View all topics by the page's websocket, like a browser that shows each frame at once.

    Returns the latencies of all frames in seconds.
    """
    page = await websocket_connect('ws://localhost:%d/live' % port)
    await page.write_message(json.dumps({'look': TOPICS}))
    latencies, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        message = await asyncio.wait_for(page.read_message(), WAIT_S)
        if isinstance(message, bytes):
            length, = struct.unpack('>I', message[:4])
            head = json.loads(message[4:4 + length])
            latencies.append(time.time() - head['stamp'])
            await page.write_message(json.dumps({'shown': head['topic']}))
    page.close()
    return latencies
