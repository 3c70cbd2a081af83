"""Faults are logged once, and a node goes on where one of its threads raises an exception."""
import threading
import time
import traceback
from functools import wraps
from typing import Any, List, Set, Tuple

import rospy
from aruco_ar.base.errors import InputError

from aruco_node.ros_internals.shutdown import is_ending

RECENT_S = 3.0   # /diagnostics shows a fault for this time after it last occurred
MAX_KINDS = 100  # only this many kinds of faults are logged; /diagnostics shows the others, too

_logged_kinds: Set[Any] = set()
_last: List[Tuple[float, str]] = []  # the last fault, if there was one: when, monotonic seconds, and a sentence
_lock = threading.Lock()


def note_fault(error, *_):
    """Log an exception, each kind once, and keep it for /diagnostics. Returns a sentence about it.

    It can be the ``error_handler`` of a service. While ROS shuts down, it does nothing and returns None: topics
    are closed then, so whatever is still published fails.
    """
    if is_ending():
        return None
    if isinstance(error, InputError):
        sentence, whole, kind = str(error), str(error), error.kind
    else:
        sentence = 'A fault of this node; its log has the traceback: %s' % \
            traceback.format_exception_only(type(error), error)[-1].strip()
        whole = 'A fault of this node, which continues to run:\n' + \
            ''.join(traceback.format_exception(type(error), error, error.__traceback__)).rstrip()
        # The kind is the place in the code, since the text may differ each time.
        kind = (type(error), *((frame.f_code, line) for frame, line in traceback.walk_tb(error.__traceback__)))
    with _lock:
        _last[:] = [(time.monotonic(), sentence)]
    log_once(kind, whole)
    return sentence


def log_once(kind, sentence, log=rospy.logerr):
    """Log a sentence, unless one of this kind, or of MAX_KINDS other kinds, has been logged before."""
    with _lock:
        is_new = kind not in _logged_kinds and len(_logged_kinds) < MAX_KINDS
        if is_new:
            _logged_kinds.add(kind)
    if is_new:
        log('%s', sentence)


def log_notes(topic, notes):
    """Log the notes of what reads a topic, {kind: sentence}, each kind once for each topic."""
    for kind, sentence in notes.items():
        log_once((topic, kind), '%s: %s' % (topic, sentence), rospy.loginfo)


def last_fault():
    """A sentence about the last fault, or None if there was none within RECENT_S."""
    with _lock:
        return next((sentence for when, sentence in _last if time.monotonic() - when < RECENT_S), None)


def fault_barrier(work):
    """Wrap a function so that an exception does not leave it: the fault is noted, and None is returned."""
    @wraps(work)
    def wrapper(*arguments):
        try:
            return work(*arguments)
        except Exception as error:
            note_fault(error)
            return None
    return wrapper
