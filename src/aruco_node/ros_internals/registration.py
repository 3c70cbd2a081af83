"""Registering the node again where the ROS master has lost it.

Symptom: a master that was started anew knows no node. Neither does one that was told to forget unreachable
nodes (rosnode cleanup). rospy registers only once, so the node runs on, but nobody finds it.
Private: ``rospy.impl.registration`` (topic manager, service manager, listeners) and the parameter cache of
``rospy.impl.paramserver``. Without them, the node has to be restarted with its master.
Seen with: rospy 1.15 and 1.17. It can go when rospy watches its registration; ROS 2 has no master.
"""
import threading
import time
from typing import Callable, List

import rospy
from aruco_ar.base.errors import InputError

from . import warn_of_other
from .master import ask
from .shutdown import is_ending

try:
    from rospy.core import get_node_uri
    from rospy.impl.paramserver import get_param_server_cache
    from rospy.impl.registration import (
        Registration,
        get_registration_listeners,
        get_service_manager,
        get_topic_manager,
    )
    IS_KNOWN = True
except ImportError:
    IS_KNOWN = False  # another rospy

PERIOD_S = 2.0  # time between the questions to the master whether it knows the node

ROSOUT = '/rosout_disable_topics_generation'

_preparations: List[Callable[[], None]] = []  # called before the node is registered again


def before_registering(work):
    """Have ``work`` called when the master has lost the node, before the node is registered again."""
    _preparations.append(work)


def keep_registered():
    """Register the node again within some PERIOD_S after the master lost it, in a thread, until shutdown."""
    if not IS_KNOWN:
        _warn()
        return
    try:
        known = ask('subscribeParam', get_node_uri(), ROSOUT)[1]
    except InputError:
        known = False
    # Until this parameter is cached, rospy asks the master for it at every log line, and blocks if the master
    # hangs.
    get_param_server_cache().set(ROSOUT, known is True)
    threading.Thread(target=_watch, daemon=True).start()


def _warn():
    warn_of_other('rospy', 'If the ROS master restarts, restart this node, too.')


def _watch():
    while not is_ending():
        time.sleep(PERIOD_S)
        try:
            if _is_lost():
                for work in _preparations:
                    work()
                _register()
                rospy.logwarn('The ROS master, perhaps a new one, did not know the node: it is registered '
                              'again.')
        except (AttributeError, TypeError):  # rospy is another than expected
            _warn()
            return
        except Exception as error:  # the master went away again; the next look will find it so
            rospy.logdebug('Looking after the registration: %s', error)


def _is_lost():
    """Whether the master does not know the node's first service or its last one: see _register."""
    services = get_service_manager().get_services()  # every node has at least the services of its logger
    known = all(ask('lookupService', name)[0] == 1 for name, _ in (services[0], services[-1]))
    if known or is_ending():
        return False
    code, uri = ask('lookupNode', rospy.get_name())
    return code != 1 or uri == get_node_uri()  # otherwise another node has taken its name


def _register():
    """Register all topics and services as rospy does with a new one. The master then connects them again."""
    topics, services, listeners = get_topic_manager(), get_service_manager(), get_registration_listeners()
    with topics.lock, services.lock:  # none may come or go meanwhile
        first, *others = services.get_services()
        # If this master dies halfway, the next one misses the first or the last service, so _is_lost notices.
        for names, kind in (([first], Registration.SRV), (topics.get_publications(), Registration.PUB),
                            (topics.get_subscriptions(), Registration.SUB), (others, Registration.SRV)):
            for name, what in names:
                listeners.notify_added(name, what, kind)
