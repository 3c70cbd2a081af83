"""What the nodes say of themselves on /diagnostics, for the page: one sentence a node."""
import time

import rospy
from aruco_ar.hints.area_hints import NOTES
from diagnostic_msgs.msg import DiagnosticArray

from aruco_node.health.diagnostics import AREA_SEEN, ERROR, NO, NO_TAG, NONE_SEEN
from aruco_node.health.faults import fault_barrier
from aruco_node.messages.images import ENCODING
from aruco_node.ros_internals.subscribers import tolerant

OLD_S = 5.0   # a node that has been silent for this time has ended
MAX_TEXT = 600
LOST_S = 1.0  # an area that has not been seen for this time is reported
NOTHING = '', False


class Advice:
    """The newest sentences of some nodes."""

    def __init__(self, nodes, on_change):
        """``nodes``: their full names.

        ``on_change`` is called, from another thread, when a sentence has changed.
        """
        self._said, self._on_change = dict.fromkeys(nodes, (0.0, NOTHING)), on_change
        self._subscriber = rospy.Subscriber('/diagnostics', tolerant(DiagnosticArray), self._on_message)

    def of(self, node):
        """(sentence, whether it says why there are no frames) of a node; '' without a sentence."""
        when, said = self._said.get(node, (0.0, NOTHING))
        return said if time.monotonic() - when < OLD_S else NOTHING

    @fault_barrier
    def _on_message(self, message):
        for status in message.status:
            node = '/' + status.name.partition(':')[0].lstrip('/')
            if node in self._said:
                said, before = sentence_of(status), self.of(node)
                self._said[node] = time.monotonic(), said
                if said != before:
                    self._on_change()


def sentence_of(status):
    """What a user should know of a DiagnosticStatus: an error, a hint, why there is no area, what may surprise.

    Returns (sentence, whether it is an error). It does not mention dropped frames, as the page shows the rate.
    """
    if status.level == ERROR:
        return status.message[:MAX_TEXT], True
    values = {item.key: item.value for item in status.values}
    names = ['hint', *NOTES, 'calibration']
    if 'hint' not in values and values.get('area in the last frame') == NO and _is_lost(values.get(AREA_SEEN)):
        names = ['area']
        if status.message.startswith(NO_TAG):  # for exercises without an area
            values.setdefault('area', status.message)
    said = ' '.join(values[name] for name in [*names, ENCODING] if name in values)
    return said[:MAX_TEXT], False


def _is_lost(seen):
    try:
        return seen == NONE_SEEN or float(seen) > LOST_S
    except (TypeError, ValueError):  # the status is not one of ours
        return False
