"""The base of the rostests of the page's server: it starts the server on a free port, and sends requests."""
import random
import socket
import unittest
import urllib.error
import urllib.request
from contextlib import suppress

import numpy as np

from rig.processes.started import WAIT_S, Started

PICTURE = np.zeros((480, 640, 3), np.uint8)
PICTURE[:, :320] = (200, 60, 20)
PICTURE[100:200, 400:500] = np.random.RandomState(1).randint(0, 255, (100, 100, 3))


def free_port():
    """A port of this machine that is free, and most likely stays so until the caller uses it.

    The system gives ports above these to whoever asks for any, such as each node and each connection.
    """
    while True:
        port = random.randrange(15000, 30000)
        with socket.socket() as probe, suppress(OSError):
            probe.bind(('127.0.0.1', port))
            return port


def ask(port, path, data=None, **headers):
    """Send a request to the server; returns (status, headers, body)."""
    request = urllib.request.Request('http://127.0.0.1:%d%s' % (port, path), data,
                                     {name.replace('_', '-'): value for name, value in headers.items()})
    try:
        with urllib.request.urlopen(request, timeout=WAIT_S) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read()


class ServerTest(unittest.TestCase):
    """Starts the page's server at ``port``."""

    @classmethod
    def setUpClass(cls):
        cls.port = free_port()
        cls.server = Started('roslaunch', 'unit5', 'page.launch', 'port:=%d' % cls.port)
        cls.server.wait_for('The page is at http://localhost:%d (driving is on)' % cls.port)

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
