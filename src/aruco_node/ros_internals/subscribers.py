"""Messages that arrive: the newest frame, and messages that cannot be read.

Symptom: a node that is slow for a moment works on a frame while a newer one already waits in the socket. Every
later frame is then late, too.
Private: ``rospy.Subscriber.impl.connections`` and their ``socket``. Without them, no frame is left out.
It can go when rospy says how many messages wait for a callback.

Symptom: where a message does not fit its type, rospy tries to read the same bytes again, once a second,
forever. It never gets to the messages after it.
Private: nothing but that rospy calls ``deserialize`` of the class that it was given. The node would not notice
if it no longer did; the test would.
It can go when rospy drops such a message.

Both were seen with: rospy 1.15 and 1.17.
"""
import select
from functools import lru_cache
from typing import Any

import rospy

from . import warn_of_other

# rospy drops stale messages only within what one read of the socket returned. So a read must have room for more
# than the largest frame: here one of 4K in 16 bits and three colors, with some to spare.
BUFFER_BYTES = 64 * 1024 * 1024


def subscribe_newest(topic, kind, callback):
    """A rospy.Subscriber of images, which calls back with the newest one as soon as it has arrived."""
    # Without tcp_nodelay, the end of a frame waits until its beginning has been acknowledged.
    return rospy.Subscriber(topic, kind, callback, queue_size=1, buff_size=BUFFER_BYTES, tcp_nodelay=True)


def is_more_pending(subscriber, seconds=0.0):
    """Whether more data has arrived for a rospy.Subscriber than rospy has read, or arrives within that time.

    ``subscriber`` may be None: then nothing is pending.
    """
    try:
        impl = None if subscriber is None else subscriber.impl  # None, too, if it was unregistered meanwhile
        sockets = [] if impl is None else [connection.socket for connection in impl.connections]
        return bool(select.select(sockets, [], [], seconds)[0])
    except AttributeError:
        warn_of_other('rospy', 'If frames arrive faster than the node can work, their results come late.')
    except (OSError, TypeError, ValueError):  # closed meanwhile
        pass
    return False


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
