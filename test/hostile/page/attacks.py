"""Attacks on the page's server, and what a well-meaning client notices of them."""
import collections
import socket
import threading
import time
from contextlib import ExitStack, contextmanager

from rig.processes.started import WAIT_S

from hostile.page import client
from hostile.page.client import closed, connect, get, say, statuses, upgrade

TOPIC = '/eye/image'  # the tests must publish images on it
FLOODS = {'drive': ['{"drive": [1, 0]}'], 'picture': ['{"picture": "x"}'], 'slide': ['{"slide": ["noise", 1]}'],
          'write': ['{"write": ["dictionary", "DICT_%dX%d_50"]}' % (cells, cells) for cells in (4, 5)],
          'shown': ['{"shown": "/x"}'], 'look': ['{"look": ["/x%d", "%s"]}' % (number, TOPIC * (number % 2))
                                                 for number in range(50)]}
STREAM = b'GET /stream?topic=%s HTTP/1.1\r\nHost: localhost\r\n\r\n' % TOPIC.encode()


class Guest:
    """A well-meaning client that watches a stream, and now and then asks for the page."""

    def __init__(self, port):
        self.port, self.frames = port, 0
        self._line = connect(port)
        self._line.sendall(STREAM)
        self._moved = threading.Condition()
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self):
        try:
            for data in iter(lambda: self._line.recv(1 << 20), b''):
                with self._moved:
                    self.frames += data.count(b'\xff\xd8\xff')
                    self._moved.notify_all()
        except OSError:
            pass  # is_served notices it, since no frames come

    def is_served(self):
        """Whether three more frames and the page arrive."""
        with self._moved:
            wanted = self.frames + 3
            if not self._moved.wait_for(lambda: self.frames >= wanted, WAIT_S):
                return False
        return statuses(get(self.port, '/', WAIT_S)) == [200]

    def close(self):
        self._line.close()


def send(line, data):
    """Send data to a server that may already have hung up."""
    try:
        line.sendall(data)
    except OSError:
        pass  # the caller checks what follows from it


class Attack:
    """One run of the attacks, and what the server answered.

    ``answers``: {status: count}. ``faults``: sentences. ``held``: the most connections that were open at once.
    """

    def __init__(self, guest, random):
        self.port, self.guest, self.random = guest.port, guest, random
        self.sent = self.held = 0
        self.answers, self.faults = collections.Counter(), []

    def expect(self, is_so, words):
        if not is_so:
            self.faults.append(words)

    def check(self, name, answer, allowed, most=1):
        """Check an answer to a raw request: it has at most ``most`` parts, each with an allowed status."""
        found = statuses(answer)
        self.sent += 1
        self.answers.update(found)
        self.expect(len(found) <= most and set(found) <= set(allowed), '%s is answered with %s' % (name, found))
        self.expect(not any(secret in answer for secret in client.SECRETS), '%s reveals a secret' % name)

    def check_guest(self, meanwhile):
        self.expect(self.guest.is_served(), 'a well-meaning client is not served during %s' % meanwhile)

    def paths(self, share):
        """Addresses outside of the folders that the server serves."""
        for path in client.OUTSIDE:
            self.check(path, get(self.port, path), (400, 403, 404))
        self.check_guest('odd paths')

    def requests(self, share):
        """Requests that are malformed, ambiguous, or much too long."""
        for name, data, most in client.requests():
            allowed = 200, 400, 403, 404, 405, 413, 414, 416, 422, 431, 505
            self.check(name, say(self.port, data, 0.1, 1.0), allowed, most)
        self.check_guest('odd requests')

    def queries(self, share):
        """Queries with odd values."""
        for _ in range(int(400 * share)):
            target = client.query(self.random)
            answer = get(self.port, target, WAIT_S if '/stream?' not in target else 0.1)
            self.check(target, answer, (200, 400, 404))
        self.check_guest('odd queries')

    def bombs(self, share):
        """Uploads that are not pictures, or would take too much memory or time."""
        for name, data in client.bombs().items():
            for length in True, False:
                self.check(name, say(self.port, client.post(data, length), WAIT_S), (422,))
        self.check_guest('picture bombs')

    def uploads(self, share):
        """Large uploads, too large ones, false lengths, and many at once, half of which do not wait."""
        self.check('17 MB', say(self.port, client.post(bytes(17 << 20)), WAIT_S), (413,))
        self.check('17 MB in chunks', say(self.port, client.post(bytes(17 << 20), False), WAIT_S), (413,))
        claim = b'POST /picture HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\nab'
        for size in 17 << 20, 1 << 40, 10**30:
            self.check('%d claimed bytes' % size, say(self.port, claim % size), (400, 413))
        large = client.post(client.made('JPEG', 64, 64) + bytes(15 << 20))
        for _ in range(20):  # one after the other, since nothing may be left of any
            self.check('15 MB', say(self.port, large, WAIT_S), (204, 422))

        def upload(waits):
            with connect(self.port) as line:
                try:
                    line.sendall(large)
                    answer = waits and line.recv(65536)
                except OSError:  # the server has hung up
                    answer = b''
            self.check('one upload of many', answer or b'', (204, 422, 503))
        for _ in range(int(5 * share) or 1):
            with ExitStack() as stack:
                for number in range(100):
                    sender = threading.Thread(target=upload, args=(number % 2 == 0,))
                    sender.start()
                    stack.callback(sender.join)
                self.check_guest('100 uploads at once')

    def frames(self, share):
        """Nonsense on websockets."""
        sayings = [each if isinstance(each, bytes) else each.encode() for each in client.SAYINGS]
        for data in [*map(client.frame, sayings), *client.frames().values()]:
            with upgrade(self.port) as line:
                self.sent += 1
                send(line, data)
        self.check_guest('nonsense on websockets')

    def floods(self, share):
        """Messages of all kinds on a websocket, again and again, by a client that does not read."""
        for name, sayings in FLOODS.items():
            data = b''.join(client.frame(each.encode()) for each in sayings) * (500 // len(sayings))
            with upgrade(self.port, received=4096) as line:
                done = threading.Event()
                flood = threading.Thread(target=self._flood, args=(line, data, done))
                flood.start()
                end = time.monotonic() + 10 * share
                while True:
                    self.check_guest('a flood of ' + name)
                    if time.monotonic() > end:
                        break
                done.set()
                flood.join()

    def _flood(self, line, data, done):
        line.settimeout(0.5)
        at = 0
        while not done.is_set() and not at < 0:
            at = self._part(line, data, at)

    def _part(self, line, data, at):
        """Send a part of data[at:]; returns where to continue, or -1 if the server has hung up."""
        try:
            at = (at + line.send(data[at:])) % len(data)
            self.sent += not at
        except socket.timeout:
            return at  # it takes no more for now
        except OSError:
            return -1
        return at

    def crowds(self, share):
        """Hundreds of clients: silent, slow, or not reading; also hundreds of streams and websockets."""
        half = b'GET / HTTP/1.1\r\nHost: localhost\r\nX: '
        slow = b'POST /picture HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\nab'
        page = b'GET /page/style.css HTTP/1.1\r\nHost: localhost\r\n\r\n'
        crowds = [('silent', b'', max(300, int(1000 * share))), ('half requests', half, 300),
                  ('slow uploads', slow, 300), ('not reading', page * 100, 100), ('streams', STREAM, 300)]
        for name, data, count in crowds:
            with self._crowd(data, count) as lines:
                for _ in range(1 + int(2 * share)):
                    for line in lines:
                        send(line, b'' if not data or data.endswith(b'\r\n') else b'a')
                    self.check_guest('%d %s' % (count, name))
                if name == 'streams':
                    self.expect(sum(map(closed, lines)) < count, 'no stream is left')
        lines = [upgrade(self.port) for _ in range(200)]
        self.sent += len(lines)
        self.held = max(self.held, len([line for line in lines if line]))
        self.expect(0 < len([line for line in lines if line]) < 200, 'the number of websockets is not limited')
        self.check_guest('200 websockets')
        for line in filter(None, lines):
            line.close()

    @contextmanager
    def _crowd(self, data, count):
        with ExitStack() as stack:
            lines = [stack.enter_context(connect(self.port, received=4096)) for _ in range(count)]
            for line in lines:
                send(line, data)
            self.sent += count
            yield lines
            self.held = max(self.held, sum(not closed(line) for line in lines))

ATTACKS = 'paths', 'requests', 'queries', 'bombs', 'uploads', 'frames', 'floods', 'crowds'
