"""Which nodes of a process group publish and subscribe to what, as the ROS master tells."""
import os
from contextlib import suppress
from typing import Any
from xmlrpc.client import ServerProxy

import rospy

from aruco_node.ros_internals.master import ImpatientTransport, ask

IMAGE, COMPRESSED = 'sensor_msgs/Image', 'sensor_msgs/CompressedImage'


class Graph:
    """What is published and subscribed to now, by the nodes of the learner's program and by others."""

    def __init__(self, group, known):
        """Ask the master.

        ``group``: the id of the program's process group. ``known``: {(node, uri): whether it is in the group},
        which is filled. Raises InputError if the master does not answer.
        """
        published, subscribed, _ = ask('getSystemState')[1]
        self._kinds = dict(ask('getTopicTypes')[1])
        nodes = {node for _, users in [*published, *subscribed] for node in users} - {rospy.get_name()}
        self.own = {node for node in nodes if _is_of(node, group, known)}
        self.published = {topic: set(users) for topic, users in published}
        self.subscribed = {topic: set(users) for topic, users in subscribed}

    def publishers(self, topic):
        """The learner's nodes that publish a topic."""
        return self.published.get(topic, set()) & self.own

    def subscribers(self, topic):
        """The learner's nodes that subscribe to a topic."""
        return self.subscribed.get(topic, set()) & self.own

    def others(self, topic):
        """Other nodes that publish a topic, besides this one."""
        return sorted(self.published.get(topic, set()) - self.own - {rospy.get_name()})

    def kind(self, topic):
        """The type of a topic, or nothing if it is not known."""
        return self._kinds.get(topic, '')

    def images(self, subscribed=False):
        """The image topics that the learner's nodes publish, or subscribe to."""
        topics = self.subscribed if subscribed else self.published
        return sorted(topic for topic, nodes in topics.items()
                      if nodes & self.own and self.kind(topic) in (IMAGE, COMPRESSED))


def _is_of(node, group, known):
    """Whether a node runs in a process group of this machine."""
    uri = ask('lookupNode', node)[1]
    if (node, uri) not in known:
        with suppress(Exception):  # it has just ended, or is on another machine
            with ServerProxy(uri, transport=ImpatientTransport()) as proxy:
                answer: Any = proxy.getPid(rospy.get_name())
            known[node, uri] = os.getpgid(answer[2]) == group
    return known.get((node, uri), False)
