"""Every reach into private parts of ROS.

Each file says which symptom it cures, which versions it was seen with, and when it can go. Where a private part
is no longer what it was, the node warns once and works without the cure, and
test/node/programs/test_ros_internals.py fails.
"""
from functools import lru_cache

import rospy


@lru_cache(maxsize=None)  # so that each is said once
def warn_of_other(package, loss):
    """Warn, once, that a package of ROS is not as it was. ``loss``: what is missed by that, in a sentence."""
    rospy.logwarn('This %s is not one that unit5 knows. %s', package, loss)


def sender(message, loss):
    """The node that a message or a request came from. If rospy does not say it: '', and a warning, once."""
    try:
        return message._connection_header.get('callerid', '')
    except AttributeError:
        warn_of_other('rospy', loss)
        return ''
