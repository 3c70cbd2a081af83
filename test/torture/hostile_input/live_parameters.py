"""Parameters of running nodes, set by dynamic_reconfigure.

The nodes must refuse wrong values, and keep answering frames.
"""
import queue
import sys
import time
import urllib.request

import rospy
from aruco_ar.base.errors import InputError
from aruco_ar.base.progress import progress
from aruco_ar.settings.declaration import parameters_of
from aruco_node.messages.images import image_from_frame
from aruco_node.parameters.parameters import ros_values
from dynamic_reconfigure.msg import Config
from dynamic_reconfigure.srv import Reconfigure
from hostile.parameters import validation, values
from hostile.parameters.configs import GROUPS, NAMES, REFUSED, config_with, values_of
from rig.nodes.case import CAMERA, scene
from rig.nodes.topics import Inbox
from rig.page.server import free_port
from rig.processes.started import WAIT_S, Started, program, stop_all
from sensor_msgs.msg import Image
from std_msgs.msg import Header

SIMULATED = '/simulated/image_raw'
NEWEST = 20  # images that wait to be looked at; within minutes, all of them would fill the memory
LEAST_RATE_HZ = 0.2  # a node that is to publish less often answers too late to be waited for
# The topic to watch, if it is not ~image.
OUTPUTS = {'wall_camera': SIMULATED, 'camera_relay': '/camera_relay/image_raw'}


class Live:
    """All nodes at once, with a camera. ``counts``, ``found``: see parameters."""

    def __init__(self, kinds, counts, found):
        self._kinds, self._counts, self._found = kinds, counts, found
        self._nodes, self._refused = {}, dict.fromkeys(kinds, 0)

    def __enter__(self):
        self._port = free_port()
        arguments = {'page': ['_port:=%d' % self._port], 'wall_camera': [CAMERA + ':=' + SIMULATED]}
        for node in self._kinds:
            self._nodes[node] = Started(sys.executable, program(node + '.py'), *arguments.get(node, []))
        self._camera = rospy.Publisher(CAMERA, Image, queue_size=1)
        self._inboxes = {node: Inbox(OUTPUTS.get(node, '/%s/image' % node), Image, NEWEST)
                         for node in self._kinds if node != 'page'}
        self._services = {}
        for node in self._kinds:
            rospy.wait_for_service('/%s/set_parameters' % node, WAIT_S)
            self._services[node] = rospy.ServiceProxy('/%s/set_parameters' % node, Reconfigure, persistent=True)
        return self

    def __exit__(self, *_):
        for service in self._services.values():
            service.close()
        stop_all(self._nodes.values())
        for inbox in self._inboxes.values():
            inbox.subscriber.unregister()
        self._camera.unregister()
        for node, started in self._nodes.items():
            if started.ends() != 0:
                self._note('deaths', node, 'ends with exit code %s' % started.ends())
            if any('Traceback' in line for line in started.lines):
                self._note('tracebacks', node, 'prints a traceback')
            sentences = [line for line in started.lines if REFUSED in line]
            if len(sentences) != self._refused[node]:
                self._note('bad sentences', node, 'refuses %d requests with %d sentences' % (
                    self._refused[node], len(sentences)))
            for line in sentences:
                fault = validation.fault_of(line.partition(']: ')[2].partition(REFUSED)[0])
                if fault:
                    self._note('bad sentences', node, 'refuses a request with a bad sentence: ' + fault)
        for name in self._kinds:
            if rospy.has_param('/' + name):
                rospy.delete_param('/' + name)

    def set_values(self, random, count):
        """Request ``count`` values of each parameter of each node, and odd ones, and check the results."""
        for node, kind in progress(self._kinds.items(), 'live', len(self._kinds)):
            before = self._request(node, Config())
            for name, parameter in parameters_of(kind).items():
                given = values.typed(values.values(parameter, random))
                for index in random.permutation(len(given))[:count]:
                    before = self._set_value(node, kind, name, given[index], parameter.live, before)
                self._check_answer(node)
            for config in GROUPS + NAMES:
                self._counts['odd'] += 1
                self._counts['odd', 'refused' if config in NAMES else 'accepted'] += 1
                self._refused[node] += config in NAMES
                if self._request(node, config) != before:
                    self._note('others', node, 'changes its parameters for a request without a valid one')
            self._check_answer(node)

    def _set_value(self, node, kind, name, value, is_live, before):
        """Request one value, and check the result. Returns the parameters afterward."""
        try:
            settings = validation.taken(kind, name, value) if is_live else None
        except InputError:
            settings = None
        after = self._request(node, config_with(name, value))
        self._counts['live'] += 1
        self._counts['live', 'refused' if settings is None else 'accepted'] += 1
        if settings is None:
            self._refused[node] += 1
            if after != before:
                self._note('others', node, 'accepts %s for ~%s' % (ascii(value)[:60], name))
            return after
        expected = dict(before, **{name: ros_values(settings)[name]})
        if after != expected:
            self._note('others', node, 'turns %s for ~%s into something else' % (ascii(value)[:60], name))
        if not 0 < expected.get('rate', 0) < LEAST_RATE_HZ:
            self._check_answer(node)
        return self._request(node, config_with(name, before[name]))

    def _request(self, node, config):
        """Send a request. Returns the parameters that the node answers, {name: value}; empty if it does not."""
        try:
            answer = self._services[node](config).config
        except (rospy.ServiceException, rospy.ROSException) as error:
            self._note('tracebacks', node, 'answers a request with an error: %s' % str(error)[:80])
            return {}
        return values_of(answer)

    def _check_answer(self, node):
        """Check whether the node still does its work."""
        self._counts['answers'] += 1
        if node == 'page':
            try:
                urllib.request.urlopen('http://127.0.0.1:%d/' % self._port, timeout=WAIT_S).close()
            except OSError as error:
                self._note('hangs', node, 'does not answer: %s' % error)
            return
        inbox, end = self._inboxes[node], time.monotonic() + WAIT_S
        stamp = rospy.Time.now()
        while time.monotonic() < end:
            if node != 'wall_camera':
                # With the time of now, since camera_relay waits until the next frame is due.
                self._camera.publish(image_from_frame(scene(), Header(stamp=rospy.Time.now(), frame_id='eye')))
            try:
                if inbox.get(timeout=0.5).header.stamp >= stamp:
                    return
            except queue.Empty:
                pass
        self._note('hangs' if self._nodes[node].process.poll() is None else 'deaths', node,
                   'does not answer a frame')

    def _note(self, kind, node, what):
        self._counts[kind] += 1
        self._found.setdefault('%s: %s' % (node, what), 'while it runs')
