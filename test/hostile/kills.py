"""Kills programs of the package at random moments, and looks for what they leave behind."""
import os
import signal
import subprocess
import tempfile
import threading
import time
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from itertools import count

import cv2
import psutil
import rospy
from aruco_node.messages.images import image_from_frame
from rig import PACKAGE
from rig.nodes.case import CAMERA, IMAGES, NODES, scene
from rig.page.server import free_port
from rig.processes.started import WAIT_S, program
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger

MARK = 'UNIT5_STRUCK'
ENDS_S = WAIT_S  # roslaunch waits 15 s for its nodes before it kills them
SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
TOOLS = {'artag_generator': ['--ids', '0-249', '--format', 'png', '--size', '400', '--output', '.'],
         'artag_generator of a sheet': ['--ids', '0-249', '--sheet', 'tags.pdf'],
         'gazebo_wall': ['--output', '.']}
LAUNCHES = {'roslaunch exercise5_6.launch': [], 'roslaunch all.launch': []}
DEMO = 'script/demo'
NUMBERS = count()


@dataclass
class Kill:
    """A program and how it is killed. ``watched``: whether somebody subscribes to it and asks for snapshots."""

    name: str
    signal: signal.Signals
    delay: float
    watched: bool = False

    def __str__(self):
        return '%s, %s after %.2f s%s' % (self.name, self.signal.name, self.delay, ', watched' * self.watched)


def kills(random, names=(*NODES, *TOOLS, *LAUNCHES, DEMO)):
    """Yields Kills without end: every name with every signal equally often. ``random``: a random.Random."""
    while True:
        ways = [(name, kind) for name in names for kind in SIGNALS
                # roslaunch leaves its nodes behind if it gets SIGKILL.
                if not (name in LAUNCHES and kind == signal.SIGKILL)]
        random.shuffle(ways)
        for name, kind in ways:
            shortest, longest = (0, 4) if name in NODES else (0, 1.5) if name in TOOLS else (0, 25)
            if name in LAUNCHES:
                shortest, longest = 2, 10  # roslaunch ignores a Ctrl-C while it starts
            watched = name in IMAGES and random.random() < 0.7
            yield Kill(name, kind, random.uniform(shortest, longest), watched)


def command_of(name):
    """(words, namespace): the command that starts a program, and a namespace of its own."""
    space = 'struck_%d' % next(NUMBERS)  # nodes with the same name would end each other
    if name in NODES:
        return [program(name + '.py'), 'camera/rgb/image_raw:=' + CAMERA, '_folder:=.',
                '_port:=%d' % free_port()], space
    if name in TOOLS:
        return [program(name.split()[0] + '.py'), *TOOLS[name]], space
    if name in LAUNCHES:
        return [*name.replace(' ', ' unit5 ').split(), 'camera:=' + CAMERA], space
    return [os.path.join(PACKAGE, DEMO), '--seconds', '30', '--folder', 'demo'], ''


def strike(kill):
    """Start a program and kill it; returns the seconds until it ended, and sentences about what it left."""
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile('w+') as output:
        words, space = command_of(kill.name)
        mark = '%s=%s' % (MARK, folder)
        variables = dict(os.environ, PYTHONFAULTHANDLER='1', ROS_NAMESPACE=space, **{MARK: folder})
        process = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                   cwd=folder, env=variables, start_new_session=True)
        with watched(space, kill.name) if kill.watched else nullcontext():
            time.sleep(kill.delay)
            began = time.monotonic()
            found = []
            if kill.signal == signal.SIGINT:
                os.killpg(process.pid, signal.SIGINT)  # as a terminal does
            else:
                process.send_signal(kill.signal)
            try:
                code = process.wait(ENDS_S)
            except subprocess.TimeoutExpired:
                code = None
                process.send_signal(signal.SIGABRT)  # makes Python print where it is
                process.wait()
                output.seek(0)
                found.append('it did not end within %d s:\n%s' % (ENDS_S, output.read()))
            took = time.monotonic() - began
        left = kill_leftovers(mark)
        if left:
            found.append('these processes are left: ' + ', '.join(' '.join(each) for each in left))
        output.seek(0)
        printed = output.read()
        # A traceback without lines of the package comes from the start of Python itself.
        has_started = 'Traceback' not in printed or PACKAGE + '/src' in printed or PACKAGE + '/nodes' in printed
        if has_started and 'Traceback' in printed:
            found.append('it printed:\n' + printed[-3000:])
        # Python, rospy, bash and roslaunch use these exit codes for the signal; 0 means it had already ended.
        if has_started and code not in (0, -kill.signal, 128 + kill.signal, None):
            found.append('its exit code is %d; it printed:\n%s' % (code, printed[-1000:]))
        found += ['this file is left: ' + path for path in halves(folder)]
        return took, ['%s: %s' % (kill, each) for each in found]


def kill_leftovers(mark, seconds=ENDS_S):
    """Kill the processes with that variable that do not end by themselves in time; returns their commands."""
    end = time.monotonic() + seconds
    while True:
        marked = [each for each in psutil.process_iter() if _has_variable(each, mark)]
        if not marked or time.monotonic() > end:
            break
        time.sleep(0.1)
    commands = []
    for each in marked:
        with suppress(psutil.NoSuchProcess):
            commands.append(each.cmdline())
            each.kill()
    return commands


def _has_variable(process, mark):
    try:
        with open('/proc/%d/environ' % process.pid) as file:
            return mark in file.read().split('\0')
    except OSError:  # the process has ended, or belongs to somebody else
        return False


def halves(folder):
    """The paths of hidden files, and of pictures and PDFs that are incomplete."""
    found = []
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            if name.startswith('.'):
                found.append(path)
            elif name.endswith('.png'):
                with open(path, 'rb') as file:
                    if b'IEND' not in file.read()[-12:] or cv2.imread(path) is None:
                        found.append(path)
            elif name.endswith('.pdf'):
                with open(path, 'rb') as file:
                    if not file.read().rstrip().endswith(b'%%EOF'):
                        found.append(path)
    return found


@contextmanager
def watched(space, name):
    """Subscribe to the images of a node in a namespace, and ask it for snapshots all the time."""
    stopped = threading.Event()
    subscriber = rospy.Subscriber('/' + space + IMAGES[name], Image, lambda message: None, queue_size=1)

    def ask():
        while not stopped.wait(0.02):
            with suppress(Exception):  # the service does not exist yet, or no longer
                rospy.ServiceProxy('/%s/%s/snapshot' % (space, name), Trigger)()
    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    try:
        yield
    finally:
        stopped.set()
        asking.join(WAIT_S)
        subscriber.unregister()


@contextmanager
def camera():
    """Publish frames, 30 per second, during the block."""
    publisher = rospy.Publisher(CAMERA, Image, queue_size=1)
    frame = scene()

    def publish(event):
        publisher.publish(image_from_frame(frame, Header(stamp=rospy.Time.now(), frame_id='eye')))
    frames = rospy.Timer(rospy.Duration(1 / 30), publish)
    try:
        yield
    finally:
        frames.shutdown()
        frames.join()
        publisher.unregister()
