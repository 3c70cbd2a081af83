"""The page's server with hostile clients: its answers, its resources, and its service for a good client."""
import ipaddress
import random
import sys
import time
from contextlib import ExitStack, contextmanager, suppress

import psutil
import rospy
from aruco_node.messages.images import image_from_frame
from hostile.page import attacks, client
from rig.nodes.master import Master
from rig.page.server import PICTURE, free_port
from rig.processes.sockets import sockets_below
from rig.processes.started import Started
from sensor_msgs.msg import Image
from std_msgs.msg import Header

# Allowed growth after an attack: two uploads, and connections to the master that Python has not yet freed.
MORE_MB, MORE_FDS = 128, 64
RECOVERY_S = 10              # seconds after an attack, within which this must be reached
LIMITS = {  # what slow clients send, and the seconds until they must be cut off; page_server waits 20, 60, 30
    'sends nothing': (b'', 30), 'a byte of a header per second': (b'GET / HTTP/1.1\r\nX: ', 30),
    'a byte of an upload per second': (
        b'POST /picture HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n', 75),
    'reads no answer': (b'GET /page/page.js HTTP/1.1\r\nHost: localhost\r\n\r\n' * 100, 75),
    'reads no stream': (attacks.STREAM, 75)}


def run(seconds, seed):
    """Attack the server, and print the effects of each attack. Returns sentences about what was found."""
    found = []
    print('Targets: no status 5xx but 503; images and the page for a good client all the time; within %d s\n'
          'after an attack, at most %d MB and %d file descriptors more than before.\n'
          % (RECOVERY_S, MORE_MB, MORE_FDS))
    with Master(), camera():
        with server() as (page, port):
            found += open_sockets()
            found += run_schemathesis(port, seed, 20)
            end = None if seconds is None else time.monotonic() + seconds
            while True:
                for name in attacks.ATTACKS:
                    found += attack(name, page, port, seed)
                found += slow_clients(page, port)
                seed += 1
                if end is None or time.monotonic() > end:
                    break
        found += ['the log says: ' + line for line in page.lines
                  if 'Traceback' in line or line.startswith(client.FORGED)]
    return found


@contextmanager
def camera():
    """Publish 30 images per second on attacks.TOPIC while the block runs."""
    publisher = rospy.Publisher(attacks.TOPIC, Image, queue_size=1)
    timer = rospy.Timer(rospy.Duration(1 / 30), lambda event: publisher.publish(
        image_from_frame(PICTURE, Header(stamp=rospy.Time.now()))))
    yield
    timer.shutdown()


@contextmanager
def server():
    """Run the page while the block runs. Yields it, Started, and its port.

    ``page.server`` is its psutil.Process.
    """
    port = free_port()
    page = Started('rosrun', 'unit5', 'page.py', '_port:=%d' % port)
    try:
        page.wait_for('The page is at')
        process = psutil.Process(page.process.pid)
        page.server = next(each for each in [process, *process.children(recursive=True)]
                           if any(word.endswith('page.py') for word in each.cmdline()[:2]))
        yield page, port
    finally:
        page.stop()


def open_sockets():
    """Print which sockets of the processes here listen. Returns sentences about those open to the network."""
    found = sockets_below(psutil.Process().pid)
    sockets = [(name, address) for name, each in found.items() for _, address in each]
    exposed = sorted({'%s listens on %s' % (name, address) for name, address in sockets
                    if not ipaddress.ip_address(address).is_loopback})
    print('%d sockets of %s listen, %d of them to the network' % (
        len(sockets), ', '.join(sorted({str(name) for name, _ in sockets})), len(exposed)), flush=True)
    return exposed


def attack(name, page, port, seed):
    """Run one attack, and print a row about it. Returns sentences about what was found."""
    guest = attacks.Guest(port)
    if not guest.is_served():
        return ['before %s, a good client is not served' % name]
    attacker, began = attacks.Attack(guest, random.Random(seed)), time.monotonic()
    frames, before = guest.frames, resources(page)
    getattr(attacker, name)(1.0)
    took, frames = time.monotonic() - began, guest.frames - frames
    guest.close()
    most = [before[0] + MORE_MB, before[1] + MORE_FDS, before[2] + 8]
    end = time.monotonic() + RECOVERY_S
    while any(now > limit for now, limit in zip(resources(page), most)) and time.monotonic() < end:
        time.sleep(0.2)
    after = resources(page)
    print('%-9s %7d sent in %4.0f s, %4d connections at once; answers %s; %d to %d MB, %d to %d file '
          'descriptors, %d to %d threads; %.0f frames per second to a good client' % (
              name, attacker.sent, took, attacker.held, dict(sorted(attacker.answers.items())), *(
                  figure for pair in zip(before, after) for figure in pair), frames / took), flush=True)
    kinds = 'MB', 'file descriptors', 'threads'
    return attacker.faults + ['after %s, the server has %d %s, but before only %d' % (name, now, kind, was)
                              for was, now, limit, kind in zip(before, after, most, kinds) if now > limit]


def resources(page):
    """(MB, file descriptors, threads) of the server."""
    return page.server.memory_info().rss / 1e6, page.server.num_fds(), page.server.num_threads()


def run_schemathesis(port, seed, count):
    """Run schemathesis, and print a row about it. Returns sentences about what was found."""
    if sys.version_info < (3, 10):
        print('schemathesis needs Python 3.10 or later, so the description of the page is not tested.')
        return []
    from hostile.page import openapi
    answers, faults = openapi.ask(port, seed, count, {
        'topic': [attacks.TOPIC], 'file': ['page.js', 'openapi.yaml'], 'name': ['earth.jpg']})
    print('described %7d sent by schemathesis to %d addresses and methods; answers %s, %d not as described' % (
        sum(answers.values()), len({answer[:2] for answer in answers}), dict(sorted(
            (status, sum(number for answer, number in answers.items() if answer[2] == status))
            for status in {answer[2] for answer in answers})), len(faults)), flush=True)
    return faults


def connections(process):
    """The internet connections of a process."""
    # Before psutil 6, it has another name.
    ask = process.net_connections if hasattr(process, 'net_connections') else process.connections
    return ask('inet')


def slow_clients(page, port):
    """Print after how long slow clients are cut off. Returns sentences about those that are not."""
    found = []
    with ExitStack() as stack:
        clients, began = {}, time.monotonic()
        for name, (data, _) in LIMITS.items():
            clients[name] = stack.enter_context(client.connect(port, received=4096))
            clients[name].sendall(data)
        while clients:
            time.sleep(1.0)
            took = time.monotonic() - began
            held = {each.raddr.port for each in connections(page.server) if each.raddr}
            for name, socket in list(clients.items()):
                data, limit = LIMITS[name]
                if socket.getsockname()[1] not in held:
                    print('%-30s cut off after %4.1f s' % (name, took), flush=True)
                    del clients[name]
                elif took > limit:
                    found.append('a slow client (%s) is not cut off within %d s' % (name, limit))
                    del clients[name]
                elif name.startswith('a byte'):
                    with suppress(OSError):  # the server has just hung up
                        socket.send(b'a')
    return found
