"""The page: what it costs, and how much later its frames come than a subscriber's."""
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
from master import processor_seconds
from nodes import WAIT_S
from rig.page.server import free_port
from sensor_msgs.msg import CompressedImage
from tornado.websocket import websocket_connect

TOPICS = ['/camera/rgb/image_raw'] + ['/exercise5_%d/image' % number for number in range(2, 7)]
WARM_UP_S, SECONDS = 3.0, 10.0


def run():
    """Print frames a second, latency, and the processor time of page.py."""
    port = free_port()
    launch = subprocess.Popen(['roslaunch', 'unit5', 'demo.launch', 'port:=%d' % port],
                              stdout=subprocess.DEVNULL)
    try:
        rospy.wait_for_service('/page/get_loggers', WAIT_S)
        pid = ServerProxy(rosgraph.Master('/bench').lookupNode('/page')).getPid('/bench')[2]
        direct, _ = measure(pid, subscribe)
        shown, spent = measure(pid, lambda seconds: asyncio.run(look(port, seconds)))
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait()
    print('\nPage: all six pictures, 640 x 480, 30 Hz, as JPEG; latency from stamp to receipt.\n')
    for name, late in (('rospy subscriber', direct), ('browser', shown)):
        print('%-17s %6.1f frames/s   latency %6.2f ms, 99 %% below %6.2f ms'
              % (name, len(late) / SECONDS, np.median(late), np.percentile(late, 99)))
    print('page.py takes %.2f ms of processor time a frame, %.0f %% of a core'
          % (1000 * spent / len(shown), 100 * spent / SECONDS))


def measure(pid, receive):
    """(latencies in ms, seconds of processor time) of SECONDS, by a function that receives for so long."""
    receive(WARM_UP_S)
    began = processor_seconds(pid)
    late = receive(SECONDS)
    return 1000 * np.array(late), processor_seconds(pid) - began


def subscribe(seconds):
    """Latencies, seconds, of all frames that a subscriber to all topics gets."""
    late = []

    def take(message):
        late.append(time.time() - message.header.stamp.to_sec())
    subscribers = [rospy.Subscriber(topic + '/compressed', CompressedImage, take, buff_size=1 << 24)
                   for topic in TOPICS]
    time.sleep(seconds)
    for subscriber in subscribers:
        subscriber.unregister()
    return list(late)


async def look(port, seconds):
    """Latencies, seconds, of all frames that the page's websocket gives, each taken at once."""
    page = await websocket_connect('ws://localhost:%d/live' % port)
    await page.write_message(json.dumps({'look': TOPICS}))
    late, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        message = await asyncio.wait_for(page.read_message(), WAIT_S)
        if isinstance(message, bytes):
            length, = struct.unpack('>I', message[:4])
            head = json.loads(message[4:4 + length])
            late.append(time.time() - head['stamp'])
            await page.write_message(json.dumps({'shown': head['topic']}))
    page.close()
    return late
