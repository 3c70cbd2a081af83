"""The page's server against hostile clients: what it answers, holds and takes, and whom it serves meanwhile."""
import ipaddress
import random
import sys
import time
from contextlib import ExitStack, contextmanager, suppress

import psutil
import rospy
from aruco_node.messages.images import image_from_frame
from hostile.page import attacks
from hostile.page import client as intruders
from master import Master
from rig.page.server import PICTURE, free_port
from rig.processes.sockets import sockets_below
from rig.processes.started import Started
from sensor_msgs.msg import Image
from std_msgs.msg import Header

# More than before an attack: two uploads; connections to the master, until Python collects them.
MORE_MB, MORE_FDS = 128, 64
REST_S = 10                  # for which it may have more
LIMITS = {  # seconds within which who is slow is given up; page_server's are 20, 60, 30
    'says nothing': (b'', 30), 'a byte of a header a second': (b'GET / HTTP/1.1\r\nX: ', 30),
    'a byte of an upload a second': (
        b'POST /picture HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n', 75),
    'takes no answer': (b'GET /page/page.js HTTP/1.1\r\nHost: localhost\r\n\r\n' * 100, 75),
    'takes no stream': (attacks.STREAM, 75)}


def run(seconds, seed):
    """Print what each attack sent and what became of the server."""
    found = []
    print('Target: no 5xx but 503, pictures and the page for a good client during all of it; afterward, within '
          '%d s, at most %d MB and %d file descriptors more.\n' % (REST_S, MORE_MB, MORE_FDS))
    with Master(), camera():
        with server() as (page, port):
            found += listening()
            found += describe(port, seed, 20)
            end = None if seconds is None else time.monotonic() + seconds
            while True:
                for name in attacks.ATTACKS:
                    found += attack(name, page, port, seed)
                found += slow(page, port)
                seed += 1
                if end is None or time.monotonic() > end:
                    break
        found += ['the log says: ' + line for line in page.lines
                  if 'Traceback' in line or line.startswith(intruders.FORGED)]
    return found


@contextmanager
def camera():
    """Pictures on attacks.TOPIC, 30 a second."""
    publisher = rospy.Publisher(attacks.TOPIC, Image, queue_size=1)
    timer = rospy.Timer(rospy.Duration(1 / 30), lambda event: publisher.publish(
        image_from_frame(PICTURE, Header(stamp=rospy.Time.now()))))
    yield
    timer.shutdown()


@contextmanager
def server():
    """(the page, Started, with its psutil.Process as ``figures``; its port)."""
    port = free_port()
    page = Started('rosrun', 'unit5', 'page.py', '_port:=%d' % port)
    try:
        page.wait_for('The page is at')
        process = psutil.Process(page.process.pid)
        page.figures = next(each for each in [process, *process.children(recursive=True)]
                            if any(word.endswith('page.py') for word in each.cmdline()[:2]))
        yield page, port
    finally:
        page.stop()


def listening():
    """Print which addresses all that runs here listens on; a list of those that the network reaches."""
    found = sockets_below(psutil.Process().pid)
    sockets = [(name, address) for name, each in found.items() for _, address in each]
    open_ = sorted({'%s listens on %s' % (name, address) for name, address in sockets
                    if not ipaddress.ip_address(address).is_loopback})
    print('%d sockets of %s listen, %d of them to the network' % (
        len(sockets), ', '.join(sorted({str(name) for name, _ in sockets})), len(open_)), flush=True)
    return open_


def attack(name, page, port, seed):
    """Print a row about one attack; a list of what was found."""
    guest = attacks.Guest(port)
    if not guest.is_served():
        return ['before %s a good client is not served' % name]
    one, began = attacks.Attack(guest, random.Random(seed)), time.monotonic()
    frames, before = guest.frames, figures(page)
    getattr(one, name)(1.0)
    took, frames = time.monotonic() - began, guest.frames - frames
    guest.close()
    most = [before[0] + MORE_MB, before[1] + MORE_FDS, before[2] + 8]
    end = time.monotonic() + REST_S
    while any(now > limit for now, limit in zip(figures(page), most)) and time.monotonic() < end:
        time.sleep(0.2)
    after = figures(page)
    print('%-9s %7d sent in %4.0f s, %4d held at once; answers %s; %d to %d MB, %d to %d file descriptors, '
          '%d to %d threads; %.0f frames a second to a good client' % (
              name, one.sent, took, one.held, dict(sorted(one.answers.items())), *(
                  figure for pair in zip(before, after) for figure in pair), frames / took), flush=True)
    kinds = 'MB', 'file descriptors', 'threads'
    return one.faults + ['after %s the server has %d %s, before %d' % (name, now, kind, was)
                         for was, now, limit, kind in zip(before, after, most, kinds) if now > limit]


def figures(page):
    """(MB, file descriptors, threads) of the server."""
    return page.figures.memory_info().rss / 1e6, page.figures.num_fds(), page.figures.num_threads()


def describe(port, seed, count):
    """Print what schemathesis found; a list of it."""
    if sys.version_info < (3, 10):
        print('schemathesis needs Python 3.10 and later; what the page says of itself is not tried.')
        return []
    from hostile.page import openapi as described
    answers, faults = described.ask(port, seed, count, {
        'topic': [attacks.TOPIC], 'file': ['page.js', 'openapi.yaml'], 'name': ['earth.jpg']})
    print('described %7d sent by schemathesis to %d addresses and methods; answers %s, %d not as described' % (
        sum(answers.values()), len({answer[:2] for answer in answers}), dict(sorted(
            (status, sum(number for answer, number in answers.items() if answer[2] == status))
            for status in {answer[2] for answer in answers})), len(faults)), flush=True)
    return faults


def connections(process):
    """What a process has open to the network."""
    # Its name, and that before psutil 6.
    ask = process.net_connections if hasattr(process, 'net_connections') else process.connections
    return ask('inet')


def slow(page, port):
    """Print after what time who is slow is given up; a list of those who were not."""
    found = []
    with ExitStack() as stack:
        lines, began = {}, time.monotonic()
        for name, (data, _) in LIMITS.items():
            lines[name] = stack.enter_context(intruders.connect(port, received=4096))
            lines[name].sendall(data)
        while lines:
            time.sleep(1.0)
            took = time.monotonic() - began
            held = {each.raddr.port for each in connections(page.figures) if each.raddr}
            for name, line in list(lines.items()):
                data, limit = LIMITS[name]
                if line.getsockname()[1] not in held:
                    print('%-30s is given up after %4.1f s' % (name, took), flush=True)
                    del lines[name]
                elif took > limit:
                    found.append('%s is not given up within %d s' % (name, limit))
                    del lines[name]
                elif name.startswith('a byte'):
                    with suppress(OSError):  # it has hung up just now
                        line.send(b'a')
    return found
