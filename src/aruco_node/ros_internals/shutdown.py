"""Whether ROS shuts down, and why.

Symptom: rospy.is_shutdown() becomes true only after the topics have been closed. What a node still publishes or
asks the master meanwhile fails, and would count as a fault of the node.
Private: ``rospy.core.is_shutdown_requested``. Without it, such faults are logged, and the exit code may be 1.
It can go when rospy.is_shutdown() is true as soon as rospy shuts down.

Symptom: the master ends a node when another one takes its name. rospy hardly says so, and not what to do.
Private: ``rospy.core.add_preshutdown_hook``, and the master's words. Without them, nothing more is said.
It can go when rospy.on_shutdown tells the reason.

Both were seen with: rospy 1.15 and 1.17.
"""
import rospy
import rospy.core

from . import warn_of_other

SUCCESSOR = 'new node registered with same name'


def is_ending():
    """Whether ROS shuts down, or has shut down."""
    try:
        return rospy.core.is_shutdown_requested()
    except AttributeError:
        warn_of_other('rospy', 'A node that is told to end may log faults, and say that it failed.')
        return rospy.is_shutdown()


def on_successor(tell):
    """Have a function called if ROS ends this node because another one has taken its name."""
    def hook(reason):
        if SUCCESSOR in str(reason):
            tell()
    try:
        rospy.core.add_preshutdown_hook(hook)
    except AttributeError:
        warn_of_other('rospy', 'A node whose name another one takes does not say why it ends.')
