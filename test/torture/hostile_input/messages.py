"""Hostile messages for all nodes that subscribe to a camera, and their answers to good ones afterward."""
import threading
import time
import urllib.request
from collections import Counter
from itertools import count

import numpy as np
import psutil
import rospy
from aruco_ar.base.progress import progress
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import TRANSPORTS, compressed_from_frame, image_from_frame
from aruco_node.messages.wall_messages import camera_info
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from hostile.messages.camera_messages import Hostile
from hostile.messages.paced_publisher import STUCK_S, PacedPublisher
from rig.nodes.case import CAMERA, scene
from rig.nodes.master import Master, processor_seconds
from rig.nodes.topics import until
from rig.page.server import free_port
from rig.processes.started import node, stop_all
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header
from unit5.msg import TagArray, TagPoseArray

AMOUNT = 100000    # messages for every node, half of them raw, half compressed
WARM_UP = 5000     # messages before the memory is first measured
INFO_EVERY = 50    # messages: how often a hostile camera_info is sent
IDLE_S, IDLE_HZ = 10, 30
MAX_GROWTH, MAX_LINES, MAX_IDLE = 5, 20, 1  # %, lines, %
OUTPUTS = {**{'exercise5_%d' % number: {'image': Image, 'tags': TagArray} for number in range(2, 7)},
           'screen': {'image': Image},
           'tag_poses': {'image': Image, 'tags': TagArray, 'poses': TagPoseArray},
           'calibrate_live': {'image': Image}, 'camera_relay': {'image_raw': Image}}
OUTPUTS['exercise5_5']['mask'] = Image


def run(seconds, seed):
    """Send AMOUNT messages, or as many as time allows. Returns sentences about what was found."""
    found = []
    with Master():
        for transport in TRANSPORTS:
            with _Nodes(transport) as nodes:
                nodes.run(seconds and seconds / len(TRANSPORTS), seed)
            found += nodes.found
    return found


class _Nodes:
    """All nodes, with this process as their camera. ``found``: sentences about faults."""

    def __init__(self, transport):
        self._transport, self.found = transport, []
        suffix, _, _ = TRANSPORTS[transport]
        self._kind = CompressedImage if suffix else Image
        self._camera = PacedPublisher(CAMERA + suffix, self._kind)
        self._info = PacedPublisher(CAMERA.replace('image_raw', 'camera_info'), CameraInfo, latch=True)
        self._port = free_port()
        self._nodes = {}
        for name in [*OUTPUTS, 'page']:
            arguments = ['_port:=%d' % self._port] if name == 'page' else ['_image_transport:=' + transport]
            if name == 'screen':
                arguments += ['__name:=screen', '_picture:=topic:' + CAMERA + suffix]
            self._nodes[name] = node('exercise5_6.py' if name == 'screen' else name + '.py', *arguments)
        self._answers, self._wanted, self._changed = {}, None, threading.Condition()
        self._received, self._reports, self._asked = {}, Counter(), rospy.Time.now()
        self._diagnostics = rospy.Subscriber('/diagnostics', DiagnosticArray, self._on_diagnostics,
                                             queue_size=100)
        # With this subscriber, tag_poses listens to /tf, where its own poses are, too.
        self._subscribers = [rospy.Subscriber('/tag_poses/robot_pose', PoseWithCovarianceStamped)]
        self._subscribers += [rospy.Subscriber('/%s/%s' % (name, topic), kind, self._on_answer, (name, topic))
                             for name, topics in OUTPUTS.items() for topic, kind in topics.items()]

    def __enter__(self):
        self._nodes['page'].wait_for('The page is at')
        self._watching = True
        threading.Thread(target=self._view_page, daemon=True).start()
        until(lambda: self._camera.get_num_connections() == len(self._nodes))
        return self

    def __exit__(self, *_):
        self._watching = False
        stop_all(self._nodes.values())
        for each in (self._camera, self._info, self._diagnostics, *self._subscribers):
            each.unregister()

    def run(self, seconds, seed):
        hostile = Hostile(seed, [scene()])
        make = hostile.image if self._transport == 'raw' else hostile.compressed
        before = self._answers_to_good()
        sent = self._send(hostile, make, progress(range(WARM_UP), self._transport + ', warm-up'))
        for message in hostile.largest(self._kind):
            self._camera.publish(message)
        self._answers_to_good()
        sizes, least, spent = [self._sizes()], 0, 0.0
        for part in 0.5, 1:
            end, goal = time.monotonic() + part * (seconds or 0), int(part * AMOUNT / len(TRANSPORTS))
            while time.monotonic() < end if seconds else least < goal:
                at = time.monotonic()
                numbers = range(2000 if seconds else goal - least)
                sent += self._send(hostile, make, progress(numbers, self._transport))
                spent += time.monotonic() - at
                least = self._least_received()
            after = self._answers_to_good()
            sizes.append(self._sizes())
        idle = self._idle()
        print('%s: %d messages, %.0f per second\n' % (self._transport, sent, (sent - WARM_UP) / spent))
        print('%-12s %8s  %-5s  %-32s %5s  %-6s %5s' % (
            'node', 'received', 'alive', 'MB after warm-up, half, all', 'lines', 'answer', 'idle'))
        for name, process in self._nodes.items():
            self._judge(name, process, [size[name] for size in sizes],
                        [answer[name] for answer in (before, after)], idle[name])
        print('(Targets: the memory grows by at most %d %% in the second half; at most %d lines; the same\n'
              'answer to the next good frame; at most %d %% of a core at %d Hz while nobody subscribes.)\n'
              % (MAX_GROWTH, MAX_LINES, MAX_IDLE, IDLE_HZ))

    def _judge(self, name, process, sizes, answers, idle):
        alive, same = process.process.poll() is None, _same(*answers)
        grown = 100 * (sizes[-1] / sizes[-2] - 1) if alive else 0
        lines = len(process.lines)
        print('%-12s %8s  %-5s  %6.1f %6.1f %6.1f  %+5.1f %%    %5d  %-6s %3.1f %%' % (
            name, self._received.get(name, ''), 'yes' if alive else 'NO', *(size / 1e6 for size in sizes),
            grown, lines, 'same' if same else 'OTHER', idle))
        for bad, what in ((not alive, 'has ended:\n' + ''.join(process.lines[-20:])),
                          (not same, 'does not answer a good frame as before'),
                          (grown > MAX_GROWTH, 'has grown by %.1f %% in the second half' % grown),
                          (lines > MAX_LINES,
                           'has written %d lines:\n%s' % (lines, ''.join(process.lines[:50]))),
                          (any('fault of this node' in line or 'Traceback' in line for line in process.lines),
                           'has had a fault:\n' + ''.join(process.lines)[-3000:]),
                          (idle > MAX_IDLE, 'uses %.1f %% of a core while nobody subscribes' % idle)):
            if bad:
                self.found.append('%s (%s) %s' % (name, self._transport, what))

    def _send(self, hostile, make, numbers):
        """Publish a message for each number, once all nodes have received the one before.

        Returns how many were published.
        """
        for number in numbers:
            if number % INFO_EVERY == 0:
                self._info.publish(hostile.camera_info())
            self._camera.publish(make())
        return number + 1

    def _good_message(self, frame=None, stamp=None):
        frame = scene() if frame is None else frame
        make = compressed_from_frame if self._kind is CompressedImage else image_from_frame
        return make(frame, Header(stamp=stamp, frame_id='eye'))

    def _answers_to_good(self):
        """{node: {topic: message}}: the answers of all nodes to a good frame."""
        for _ in range(2):  # when a node reads the second one, it has taken in the first one
            self._info.publish(camera_info(Camera(), Header()))
        with self._changed:
            self._answers, self._wanted = {}, rospy.Time(1000, 2)
        # A frame of another size makes the nodes forget what they learned from hostile ones.
        for stamp, frame in enumerate([scene()[::8, ::8], scene(), scene()]):
            self._camera.publish(self._good_message(frame, rospy.Time(1000, stamp)))
        wanted = {(name, topic) for name, topics in OUTPUTS.items() for topic in topics}
        with self._changed:
            self._changed.wait_for(lambda: set(self._answers) == wanted, STUCK_S)
            answers = {name: {topic: self._answers.get((name, topic)) for topic in topics}
                       for name, topics in OUTPUTS.items()}
        address = 'http://localhost:%d/snapshot?topic=/exercise5_4/image' % self._port
        done = threading.Event()

        def feed():
            while not done.wait(0.1):
                self._camera.publish(self._good_message())
        threading.Thread(target=feed, daemon=True).start()
        try:
            with urllib.request.urlopen(address, timeout=STUCK_S) as answer:
                answers['page'] = {'snapshot': answer.read()}
        except OSError as error:
            answers['page'] = {'snapshot': error}
        done.set()
        return answers

    def _least_received(self):
        """The least number of frames that any node has received, once all that were sent are counted."""
        alive = [name for name in OUTPUTS if self._nodes[name].process.poll() is None]
        with self._changed:
            # The last frame has been read, but may be missing in one report; the next comes a second later.
            self._reports, self._asked = Counter(), rospy.Time.now()
            self._changed.wait_for(lambda: all(self._reports[name] > 1 for name in alive), STUCK_S)
            return min(self._received[name] for name in OUTPUTS)

    def _idle(self):
        """{node: % of a core that it uses while frames arrive and nobody subscribes to its output}."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._watching = False
        until(lambda: self._camera.publish(self._good_message()) or self._camera.get_num_connections() == 0)
        spent = {name: -self._seconds(name) for name in self._nodes}
        rate = rospy.Rate(IDLE_HZ)
        for _ in range(IDLE_S * IDLE_HZ):
            self._camera.publish(self._good_message())
            rate.sleep()
        return {name: 100 * (before + self._seconds(name)) / IDLE_S for name, before in spent.items()}

    def _seconds(self, name):
        if self._nodes[name].process.poll() is not None:
            return 0.0
        return processor_seconds(self._nodes[name].process.pid)

    def _sizes(self):
        """Resident bytes of each node."""
        return {name: psutil.Process(each.process.pid).memory_info().rss if each.process.poll() is None else 0
                for name, each in self._nodes.items()}

    def _view_page(self):
        """View the camera on the page, as a browser does."""
        for _ in count():
            with urllib.request.urlopen('http://localhost:%d/stream?topic=%s' % (self._port, CAMERA)) as stream:
                while self._watching and stream.read(1 << 12):
                    pass
            if not self._watching:
                return

    def _on_diagnostics(self, message):
        for status in message.status:
            name = status.name.split(':')[0]
            values = {item.key: item.value for item in status.values}
            if 'frames in' in values:
                with self._changed:
                    self._received[name] = int(values['frames in'])
                    self._reports[name] += message.header.stamp > self._asked
                    self._changed.notify_all()

    def _on_answer(self, message, place):
        if isinstance(message, TagPoseArray):
            for tag in message.tags:
                at = tag.pose.pose.position
                if not np.all(np.isfinite([at.x, at.y, at.z])):
                    self.found.append('tag_poses publishes a pose that is not a number')
        with self._changed:
            if message.header.stamp == self._wanted:
                self._answers[place] = message
                self._changed.notify_all()


def _same(before, after):
    """Whether the answers to the good frame are equal, pixel for pixel; for poses, to a millimeter."""
    def parts(message):
        if isinstance(message, TagPoseArray):
            return [[tag.id, np.round(tag.pose.pose.position.x, 3), np.round(tag.pose.pose.position.z, 3)]
                    for tag in message.tags]
        return getattr(message, 'tags', getattr(message, 'data', message))
    return None not in after.values() and all(parts(before[topic]) == parts(after[topic]) for topic in before)
