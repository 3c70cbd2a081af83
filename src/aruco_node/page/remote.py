"""What is chosen on the page is set in the nodes: their parameters, pictures that are dropped, and walls."""
import asyncio
import re
import threading
from concurrent.futures import ThreadPoolExecutor

import rospy
from aruco_ar.base.errors import InputError
from dynamic_reconfigure.msg import Config, DoubleParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from page_server.choices import EXERCISES, PAINTER, SIMULATION, Choices, not_answering
from page_server.shelf import ANSWER_S
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from aruco_node.health.faults import fault_barrier
from aruco_node.messages.images import image_from_frame
from aruco_node.parameters.settings import TOPIC
from aruco_node.ros_internals.subscribers import tolerant

SAVED = re.compile(r'Wrote (.+?)\. With wall:=\1,')  # in the answer of the service ~save_wall: see save_walls


class RemoteParameters:
    """The parameters of another node, by dynamic_reconfigure. The node may be absent."""

    def __init__(self, name, on_change):
        self.name = rospy.resolve_name(name)
        self._values, self._on_change = {}, on_change
        self._updates = rospy.Subscriber(self.name + '/parameter_updates', tolerant(Config), self._on_update)
        self._service = rospy.ServiceProxy(self.name + '/set_parameters', Reconfigure)
        self._worker = ThreadPoolExecutor(1, name)  # each node has its own thread, so that none delays another
        self._lock, self._wanted, self._job = threading.Lock(), {}, None

    @property
    def values(self):
        """{parameter: value}; empty while the node is not running."""
        return dict(self._values) if self._updates.get_num_connections() else {}

    async def set(self, **values):
        """Set parameters, texts or numbers. Raises InputError if the node refuses them or does not answer.

        While the node works on one request, all further values are collected for the next one.
        """
        with self._lock:
            job = self._job if self._wanted else None
            self._wanted.update(values)
        if job is None:
            self._job = job = asyncio.get_event_loop().run_in_executor(self._worker, self._set_wanted)
        try:
            refused = await asyncio.wait_for(asyncio.shield(job), ANSWER_S)
        except asyncio.TimeoutError:
            raise not_answering(self.name) from None
        for name, value in values.items():
            if refused.get(name) == value:  # otherwise it is another request's value that is refused
                raise InputError('%s refuses "%s". Its log says why.' % (self.name, value))

    def _set_wanted(self):
        """Set all wanted values. Returns {name: text} of the texts that the node refuses."""
        with self._lock:
            values, self._wanted = self._wanted, {}
        config = Config()
        for name, value in values.items():
            if isinstance(value, str):
                config.strs.append(StrParameter(name, value))
            else:
                config.doubles.append(DoubleParameter(name, float(value)))
        try:
            taken = values_of(self._service(config).config)
        except rospy.ServiceException as error:
            why = error if self._updates.get_num_connections() else 'it is not running'
            raise InputError('%s does not answer: %s. Start it, or look at its log.'
                             % (self.name, why)) from None
        return {name: value for name, value in values.items()
                if isinstance(value, str) and taken.get(name) != value}

    @fault_barrier
    def _on_update(self, config):
        self._values = values_of(config)
        self._on_change()


def values_of(config):
    """{name: value} of a dynamic_reconfigure/Config."""
    return {item.name: item.value for item in config.strs + config.doubles}


class NodeChoices(Choices):
    """The Choices of the nodes: they are set by dynamic_reconfigure."""

    def __init__(self, on_change):
        nodes = {name: RemoteParameters(name, on_change) for name in EXERCISES + SIMULATION}
        super().__init__(nodes, on_change)
        self._dropped = rospy.Publisher('~picture', Image, queue_size=1, latch=True)

    def take(self, picture):
        self._dropped.publish(image_from_frame(picture, Header(stamp=rospy.Time.now())))

    @property
    def drop_value(self):
        return TOPIC + self._dropped.resolved_name

    def saved_wall(self):
        node = rospy.resolve_name(PAINTER[0])
        try:
            answer = rospy.ServiceProxy(node + '/save_wall', Trigger)()
        except rospy.ServiceException:
            raise not_answering(node) from None
        paths = SAVED.findall(answer.message)
        if not answer.success:
            raise InputError(answer.message)
        if len(paths) != 1:
            raise InputError('Each area has a wall of its own. Give each its file, as wall in the file of the '
                             'areas: %s.' % ', '.join(paths))
        return paths[0]
