"""Starts and ends a node: what all nodes of this package have in common."""
import difflib
import os
import signal
import sys
import threading
import time
import traceback

import cv2
import rosgraph
import rospy
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.settings.declaration import MAX_QUOTED, parameters_of, quoted

from aruco_node.messages.bridge import fault_of_bridge
from aruco_node.messages.images import FAST
from aruco_node.parameters.parameters import read
from aruco_node.parameters.settings import OLD_NAMES
from aruco_node.process.streams import make_streams_safe
from aruco_node.ros_internals.admission import admit_concurrently
from aruco_node.ros_internals.registration import keep_registered
from aruco_node.ros_internals.shutdown import is_ending, on_successor

EXIT_S = 5.0  # a node that is asked to end has ended after this time


def run_node(name, work, manual):
    """Start a node, call ``work``, which returns when ROS shuts down, and end the process.

    If ``work`` raises InputError, its sentence is logged and the exit code is 1. With --help, the Manual and
    the program's docstring are printed instead.
    """
    if any(argument in ('--help', '-h') for argument in sys.argv[1:]):
        print(manual.text(name, sys.modules['__main__'].__doc__))
        return
    make_streams_safe()
    errors: list[str] = []
    received: list[int] = []  # signals
    for each in signal.SIGINT, signal.SIGTERM:
        signal.signal(each, lambda number, frame: received.append(number))
    # At shutdown rospy waits for the master and for its own threads. If the master hangs, that took more than
    # 40 s when it was measured; with this timer it took 5.2 s. roslaunch waits for 17 s before it kills a node.
    last_resort = threading.Timer(EXIT_S, lambda: os._exit(1 if errors else 0))
    last_resort.daemon = True
    rospy.on_shutdown(last_resort.start)

    def start_and_work():
        try:
            _start(name)
            work()
        except Exception as error:
            if is_ending():  # whatever still talks to the master, or publishes, fails now
                return
            errors.append(str(error) if isinstance(error, InputError) else traceback.format_exc())
            rospy.logfatal('%s', errors[0])
            rospy.signal_shutdown(errors[0])
    # The main thread only waits for signals, and rospy's own signal handlers are off. Such a handler would talk
    # to the master in the middle of whatever the main thread does. If that thread talks to the master just
    # then, it would wait for itself forever.
    worker = threading.Thread(target=start_and_work, daemon=True)
    worker.start()
    while not received and not rospy.is_shutdown():
        time.sleep(0.1)
    rospy.signal_shutdown('a signal has arrived')
    worker.join(2.0)
    sys.exit(1 if errors else 0)


def _start(name):
    """Initialize the ROS node. Raises InputError if that fails."""
    try:
        _check_names(rosgraph.names.load_mappings(sys.argv))
        rospy.init_node(name, disable_signals=True)
    except Exception as error:  # rospy raises many kinds, for example if XML-RPC cannot carry a _PARAMETER:=
        raise InputError('%s cannot start: %s' % (name, ' '.join(str(error).split()))) from None
    on_successor(lambda: rospy.logwarn(
        'Another node has taken the name %s, so this one ends. To run both, give each a namespace: '
        'ROS_NAMESPACE=left roslaunch ...', rospy.get_name()))
    fault = fault_of_bridge()
    if fault:
        rospy.logwarn('%s Until then, raw frames can only be %s.', fault, ', '.join(FAST))
    admit_concurrently()
    keep_registered()
    _check_clock()
    # A frame takes a few milliseconds. With threads, OpenCV would add more work than it saves time.
    cv2.setNumThreads(1)


def _check_names(mappings):
    """Raise InputError if a name is remapped to one that the ROS master refuses.

    rospy ignores the refusal: the node would run, but nobody could find it.
    """
    for given, name in mappings.items():
        if (given in ('__name', '__ns') or not given.startswith('__')) and any(each in name for each in ' :'):
            raise InputError('%s:=%s is not a valid ROS name. Use letters, digits, _ and /.'
                             % (given, name))


def _check_clock():
    clock = _get('/use_sim_time', False)
    if not isinstance(clock, bool):
        rospy.logwarn('The parameter /use_sim_time is %s, but it must be true or false. This node takes it for '
                      '%s; other nodes may not. Set it: rosparam set use_sim_time false.',
                      quoted(clock), str(bool(clock)).lower())


def read_settings(kind_of_settings):
    """The node's private parameters, as an instance of a class of settings.

    A private parameter that the node does not have is logged: it is probably misspelled. Raises InputError for
    a value that is not allowed.
    """
    settings, known = read(kind_of_settings, parameter), list(parameters_of(kind_of_settings))
    own = rospy.get_name()
    given = [name[len(own) + 1:] for name in rospy.get_param_names() if name.startswith(own + '/')]
    for name in sorted(set(given) - set(known) - {OLD_NAMES.get(name) for name in known}):
        if '/' not in name:  # a group is meant for a library, such as image_transport
            alike = difflib.get_close_matches(name, known, 1, 0.5)
            rospy.logwarn('This node has no parameter ~%s, so it has no effect. %s', shorten(name, MAX_QUOTED),
                          'Did you mean ~%s?' % alike[0] if alike else 'All parameters: --help.')
    return settings


def parameter(name, default):
    """The value of a private parameter, ~name, or else of its old name.

    Raises InputError if it cannot be read from the ROS master.
    """
    if name in OLD_NAMES:
        old = _get('~' + OLD_NAMES[name], None)
        if old is not None:
            rospy.loginfo('The parameter ~%s is now named ~%s.', OLD_NAMES[name], name)
            default = old
    return _get('~' + name, default)


def _get(name, default):
    try:
        return rospy.get_param(name, default)
    except Exception as error:  # rospy raises many kinds, for example if XML-RPC cannot carry a value
        raise InputError('The parameter %s cannot be read from the ROS master (%s). Set it again: rosparam set '
                         '%s VALUE.' % (name, error, rospy.resolve_name(name))) from None
