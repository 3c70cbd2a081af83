"""Stamps as no clock gives them, and what they do to TF."""
import rospy
import tf2_ros

# tf2 ends the process, and that of everybody who listens, where it counts on from a
# stamp to beyond what 32 bits hold, in the year 2106.
LATEST_S = 2**32 - 24 * 3600


def is_time(stamp):
    """Whether a clock may have given that rospy.Time."""
    return stamp.secs < LATEST_S and stamp.nsecs < 10**9


class OthersFrames(tf2_ros.TransformListener):
    """Fills a buffer with the TF frames of others.

    Not with those of this node, of which tf2 says a line each where the stamps
    of a camera stand still or go back.
    """

    def callback(self, data):
        if data._connection_header['callerid'] != rospy.get_name():
            data.transforms = [each for each in data.transforms if is_time(each.header.stamp)]
            super().callback(data)
