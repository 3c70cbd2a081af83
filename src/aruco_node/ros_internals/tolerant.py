"""Messages that cannot be read.

Symptom: where a message does not fit its type, rospy tries to read the same bytes again, once a second,
forever. It never gets to the messages after it.
Private: nothing but that rospy calls ``deserialize`` of the class that it was given. The node would not notice
if it no longer did; the test would.
Seen with: rospy 1.15 and 1.17. It can go when rospy drops such a message.
"""
from functools import lru_cache
from typing import Any

import rospy


@lru_cache(maxsize=None)
def tolerant(kind: Any):
    """A class of messages like ``kind``. A message of it that cannot be read arrives as an empty one."""
    class Tolerant(kind):
        told = False

        def deserialize(self, buff):
            try:
                return super().deserialize(buff)
            except Exception as error:  # genpy raises many kinds
                if not Tolerant.told:
                    Tolerant.told = True
                    rospy.logerr('A message that should be a %s cannot be read (%s), and counts as an empty '
                                 'one. What publishes it?', kind._type, error)
                return Tolerant()
    return Tolerant
