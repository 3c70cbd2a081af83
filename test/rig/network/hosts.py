"""Hosts for a base station and robots: network namespaces of this machine, with a poor link to each robot."""
import json
import os
import subprocess
import sys
from contextlib import ExitStack, contextmanager

from rig.processes.skip import skip

BASE, BASE_ADDRESS, ROBOT_ADDRESS = 'base', '10.55.0.1', '10.55.0.%d'
LINK = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'link.py')
DELAY_S, LOSS, RATE = 0.030, 0.01, '20mbit'  # of each link, in each direction
QUEUE_S = 0.1                                # the longest that a packet waits at its entrance; others are lost


class Host:
    """A network namespace with an address."""

    def __init__(self, name, address, master):
        self.name, self.address = name, address
        self._namespace = 'unit5-%d-%s' % (os.getpid(), name)
        self._variables = ['ROS_IP=' + address, 'ROS_MASTER_URI=http://%s:11311' % master, 'PYTHONUNBUFFERED=1']

    def command(self, *command):
        """The command with its environment, to be run on this host, as arguments of Popen or Started."""
        # The variables that script/env sets would keep all connections on the host itself.
        return ['ip', 'netns', 'exec', self._namespace, 'env', '-u', 'ROS_HOSTNAME', '-u', 'LD_PRELOAD',
                *self._variables, *command]

    def bytes_to(self, device):
        """The number of bytes sent through a device so far."""
        output = _ip('-n', self._namespace, '-s', '-j', 'link', 'show', 'dev', device)
        return json.loads(output)[0]['stats64']['tx']['bytes']


class Radio:
    """The link between a robot and the base."""

    def __init__(self, process):
        self._process = process

    def set(self, up):
        """Let the link carry packets, or drop them all."""
        self._process.stdin.write('up\n' if up else 'down\n')
        self._process.stdin.flush()
        self._process.stdout.readline()


@contextmanager
def hosts(robots, loss=LOSS):
    """The Hosts of a base station and of some robots, the base first, and each robot's Radio, during the block.

    The ROS master belongs on the base. Raises OSError or CalledProcessError if hosts cannot be created.
    """
    with ExitStack() as stack:
        base = Host(BASE, BASE_ADDRESS, BASE_ADDRESS)
        made, radios = [base], []
        stack.enter_context(_namespace(base))
        for number in range(robots):
            robot = Host('robot%d' % (number + 1), ROBOT_ADDRESS % (11 + number), BASE_ADDRESS)
            stack.enter_context(_namespace(robot))
            radios.append(stack.enter_context(_radio(base, robot, loss)))
            made.append(robot)
        yield made, radios


def enter_or_skip(test, context):
    """Enter a context manager until the test ends, or skip the test if hosts cannot be created."""
    stack = ExitStack()
    try:
        given = stack.enter_context(context)
    except (OSError, subprocess.CalledProcessError) as error:
        skip(test.id(), 'network namespaces with tunnels cannot be created here: %s' % error)
    test.addCleanup(stack.close)
    return given


@contextmanager
def _namespace(host):
    name = host._namespace
    _ip('netns', 'add', name)
    try:
        _ip('-n', name, 'link', 'set', 'lo', 'up')
        _ip('-n', name, 'addr', 'add', host.address + '/32', 'dev', 'lo')
        yield
    finally:
        _ip('netns', 'del', name)


@contextmanager
def _radio(base, robot, loss):
    process = subprocess.Popen(
        [sys.executable, LINK, base._namespace, robot.name, robot._namespace, BASE, str(DELAY_S), str(loss)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        if process.stdout.readline() != 'ready\n':
            raise OSError('there is no link between %s and %s' % (base.name, robot.name))
        for host, device, other in (base, robot.name, robot), (robot, BASE, base):
            _ip('-n', host._namespace, 'link', 'set', device, 'up', 'mtu', '1500')
            _ip('-n', host._namespace, 'route', 'add', other.address, 'dev', device, 'src', host.address)
            subprocess.check_call(['tc', '-n', host._namespace, 'qdisc', 'add', 'dev', device, 'root', 'tbf',
                                   'rate', RATE, 'burst', '16kb', 'latency', '%dms' % (1000 * QUEUE_S)])
        yield Radio(process)
    finally:
        process.stdin.close()
        process.wait()
        process.stdout.close()


def _ip(*words):
    return subprocess.run(['ip', *words], stdout=subprocess.PIPE, check=True, text=True).stdout
