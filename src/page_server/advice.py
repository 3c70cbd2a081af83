"""What the nodes say of themselves on /diagnostics, for the page: one sentence a node."""
import time

import rospy
from aruco_ar.hints.area_hints import NOTES
from aruco_node.health.diagnostics import ERROR, NONE_SEEN
from aruco_node.health.faults import fault_barrier
from aruco_node.ros_internals.tolerant import tolerant
from diagnostic_msgs.msg import DiagnosticArray

OLD_S = 5.0      # a node that has been silent for so long has ended
MAX_NODES = 100  # more are ignored
MAX_TEXT = 400
LOST_S = 1.0     # an area is missed once it has not been seen for so long


class Advice:
    """The newest sentence of each node that has anything to say."""

    def __init__(self, on_change):
        """``on_change`` is called, from another thread, when a sentence has changed."""
        self._said, self._on_change = {}, on_change  # {node: (when, sentence)}
        self._subscriber = rospy.Subscriber('/diagnostics', tolerant(DiagnosticArray), self._on_message)

    def of(self, node):
        """The sentence of a node, by its full name, or '' if it has none."""
        when, sentence = self._said.get(node, (0.0, ''))
        return sentence if time.monotonic() - when < OLD_S else ''

    @fault_barrier
    def _on_message(self, message):
        for status in message.status:
            node = '/' + status.name.partition(':')[0].lstrip('/')
            if node in self._said or len(self._said) < MAX_NODES:
                sentence = sentence_of(status)[:MAX_TEXT]
                has_changed = sentence != self.of(node)
                self._said[node] = time.monotonic(), sentence
                if has_changed:
                    self._on_change()


def sentence_of(status):
    """What a user should know of a DiagnosticStatus: an error, a hint, why there is no area, what may surprise.

    That frames are dropped is not among it: the page shows the rate.
    """
    if status.level == ERROR:
        return status.message
    values = {item.key: item.value for item in status.values}
    seen = values.get('area last seen (s ago)', '')
    if 'hint' not in values and 'area' in values and (seen == NONE_SEEN or float(seen) > LOST_S):
        return values['area']
    return ' '.join(values[name] for name in ('hint', *NOTES, 'calibration') if name in values)
