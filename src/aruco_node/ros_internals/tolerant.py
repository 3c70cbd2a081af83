"""Messages that cannot be read."""
from functools import lru_cache
from typing import Any

import rospy


@lru_cache(maxsize=None)
def tolerant(kind: Any):
    """A class of messages like ``kind``, of which one that cannot be read comes as an empty one.

    rospy tries to read such a message again and again, a second each time, and
    never gets to those after it.
    """
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
