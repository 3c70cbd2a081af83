"""Names of TF frames."""
import rospy
from rosgraph.names import ns_join


def frame_name(name):
    """The name of a TF frame of this node: in a namespace with that before it, as topics have.

    So two robots before one master have each their own odom, base_link and
    tags. A name that begins with a slash stays as it is, without the slash.
    """
    return ns_join(rospy.get_namespace(), name).lstrip('/')
