"""Clients that connect to the node's topics and services.

Symptom: rospy reads the header of each new connection in the one thread that accepts them all. A client that
connects and says nothing, for example because its network breaks down, then locks out all other clients.
Private: ``rospy.impl.tcpros_base._tcpros_server.tcp_ros_server.inbound_handler``.
Seen with: rospy 1.15 and 1.17. It can go when rospy itself reads headers with a timeout.
"""
import select
import socket
import struct
import threading
import time
from contextlib import suppress

from rospy.impl import tcpros_base

from . import warn_of_other

HEADER_S = 5.0  # a client must send its header within this time
MAX_HEADER_BYTES = 1 << 20  # what says that its header is longer is not a client: HTTP, for example
LENGTH = struct.Struct('<I')  # of the header's length, with which it begins
# Unsent bytes that the kernel may hold for one client. By default Linux holds megabytes. On a slow network
# these are seconds of old frames that nobody wants to see any more; rospy then leaves frames out instead.
MAX_UNSENT_BYTES = 128 * 1024
# After an outage TCP tries again at least every RETRY_MS. By default Linux doubles the time with each try, so
# it needs as long to come back as the outage took. The option is new in Linux 6.15.
TCP_RTO_MAX_MS, RETRY_MS = 44, 1000


def admit_concurrently():
    """Have rospy wait for the header of each new connection in a thread of its own, and only for HEADER_S.

    While many nodes start, a rospy subscriber may connect twice. It hangs up the first connection before it
    makes the second, and rospy keeps what was admitted last. So what has hung up is not admitted: the
    subscriber would get nothing, and would never know.
    """
    try:
        server = tcpros_base._tcpros_server.tcp_ros_server
        admit = server.inbound_handler
    except AttributeError:
        warn_of_other('rospy', 'A client that connects and says nothing can lock out all others.')
        return
    turn = threading.Lock()

    def admit_after_header(connection, address):
        with suppress(OSError):  # it has broken down
            if _has_header(connection):
                with turn:
                    if not _has_hung_up(connection):
                        admit(connection, address)
                        return
        connection.close()

    def admit_in_thread(connection, address):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MAX_UNSENT_BYTES)
        with suppress(OSError):
            connection.setsockopt(socket.IPPROTO_TCP, TCP_RTO_MAX_MS, RETRY_MS)
        threading.Thread(target=admit_after_header, args=(connection, address), daemon=True).start()
    server.inbound_handler = admit_in_thread


def _has_header(connection):
    """Wait for the whole header of a new connection, and leave it there to be read. Returns whether it came."""
    end = time.monotonic() + HEADER_S
    start = _peek(connection, LENGTH.size, end)
    if len(start) < LENGTH.size:
        return False
    size = LENGTH.size + LENGTH.unpack(start)[0]
    return size <= MAX_HEADER_BYTES and len(_peek(connection, size, end)) == size


def _peek(connection, size, end):
    """The first ``size`` bytes that arrive, or fewer if more do not come until the monotonic time ``end``."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, size)  # poll is to wait for all of them
    poller = select.poll()
    poller.register(connection, select.POLLIN)
    poller.poll(1000 * max(end - time.monotonic(), 0))
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, 1)
    connection.setblocking(False)
    try:
        return connection.recv(size, socket.MSG_PEEK)
    except BlockingIOError:
        return b''
    finally:
        connection.setblocking(True)


def _has_hung_up(connection):
    poller = select.poll()
    poller.register(connection, select.POLLRDHUP)
    return bool(poller.poll(0))
