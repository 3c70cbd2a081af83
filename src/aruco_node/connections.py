"""Who connects to the node's topics and services, and what comes from whom it connects to."""
import select
import threading

import rospy
from rospy.impl import tcpros_base

HEADER_S = 5.0  # in which who connects says what for


def admit_each_alone():
    """Have rospy wait for what each who connects wants in a thread of its own, and not for long.

    By itself it does so in the one thread that lets in all: one that connects
    and says nothing, as where its network breaks down, would keep out all others.
    """
    try:
        server = tcpros_base._tcpros_server.tcp_ros_server
        admit = server.inbound_handler
    except AttributeError:
        rospy.logdebug('This rospy lets in who connects in another way.')
        return

    def admit_alone(connection, address):
        connection.settimeout(HEADER_S)  # rospy takes it away with its answer
        threading.Thread(target=admit, args=(connection, address), daemon=True).start()
    server.inbound_handler = admit_alone


def more_comes(subscriber, seconds=0.0):
    """Whether more has come for a rospy.Subscriber, or None, than rospy has read, or comes within that time."""
    try:
        sockets = [connection.socket for connection in subscriber.impl.connections]
        return bool(select.select(sockets, [], [], seconds)[0])
    except (AttributeError, OSError, TypeError, ValueError):  # closed meanwhile, or another rospy
        return False
