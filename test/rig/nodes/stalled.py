"""Subscribers that connect and then stall."""
import socket
import struct
from xmlrpc.client import ServerProxy

from rosgraph.network import write_ros_handshake_header

from rig.processes.started import WAIT_S


class HalfOpen:
    """Connects to a topic of a node, and then sends nothing."""

    def __init__(self, uri, topic):
        """``uri``: that of the node's XML-RPC server."""
        code, _, (_, host, port) = ServerProxy(uri).requestTopic('/stalled', topic, [['TCPROS']])
        assert code == 1
        self._socket = socket.create_connection((host, port), WAIT_S)

    def unregister(self):
        self._socket.close()


class Stalled(HalfOpen):
    """A subscriber that does not read a topic's messages until ``read`` is called."""

    def __init__(self, uri, topic, kind):
        super().__init__(uri, topic)
        self._kind = kind
        write_ros_handshake_header(self._socket, {
            'topic': topic, 'type': kind._type, 'md5sum': kind._md5sum, 'callerid': '/stalled',
            'message_definition': kind._full_text})
        self._stream = self._socket.makefile('rb')
        self._read()  # the header that the node sends

    def read(self):
        """Read the next message."""
        return self._kind().deserialize(self._read())

    def _read(self):
        length, = struct.unpack('<I', self._stream.read(4))
        return self._stream.read(length)

    def unregister(self):
        self._stream.close()
        super().unregister()
