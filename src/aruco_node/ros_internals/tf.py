"""TF frames of other nodes, and listeners to our own.

Symptom: A stamp may lie, with the buffer's length added, beyond 32 bits of seconds (the year 2106). tf2 then
ends the process, and every process that listens. It also prints a line for each of the node's own transforms
while the stamps of a camera stand still or go back.
Private: ``_connection_header`` of a message, which rospy's documentation names. Without it, the node's own
transforms are taken in, too.
It can go when tf2 checks stamps.

Symptom: a node should work only while somebody listens, but tf2_ros does not say whether somebody does.
Private: ``tf2_ros.TransformBroadcaster.pub_tf``. Without it, the node works as if somebody listened.
It can go when tf2_ros says how many nodes listen.

Both were seen with: tf2_ros 0.7, and rospy 1.15 and 1.17.
"""
import rospy
import tf2_ros

from . import sender, warn_of_other

LATEST_S = 2**32 - 24 * 3600


def is_time(stamp):
    """Whether a clock may have given that rospy.Time."""
    return stamp.secs < LATEST_S and stamp.nsecs < 10**9


class OthersFrames(tf2_ros.TransformListener):
    """Fills a buffer with the TF frames of other nodes."""

    def callback(self, data):
        """Take in the transforms of a tf2_msgs/TFMessage: those that have a possible stamp."""
        if sender(data, 'The node takes in its own TF frames, too.') != rospy.get_name():
            for each in data.transforms:
                each.header.stamp.canon()
            data.transforms = [each for each in data.transforms if is_time(each.header.stamp)]
            super().callback(data)


class Broadcaster(tf2_ros.TransformBroadcaster):
    """Publishes TF frames."""

    def is_heard(self, own=0):
        """Whether a node listens to TF frames. ``own``: how many listeners this node has itself."""
        try:
            return self.pub_tf.get_num_connections() > own
        except AttributeError:
            warn_of_other('tf2_ros', 'The node works even if nobody listens.')
            return True
