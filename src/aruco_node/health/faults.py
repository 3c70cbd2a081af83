"""What is wrong is said once; and where one of the node's own threads raises, the node goes on."""
import threading
import time
import traceback
from functools import wraps
from typing import Any, List, Set, Tuple

import rospy
from aruco_ar.base.errors import InputError
from rospy.core import is_shutdown_requested

LASTS_S = 3.0    # so long /diagnostics says a fault, if it does not come again
MAX_KINDS = 100  # of what is wrong are logged; /diagnostics says the others, too

_kinds: Set[Any] = set()
_last: List[Tuple[float, str]] = []  # when and what; one at most
_lock = threading.Lock()


def note_fault(error, *_):
    """Take note of an exception: the log has the traceback of each kind once; returns a sentence, or None.

    None while ROS shuts down: while all topics are closed, whatever is
    published fails. It may be the ``error_handler`` of a service.
    """
    if is_shutdown_requested():
        return None
    if isinstance(error, InputError):
        sentence, whole, kind = str(error), str(error), error.kind
    else:
        sentence = 'A fault of this node, of which its log says more: %s' % \
            traceback.format_exception_only(type(error), error)[-1].strip()
        whole = 'A fault of this node, which goes on:\n' + \
            ''.join(traceback.format_exception(type(error), error, error.__traceback__)).rstrip()
        # Its place in the code: the text may be another each time.
        kind = (type(error), *((frame.f_code, line) for frame, line in traceback.walk_tb(error.__traceback__)))
    with _lock:
        _last[:] = [(time.monotonic(), sentence)]
    say_once(kind, whole)
    return sentence


def say_once(kind, sentence, log=rospy.logerr):
    """Log a sentence, unless one of that kind has been logged, or MAX_KINDS others."""
    with _lock:
        is_new = kind not in _kinds and len(_kinds) < MAX_KINDS
        if is_new:
            _kinds.add(kind)
    if is_new:
        log('%s', sentence)


def last_fault():
    """The sentence of the last fault, or None where there was none for LASTS_S."""
    with _lock:
        return next((sentence for when, sentence in _last if time.monotonic() - when < LASTS_S), None)


def guarded(work):
    """The function, but where it raises, that is noted, and it returns None."""
    @wraps(work)
    def guard(*arguments):
        try:
            return work(*arguments)
        except Exception as error:
            note_fault(error)
            return None
    return guard
