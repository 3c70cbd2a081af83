"""Shows frames to a running node, one after the other, and collects what it publishes."""
from __future__ import annotations

import os
import tempfile
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass, field
from statistics import median
from typing import NamedTuple

import cv2
import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.simulation.robot import Camera
from aruco_course.black_box import sentences
from aruco_course.black_box.matching import Background, has_exchanged_colors
from aruco_course.black_box.running import Program
from aruco_course.check import Fault, Shown
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from aruco_node.messages.camera_info import info_topics
from aruco_node.messages.images import ENCODING, ImageDecoder, image_from_frame
from aruco_node.messages.wall_messages import camera_info
from aruco_node.ros_internals.subscribers import BUFFER_BYTES, tolerant

from .graph import IMAGE, Graph

# Right nodes are faster than all of these, also on a machine that is slow and busy: what ends a wait is an
# event, or that the node's processes do nothing.
NODE_S = 15.0     # a program that waits for this time, and is no ROS node yet, will not become one
IDLE_S = 2.0      # a node that waits for this time has done what it does
LONGEST_S = 90.0  # the longest wait for a node that works without end
LOOK_S = 0.1      # from one look at the node to the next
AGAIN_S = 0.5     # a frame is shown again after this time, as nodes may drop frames
MOST_TIMES = 6    # a frame is shown so often before a node is said to ignore it
APART_NS = 2 * 10**9  # from the stamps of a view to those of the next one, besides the time that has passed
STRANGE = 10      # so many images that are like another frame are enough: then one of them is judged
OF_BRIDGE = '8UC1', '8UC3'  # what cv_bridge itself writes if it is given no encoding
GRAY = 'mono8', 'mono16', '8uc1', '16uc1', 'mono', 'gray', 'grey'
FRAME_ID = 'camera_rgb_optical_frame'


class Topics(NamedTuple):
    """The topics of the node under test.

    ``outputs``: {the name of an output of the check: its topic}; the frame with what was drawn is the last.
    """

    camera: str
    outputs: dict


@dataclass
class Collected:
    """What a node made of the frames, until a fault. ``seconds``: how long it took for each of them."""

    shown: list = field(default_factory=list)
    seconds: list = field(default_factory=list)
    baseline_seconds: float = 0.0
    remarks: list = field(default_factory=list)
    fault: Fault | None = None
    printed: str = ''


class _Found(Exception):
    """A Fault, its argument, has been found."""


class _Output:
    """What arrives on a topic: the message, and when, newest last."""

    def __init__(self, topic, changed):
        self._arrived, self._changed = [], changed
        self.decode = ImageDecoder()
        self._subscriber = rospy.Subscriber(topic, tolerant(Image), self._take, queue_size=100,
                                            buff_size=BUFFER_BYTES, tcp_nodelay=True)

    def _take(self, message):
        with self._changed:
            self._arrived.append((message, time.monotonic()))
            self._changed.notify_all()

    def __len__(self):
        return len(self._arrived)

    def taken(self):
        """What has arrived, and is not taken a second time."""
        taken, self._arrived = self._arrived, []
        return taken

    def is_connected(self):
        return self._subscriber.get_num_connections() > 0

    def close(self):
        self._subscriber.unregister()


class BlackBox:
    """A node's program that runs in front of a camera, which is this object."""

    def __init__(self, path, topics, views, is_shared=False):
        """``path``: the program. ``topics``: Topics. ``views``: list of View.

        ``is_shared``: whether the ROS master stays, so that the node must sign off from it.
        """
        self._topics, self._views = topics, views
        self._changed = threading.Condition()
        self._background = Background([view.frame for view in views])
        self._stamps = {}  # {stamp: number of the view}
        self._known = {}   # see Graph
        self._path, self._is_shared = path, is_shared
        self.collected = Collected()

    def run(self):
        """Show all frames to the node; returns Collected. Raises InputError if ROS does not work."""
        self.collected.baseline_seconds = _baseline_seconds(self._views)
        try:
            with tempfile.TemporaryDirectory() as folder, self._connected(), self._started(folder):
                self._wait_for_subscription()
                is_early = self._is_advertised()
                for number, view in enumerate(self._views, 1):
                    images, seconds = self._answer_to(number, view)
                    self.collected.shown.append(Shown(number, view, images))
                    self.collected.seconds.append(seconds)
                self._finish(is_early)
        except _Found as found:
            self.collected.fault, = found.args
        return self.collected

    @contextmanager
    def _connected(self):
        camera, info = self._topics.camera, info_topics(self._topics.camera)[0]
        self._camera = rospy.Publisher(camera, Image, queue_size=10, tcp_nodelay=True)
        self._info = rospy.Publisher(info, CameraInfo, queue_size=10)
        self._outputs = {name: _Output(topic, self._changed) for name, topic in self._topics.outputs.items()}
        try:
            yield
        finally:
            for each in self._outputs.values():
                each.close()
            self._camera.unregister()
            self._info.unregister()

    @contextmanager
    def _started(self, folder):
        environment = {name: value for name, value in os.environ.items()
                       if name not in ('DISPLAY', 'WAYLAND_DISPLAY')}  # a robot has no screen
        environment.update(ROS_LOG_DIR=folder, PYTHONUNBUFFERED='1', PYTHONFAULTHANDLER='1')
        try:
            self._program = Program([self._path], environment, folder, self._changed)
        except OSError as error:
            raise _Found(sentences.not_startable(self._path, error)) from None
        try:
            yield
        finally:
            self.collected.printed = self._program.printed
            self._program.stop(politely=self._is_shared)

    def _graph(self):
        return Graph(self._program.group, self._known)

    def _check_running(self):
        """Raise _Found if the program has ended."""
        if self._program.code is not None:
            raise _Found(sentences.ended(self._program))

    def _sleep(self, seconds, is_so=lambda: False):
        """Wait until something is so, the program ends, or the time is over."""
        with self._changed:
            self._changed.wait_for(lambda: is_so() or self._program.code is not None, seconds)

    def _wait_for_subscription(self):
        end = time.monotonic() + LONGEST_S
        while True:
            self._check_running()
            graph = self._graph()
            if graph.others(self._topics.camera):
                raise _Found(sentences.other_cameras(self._topics.camera, graph.others(self._topics.camera)))
            if graph.subscribers(self._topics.camera):
                self._wait_for(self._camera.get_num_connections)  # frames that are published earlier are lost
                return
            if self._program.is_idle(IDLE_S if graph.own else NODE_S) or time.monotonic() > end:
                raise _Found(sentences.raised(self._program) or (
                    sentences.no_subscription(self._topics.camera, graph.images(subscribed=True)) if graph.own
                    else sentences.no_node()))
            self._sleep(LOOK_S)

    def _is_advertised(self):
        """Whether the node publishes the topics before the first frame, as soon as it has started."""
        end = time.monotonic() + LONGEST_S
        while time.monotonic() < end:
            self._check_running()
            graph = self._graph()
            if all(graph.publishers(topic) for topic in self._topics.outputs.values()):
                self._check_kinds(graph)
                for output in self._outputs.values():
                    self._wait_for(output.is_connected)
                return True
            if self._program.is_idle(IDLE_S):
                if graph.images():
                    self._check_kinds(graph)
                return False
            self._sleep(LOOK_S)
        return False

    def _wait_for(self, is_so):
        """Wait until something is so, which depends on the node and on ROS."""
        end = time.monotonic() + LONGEST_S
        while not is_so() and time.monotonic() < end:
            self._check_running()
            self._sleep(LOOK_S / 10)

    def _check_kinds(self, graph):
        """Raise _Found if the node publishes images, but on other topics or with another type."""
        for name, topic in self._topics.outputs.items():
            kind = graph.kind(topic) if graph.publishers(topic) else ''
            if kind != IMAGE:
                raise _Found(sentences.no_topic(topic, name, kind, graph.images()))

    def _answer_to(self, number, view):
        """(images, seconds) that the node makes of a view."""
        typical = median(self.collected.seconds or [0])
        answer, begin, before = _Answer(number, list(self._outputs)), time.monotonic(), self._program.count
        for _ in range(MOST_TIMES):
            self._show(number, view)
            answer.on_shown()
            if self._is_answered(answer, time.monotonic() + max(AGAIN_S, 3 * typical)):
                return tuple(answer.images.values()), answer.arrived - begin
            raised = self._program.count > before and sentences.raised(self._program)
            if raised:
                raise _Found(raised)
        while not self._program.is_idle(IDLE_S):
            if self._is_answered(answer, time.monotonic() + LOOK_S):
                return tuple(answer.images.values()), answer.arrived - begin
            if time.monotonic() > begin + LONGEST_S:
                raise _Found(sentences.hangs(self._program.line_at_work(), number))
        self._check_kinds(self._graph())
        raise _Found(sentences.silent(self._topics.outputs[answer.missing()[0]], number))

    def _is_answered(self, answer, end):
        """Whether the whole answer comes before a moment."""
        while time.monotonic() < end and not answer.is_whole():
            self._sleep(end - time.monotonic(), self._has_arrived)
            for name, output in self._outputs.items():
                for message, when in output.taken():
                    self._take(answer, name, output, message, when)
            self._check_running()
        return answer.is_whole()

    def _has_arrived(self):
        return any(map(len, self._outputs.values()))

    def _show(self, number, view):
        # The next view is elsewhere, so time has passed for nodes that follow the tags from frame to frame. The
        # stamps are late rather than early, since nodes may leave out old frames.
        stamp = rospy.Time(*divmod(time.time_ns() + APART_NS * (number - 1), 10**9))
        self._stamps[stamp] = number
        header = Header(stamp=stamp, frame_id=FRAME_ID)
        self._info.publish(camera_info(Camera(), header))
        self._camera.publish(image_from_frame(view.frame, header, 'rgb8'))  # as most cameras do

    def _take(self, answer, name, output, message, when):
        """Let the answer have a message, if it is one to its view."""
        kept = self._stamps.get(message.header.stamp)
        if kept not in (None, answer.number):
            return  # a late one, to a frame before
        try:
            image = output.decode(message)
        except InputError as error:
            raise _Found(sentences.unreadable(self._topics.outputs[name], message.encoding, error)) from None
        if message.encoding.lower() in GRAY:
            image = image[..., 0]
        if ENCODING in output.decode.notes and message.encoding not in OF_BRIDGE:
            self._remark(output.decode.notes[ENCODING])
        if kept is None:
            self._remark(sentences.no_stamp())
        is_last = name == next(reversed(self._outputs))
        is_sure = kept is not None or (self._background.number(image) + 1 == answer.number if is_last
                                       else answer.is_sure)
        answer.take(name, image, when, is_sure)

    def _remark(self, sentence):
        if sentence not in self.collected.remarks:
            self.collected.remarks.append(sentence)

    def _finish(self, is_early):
        """Raise _Found if something is wrong with how it publishes."""
        graph = self._graph()
        for topic in self._topics.outputs.values():
            if graph.others(topic) or len(graph.publishers(topic)) > 1:
                raise _Found(sentences.several(topic, sorted(graph.published[topic])))
            if not is_early:
                raise _Found(sentences.late_publisher(topic))
        shown = self.collected.shown
        if has_exchanged_colors([each.view.frame for each in shown], [each.image for each in shown]):
            raise _Found(sentences.exchanged_colors())


class _Answer:
    """The images that a node publishes for a view, of which some may not say for which."""

    def __init__(self, number, names):
        self.number, self.images, self.arrived = number, dict.fromkeys(names), 0.0
        self.is_sure = False  # whether what arrives from now on is an answer to this view
        self._last, self._has_last, self._strange = names[-1], False, 0

    def on_shown(self):
        """The view was shown again, after its image with what was drawn arrived."""
        self.is_sure = self._has_last

    def take(self, name, image, when, is_sure):
        if not is_sure and name == self._last:
            self._strange += 1
            is_sure = self._strange >= STRANGE
        if is_sure:
            self.arrived = self.arrived or when
            self._has_last = self._has_last or name == self._last
            self.images[name] = image

    def missing(self):
        """The names of the outputs that have not arrived."""
        return [name for name, image in self.images.items() if image is None]

    def is_whole(self):
        return not self.missing()


def _baseline_seconds(views):
    """How long OpenCV's detector alone takes for a frame here, the median."""
    finder, seconds = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)), []
    for view in views:
        begin = time.monotonic()
        finder.detectMarkers(cv2.cvtColor(view.frame, cv2.COLOR_BGR2GRAY))
        seconds.append(time.monotonic() - begin)
    return median(seconds)
