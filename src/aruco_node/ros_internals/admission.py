"""Clients that connect to the node's topics and services.

Symptom: rospy reads the header of each new connection in the one thread that accepts them all. A client that
connects and says nothing, for example because its network breaks down, then locks out all other clients.
Private: ``rospy.impl.tcpros_base._tcpros_server.tcp_ros_server.inbound_handler``.
Seen with: rospy 1.15 and 1.17. It can go when rospy itself reads headers with a timeout.
"""
import socket
import threading
from contextlib import suppress

from rospy.impl import tcpros_base

from . import warn_of_other

HEADER_S = 5.0  # a client must send its header within this time
# Unsent bytes that the kernel may hold for one client. By default Linux holds megabytes. On a slow network
# these are seconds of old frames that nobody wants to see any more; rospy then leaves frames out instead.
MAX_UNSENT_BYTES = 128 * 1024
# After an outage TCP tries again at least every RETRY_MS. By default Linux doubles the time with each try, so
# it needs as long to come back as the outage took. The option is new in Linux 6.15.
TCP_RTO_MAX_MS, RETRY_MS = 44, 1000


def admit_concurrently():
    """Have rospy read the header of each new connection in a thread of its own, and only for HEADER_S."""
    try:
        server = tcpros_base._tcpros_server.tcp_ros_server
        admit = server.inbound_handler
    except AttributeError:
        warn_of_other('rospy', 'A client that connects and says nothing can lock out all others.')
        return

    def admit_in_thread(connection, address):
        connection.settimeout(HEADER_S)  # rospy resets it when it answers
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MAX_UNSENT_BYTES)
        with suppress(OSError):
            connection.setsockopt(socket.IPPROTO_TCP, TCP_RTO_MAX_MS, RETRY_MS)
        threading.Thread(target=admit, args=(connection, address), daemon=True).start()
    server.inbound_handler = admit_in_thread
