"""Who connects to the node's topics and services, and what comes from whom it connects to."""
import select
import socket
import threading
from contextlib import suppress

import rospy
from rospy.impl import tcpros_base

# rospy drops stale messages only within what one read of the socket returned,
# so a read must have room for more than the largest frame: here one of 4K in
# 16 bits and three colors, with some to spare.
BUFFER_BYTES = 64 * 1024 * 1024
HEADER_S = 5.0  # in which who connects says what for
# Bytes that wait for a network. Linux would take megabytes: seconds' worth of what nobody wants to see any
# more, where it is slow or comes back. rospy leaves frames out instead.
MOST_WAITING = 128 * 1024
# A network that was away is tried again so often, at least. By itself Linux doubles the time with each try,
# and is as long in coming back as the network was away. Linux 6.15 is the first that lets itself be told.
TCP_RTO_MAX_MS, AGAIN_MS = 44, 1000


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
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MOST_WAITING)
        with suppress(OSError):
            connection.setsockopt(socket.IPPROTO_TCP, TCP_RTO_MAX_MS, AGAIN_MS)
        threading.Thread(target=admit, args=(connection, address), daemon=True).start()
    server.inbound_handler = admit_alone


def subscribe_newest(topic, kind, callback):
    """A rospy.Subscriber of images, which takes the newest that has come, as soon as it is there."""
    # By itself TCP lets the end of a frame wait until its beginning has been acknowledged.
    return rospy.Subscriber(topic, kind, callback, queue_size=1, buff_size=BUFFER_BYTES, tcp_nodelay=True)


def more_comes(subscriber, seconds=0.0):
    """Whether more has come for a rospy.Subscriber, or None, than rospy has read, or comes within that time."""
    try:
        sockets = [connection.socket for connection in subscriber.impl.connections]
        return bool(select.select(sockets, [], [], seconds)[0])
    except (AttributeError, OSError, TypeError, ValueError):  # closed meanwhile, or another rospy
        return False
