"""Asking the ROS master without waiting for long.

Symptom: rospy's own proxy of the master has no timeout. Where the master's host is out of reach, a call hangs
for minutes, or forever, and with it whatever thread made it.
Private: nothing; this is the master's public XML-RPC API. It can go when rospy's proxy has a timeout.
"""
from xmlrpc.client import ServerProxy, Transport

import rosgraph
import rospy
from aruco_ar.base.errors import InputError

TIMEOUT_S = 2.0


class ImpatientTransport(Transport):
    """HTTP that waits for TIMEOUT_S at most."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


def no_answer(why):
    """The InputError for a ROS master that does not answer."""
    return InputError('The ROS master at %s does not answer (%s). Start roscore, or set ROS_MASTER_URI.'
                      % (rosgraph.get_master_uri(), why), kind='no master')


def ask(method, *arguments):
    """(code, value) that the ROS master answers; code 1 is success. Raises InputError if it does not answer."""
    try:
        with ServerProxy(rosgraph.get_master_uri(), transport=ImpatientTransport()) as master:
            code, _, value = getattr(master, method)(rospy.get_name(), *arguments)
    except Exception as error:  # the network, the XML, or another server at that port may be the cause
        raise no_answer(error) from None
    return code, value


def published_topics():
    """{name: type} of all topics that have a publisher. Raises InputError if the master does not answer."""
    return dict(ask('getPublishedTopics', '')[1])


def is_there():
    """Whether the master answers."""
    try:
        ask('getPid')
    except InputError:
        return False
    return True
