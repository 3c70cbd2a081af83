"""What every node of this package does when it starts and when it ends."""
import os
import signal
import sys
import threading
import time
import traceback

import cv2
import rosgraph
import rospy
from aruco_ar.base.errors import InputError
from rospy.core import is_shutdown_requested

from aruco_node.messages.bridge import fault_of_bridge
from aruco_node.messages.images import FAST
from aruco_node.parameters.parameters import quoted
from aruco_node.process.streams import guard_streams
from aruco_node.ros_internals.admission import admit_concurrently
from aruco_node.ros_internals.registration import keep_registered

ENDS_S = 5.0  # a node that is asked to end has ended after so long


def run_node(name, work, manual):
    """Start a node, call ``work``, which goes on until ROS shuts down, and end the process.

    Where ``work`` raises InputError, its sentence is logged and the exit code
    is 1. Asked for --help, print the Manual and the program's docstring instead.
    """
    if any(argument in ('--help', '-h') for argument in sys.argv[1:]):
        print(manual.text(name, sys.modules['__main__'].__doc__))
        return
    guard_streams()
    errors: list[str] = []
    asked: list[int] = []
    for each in signal.SIGINT, signal.SIGTERM:
        signal.signal(each, lambda number, frame: asked.append(number))
    # rospy waits for the master and for its own threads, perhaps forever: where the master is out of reach.
    last = threading.Timer(ENDS_S, lambda: os._exit(1 if errors else 0))
    last.daemon = True
    rospy.on_shutdown(last.start)

    def guarded():
        try:
            _start(name)
            work()
        except Exception as error:
            if is_shutdown_requested():  # whatever is asked for, or published, fails then
                return
            errors.append(str(error) if isinstance(error, InputError) else traceback.format_exc())
            rospy.logfatal('%s', errors[0])
            rospy.signal_shutdown(errors[0])
    # Not in the main thread, nor are signals left to rospy: it would talk to the
    # master in the midst of whatever that thread does, and wait forever for
    # itself if it is talking to the master already.
    worker = threading.Thread(target=guarded, daemon=True)
    worker.start()
    while not asked and not rospy.is_shutdown():
        time.sleep(0.1)
    rospy.signal_shutdown('asked to end')
    worker.join(2.0)
    sys.exit(1 if errors else 0)


def _start(name):
    """Become a ROS node. Raises InputError if that cannot be."""
    try:
        _check_names(rosgraph.names.load_mappings(sys.argv))
        rospy.init_node(name, disable_signals=True)
    except Exception as error:  # whatever rospy raises, such as for a _PARAMETER:= that XML-RPC cannot carry
        raise InputError('%s cannot start: %s' % (name, ' '.join(str(error).split()))) from None
    fault = fault_of_bridge()
    if fault:
        rospy.logwarn('%s Until then, of raw frames only %s are read.', fault, ', '.join(FAST))
    admit_concurrently()
    keep_registered()
    _check_clock()
    # A frame takes a few milliseconds: threads would add more work than they save time.
    cv2.setNumThreads(1)


def _check_names(mappings):
    """Raise InputError if a name is remapped to one that the ROS master refuses: rospy would go on unheard."""
    for given, name in mappings.items():
        if (given in ('__name', '__ns') or not given.startswith('__')) and any(each in name for each in ' :'):
            raise InputError('%s:=%s gives no name of ROS; it must be of letters, digits, _ and /.'
                             % (given, name))


def _check_clock():
    clock = _get('/use_sim_time', False)
    if not isinstance(clock, bool):
        rospy.logwarn('The parameter /use_sim_time is %s, which counts as %s here, and may elsewhere as the '
                      'other; it must be true or false: rosparam set use_sim_time false.',
                      quoted(clock), str(bool(clock)).lower())


def parameter(name, default):
    """The value of a private parameter, ~name. Raises InputError if the ROS master cannot say it."""
    return _get('~' + name, default)


def _get(name, default):
    try:
        return rospy.get_param(name, default)
    except Exception as error:  # whatever the master's client raises, such as for what XML-RPC cannot carry
        raise InputError('The ROS master does not say what the parameter %s is (%s); set it anew: rosparam set '
                         '%s VALUE.' % (name, error, rospy.resolve_name(name))) from None
