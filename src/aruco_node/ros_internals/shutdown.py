"""Whether ROS shuts down.

Symptom: rospy.is_shutdown() becomes true only after the topics have been closed. What a node still publishes or
asks the master meanwhile fails, and would count as a fault of the node.
Private: ``rospy.core.is_shutdown_requested``. Without it, such faults are logged, and the exit code may be 1.
Seen with: rospy 1.15 and 1.17. It can go when rospy.is_shutdown() is true as soon as rospy shuts down.
"""
import rospy
import rospy.core

from . import warn_of_other


def is_ending():
    """Whether ROS shuts down, or has shut down."""
    try:
        return rospy.core.is_shutdown_requested()
    except AttributeError:
        warn_of_other('rospy', 'A node that is told to end may log faults, and say that it failed.')
        return rospy.is_shutdown()
