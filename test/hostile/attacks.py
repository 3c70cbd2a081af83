"""Attacks on the page's server, one by one, and what a client notices of them who means well."""
import collections
import socket
import threading
import time
from contextlib import ExitStack, contextmanager

from hostile import intruders
from hostile.intruders import WAIT_S, closed, connect, get, say, statuses, upgrade

TOPIC = '/eye/image'  # the camera that there has to be
FLOODS = {'drive': ['{"drive": [1, 0]}'], 'picture': ['{"picture": "x"}'], 'slide': ['{"slide": ["noise", 1]}'],
          'shown': ['{"shown": "/x"}'], 'look': ['{"look": ["/x%d", "%s"]}' % (number, TOPIC * (number % 2))
                                                 for number in range(50)]}
STREAM = b'GET /stream?topic=%s HTTP/1.1\r\nHost: localhost\r\n\r\n' % TOPIC.encode()


class Guest:
    """Who looks at a stream all the time, and now and then at the page."""

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
            pass  # whoever waits for frames notices it

    def is_served(self):
        """Whether three more frames come, and the page."""
        with self._moved:
            wanted = self.frames + 3
            if not self._moved.wait_for(lambda: self.frames >= wanted, WAIT_S):
                return False
        return statuses(get(self.port, '/', WAIT_S)) == [200]

    def close(self):
        self._line.close()


def send(line, data):
    """Send, to a server that may have hung up already."""
    try:
        line.sendall(data)
    except OSError:
        pass  # what that means, others ask


class Attack:
    """What has been sent and answered.

    ``answers``: {status: how often}; ``faults``: sentences; ``held``: connections at once.
    """

    def __init__(self, guest, random):
        self.port, self.guest, self.random = guest.port, guest, random
        self.sent = self.held = 0
        self.answers, self.faults = collections.Counter(), []

    def expect(self, is_so, words):
        if not is_so:
            self.faults.append(words)

    def take(self, name, answer, allowed, most=1):
        """An answer to something raw: at most so many, each with one of these statuses."""
        found = statuses(answer)
        self.sent += 1
        self.answers.update(found)
        self.expect(len(found) <= most and set(found) <= set(allowed), '%s is answered with %s' % (name, found))
        self.expect(not any(secret in answer for secret in intruders.SECRETS), '%s tells what is secret' % name)

    def ask_guest(self, meanwhile):
        self.expect(self.guest.is_served(), 'during %s a good client is not served' % meanwhile)

    def paths(self, share):
        """Addresses that lead out of the folders that are served."""
        for path in intruders.OUTSIDE:
            self.take(path, get(self.port, path), (400, 403, 404))
        self.ask_guest('odd paths')

    def requests(self, share):
        """Requests that are none, or are two, or are much too long."""
        for name, data, most in intruders.requests():
            allowed = 200, 400, 403, 404, 405, 413, 414, 416, 422, 431, 505
            self.take(name, say(self.port, data, 0.1, 1.0), allowed, most)
        self.ask_guest('odd requests')

    def queries(self, share):
        """Queries of odd values."""
        for _ in range(int(400 * share)):
            target = intruders.query(self.random)
            answer = get(self.port, target, WAIT_S if '/stream?' not in target else 0.1)
            self.take(target, answer, (200, 400, 404))
        self.ask_guest('odd queries')

    def bombs(self, share):
        """Uploads that are no picture, or one that would take memory or hours."""
        for name, data in intruders.bombs().items():
            for length in True, False:
                self.take(name, say(self.port, intruders.post(data, length), WAIT_S), (422,))
        self.ask_guest('picture bombs')

    def uploads(self, share):
        """Uploads large and too large, or said to be, and many at once, half of which wait for no answer."""
        self.take('17 MB', say(self.port, intruders.post(bytes(17 << 20)), WAIT_S), (413,))
        self.take('17 MB in chunks', say(self.port, intruders.post(bytes(17 << 20), False), WAIT_S), (413,))
        claim = b'POST /picture HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\nab'
        for size in 17 << 20, 1 << 40, 10**30:
            self.take('%d claimed bytes' % size, say(self.port, claim % size), (400, 413))
        large = intruders.post(intruders.made('JPEG', 64, 64) + bytes(15 << 20))
        for _ in range(20):  # one after the other: nothing may be left of any
            self.take('15 MB', say(self.port, large, WAIT_S), (204, 422))

        def upload(waits):
            with connect(self.port) as line:
                try:
                    line.sendall(large)
                    answer = waits and line.recv(65536)
                except OSError:  # it has hung up
                    answer = b''
            self.take('one upload of many', answer or b'', (204, 422, 503))
        for _ in range(int(5 * share) or 1):
            with ExitStack() as stack:
                for number in range(100):
                    sender = threading.Thread(target=upload, args=(number % 2 == 0,))
                    sender.start()
                    stack.callback(sender.join)
                self.ask_guest('100 uploads at once')

    def frames(self, share):
        """Nonsense on websockets."""
        sayings = [each if isinstance(each, bytes) else each.encode() for each in intruders.SAYINGS]
        for data in [*map(intruders.frame, sayings), *intruders.frames().values()]:
            with upgrade(self.port) as line:
                self.sent += 1
                send(line, data)
        self.ask_guest('nonsense on websockets')

    def floods(self, share):
        """All that can be said on a websocket, again and again, by who does not read."""
        for name, sayings in FLOODS.items():
            data = b''.join(intruders.frame(each.encode()) for each in sayings) * (500 // len(sayings))
            with upgrade(self.port, received=4096) as line:
                done = threading.Event()
                flood = threading.Thread(target=self._flood, args=(line, data, done))
                flood.start()
                end = time.monotonic() + 10 * share
                while True:
                    self.ask_guest('a flood of ' + name)
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
        """Send what goes of data[at:]; where it goes on, or -1 where the server has hung up."""
        try:
            at = (at + line.send(data[at:])) % len(data)
            self.sent += not at
        except socket.timeout:
            return at  # it takes no more for now
        except OSError:
            return -1
        return at

    def crowds(self, share):
        """Hundreds that say nothing, half a request, a slow upload; that take nothing; streams; websockets."""
        half = b'GET / HTTP/1.1\r\nHost: localhost\r\nX: '
        slow = b'POST /picture HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\nab'
        page = b'GET /page/style.css HTTP/1.1\r\nHost: localhost\r\n\r\n'
        crowds = [('silent', b'', max(300, int(1000 * share))), ('half a request', half, 300),
                  ('slow uploads', slow, 300), ('takers of nothing', page * 100, 100), ('streams', STREAM, 300)]
        for name, data, count in crowds:
            with self._crowd(data, count) as lines:
                for _ in range(1 + int(2 * share)):
                    for line in lines:
                        send(line, b'' if not data or data.endswith(b'\r\n') else b'a')
                    self.ask_guest('%d %s' % (count, name))
                if name == 'streams':
                    self.expect(sum(map(closed, lines)) < count, 'all streams are gone')
        lines = [upgrade(self.port) for _ in range(200)]
        self.sent += len(lines)
        self.held = max(self.held, len([line for line in lines if line]))
        self.expect(0 < len([line for line in lines if line]) < 200, 'there are any number of websockets')
        self.ask_guest('200 websockets')
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
