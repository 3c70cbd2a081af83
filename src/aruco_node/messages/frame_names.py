"""Names of TF frames."""
import rospy
from rosgraph.names import ns_join

WALL_FRAME = 'wall'


def frame_name(name):
    """The name of a TF frame of this node, with the node's namespace before it, as for topics.

    So each of two robots with one master has its own odom, base_link and tags. A name that begins with a slash
    gets no namespace, and loses the slash.
    """
    return ns_join(rospy.get_namespace(), name).lstrip('/')
