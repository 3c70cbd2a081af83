"""A publisher that does not outrun its subscribers."""
import socket
import struct
import time
import warnings

import rospy

STUCK_S = 300


class PacedPublisher(rospy.Publisher):
    """Publishes a message after all subscribers on this machine have read the one before.

    Otherwise subscribers of rospy skip all but the newest message. The publisher asks the kernel, by the
    sock_diag interface of netlink, how many bytes wait to be read at the other ends.
    """

    def __init__(self, topic, kind, listener=None, latch=False):
        with warnings.catch_warnings():
            # Without a queue, publish returns after everything is sent, but rospy warns.
            warnings.simplefilter('ignore')
            super().__init__(topic, kind, listener, latch=latch)
        self._kernel = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 4)

    def publish(self, message):
        """Raises RuntimeError if a subscriber does not read the message within STUCK_S."""
        super().publish(message)
        end = time.monotonic() + STUCK_S
        while any(self._unread(each.socket) for each in self.impl.connections):
            time.sleep(0.0005)
            if time.monotonic() > end:
                raise RuntimeError('a message has not been read for %d s' % STUCK_S)

    def _unread(self, connection):
        """The number of bytes that wait to be read at the other end."""
        try:
            (address, port), (other, other_port) = connection.getsockname(), connection.getpeername()
        except (AttributeError, OSError):  # closed in the meantime
            return 0
        wanted = struct.pack('=BBBBI', socket.AF_INET, socket.IPPROTO_TCP, 0, 0, 0xffffffff) + \
            struct.pack('>HH16s16s', other_port, port, socket.inet_aton(other), socket.inet_aton(address)) + \
            struct.pack('=I8s', 0, b'\xff' * 8)
        self._kernel.send(struct.pack('=IHHII', 16 + len(wanted), 20, 1, 0, 0) + wanted)
        answer = self._kernel.recv(1 << 16)
        is_found = struct.unpack_from('=H', answer, 4)[0] == 20
        return struct.unpack_from('=I', answer, 16 + 56)[0] if is_found else 0
