"""The ROS master: asking it without waiting for long, and registering again where it has lost the node."""
import threading
import time
from typing import Callable, List
from xmlrpc.client import ServerProxy, Transport

import rosgraph
import rospy
from aruco_ar.base.errors import InputError
from rospy.core import get_node_uri, is_shutdown_requested
from rospy.impl.paramserver import get_param_server_cache
from rospy.impl.registration import (
    Registration,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

ANSWER_S = 2.0  # for which the master may think about it
LOOK_S = 2.0    # so often it is asked whether it knows the node

ROSOUT = '/rosout_disable_topics_generation'

_before: List[Callable[[], None]] = []  # what is to be called before the node is registered again


class _Impatient(Transport):
    """Waits for an answer for ANSWER_S; rospy's own, and what comes over Wi-Fi, may wait forever."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = ANSWER_S
        return connection


def ask(method, *arguments):
    """(code, value) that the ROS master answers; code 1 is success. Raises InputError if it does not answer."""
    try:
        with ServerProxy(rosgraph.get_master_uri(), transport=_Impatient()) as master:
            code, _, value = getattr(master, method)(rospy.get_name(), *arguments)
    except Exception as error:  # of the network, of XML, of another server at that port
        raise InputError('The ROS master does not answer: %s' % error, kind='no master') from None
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


def before_registering(work):
    """Have ``work`` called when the master has lost the node, before it is registered again."""
    _before.append(work)


def keep_registered():
    """Register the node again, about LOOK_S after the master lost it: in a thread of its own, until shutdown.

    A master that was started anew knows nobody; nor does one that was told to
    forget who was out of reach (rosnode cleanup).
    """
    try:
        known = ask('subscribeParam', get_node_uri(), ROSOUT)[1]
    except InputError:
        known = False
    # While it has no value rospy asks for it with each line of the log, which waits where the master hangs.
    get_param_server_cache().set(ROSOUT, known is True)
    threading.Thread(target=_look, daemon=True).start()


def _look():
    while not is_shutdown_requested():
        time.sleep(LOOK_S)
        try:
            if _is_lost():
                for work in _before:
                    work()
                _register()
                rospy.logwarn('The ROS master, perhaps a new one, did not know the node: it is registered '
                              'again.')
        except Exception as error:  # the master went away again; the next look will find it so
            rospy.logdebug('Looking after the registration: %s', error)


def _is_lost():
    """Whether the master does not know the node's first service, or its last: see _register."""
    services = get_service_manager().get_services()  # of the logger at least, which every node has
    known = all(ask('lookupService', name)[0] == 1 for name, _ in (services[0], services[-1]))
    if known or is_shutdown_requested():
        return False
    code, uri = ask('lookupNode', rospy.get_name())
    return code != 1 or uri == get_node_uri()  # else another node goes by its name now


def _register():
    """Register all topics and services as rospy does with one that is new; whom to connect to comes back."""
    topics, services, listeners = get_topic_manager(), get_service_manager(), get_registration_listeners()
    with topics.lock, services.lock:  # meanwhile none comes or goes
        first, *others = services.get_services()
        # Where this master goes away as well, halfway, the first is missing at the next, or the last.
        for names, kind in (([first], Registration.SRV), (topics.get_publications(), Registration.PUB),
                            (topics.get_subscriptions(), Registration.SUB), (others, Registration.SRV)):
            for name, what in names:
                listeners.notify_added(name, what, kind)
