"""What is said of a node: each is a Fault in a sentence or two, with what helps."""
from __future__ import annotations

import builtins
import os
import re
import signal
from typing import Sequence

import cv2

from aruco_course.check import Fault
from aruco_course.trial.sentences.exceptions import fault_of_error
from aruco_course.trial.sentences.opencv import NO_SCREEN
from aruco_course.trial.source import fault_of_syntax

from .running import Program

SHOWN = 6  # so many topics are named at most
NEAR = re.compile(r"\. Did you mean: '([^']+)'\?$")  # Python 3.10 and later
MODULE = re.compile(r"^No module named '([^']+)'")
ANONYMOUS = re.compile(r'_\d+_\d{10,}')  # the end of a name that is another one each time
FILE = re.compile(r"^\[Errno 2\] [^:]*: '([^']+)'")
NO_QT = 'no Qt platform plugin could be initialized'  # Debian 13's OpenCV then ends the program by a signal
VERSION = re.compile(r'^OpenCV\(([\d.]+)')
# What cv_bridge says, and what helps.
OF_BRIDGE = {
    'encoding specified as .* incompatible type':
        'the image does not have the encoding that cv2_to_imgmsg is given (%s). It is "bgr8" for an array of '
        'height x width x 3, and "mono8" for one of height x width.',
    'is not a color format':
        'cv_bridge cannot convert between these encodings (%s). A mask is "mono8", an image in colors "bgr8".',
    'Your input type is not a numpy array':
        'cv2_to_imgmsg is given something that is no image (%s). Does your function return the image at its '
        'end, also if there are no tags?',
}
# Python cannot read the file, so there is no traceback.
UNREADABLE = re.compile(r'^  File "([^"]+)", line \d+\n(?:.*\n){1,3}(?:Syntax|Indentation|Tab)Error: ',
                        re.MULTILINE)


def raised(program: Program) -> Fault | None:
    """The exception that a program has printed, if it did."""
    syntax = UNREADABLE.search(program.printed)
    if syntax:
        return fault_of_syntax(syntax[1])
    found = program.raised()
    if found is None:
        return None
    kind, message = found.kind.replace('::', '.').rpartition('.')[2], found.message
    for pattern, what in OF_BRIDGE.items():
        if re.search(pattern, message):
            return Fault(what % ' '.join(message.split()), _place(found.line))
    if '::' in found.kind:  # C++
        return Fault('the node ended with %s: %s' % (found.kind, ' '.join(message.split())))
    # What inside/describe.py tells of an exception, as far as it can be read.
    kinds = [each.__name__ for each in getattr(getattr(builtins, kind, None), '__mro__', ())] or [kind]
    near, module, file = NEAR.search(message), MODULE.search(message), FILE.search(message)
    version = VERSION.search(message)
    return fault_of_error(
        dict(type=kind, types=kinds, message=NEAR.sub('', message), line=found.line or 0, beside='',
             near=near[1] if near else '', opencv=version[1] if version else cv2.__version__,
             name=module[1] if module else '', file=file[1] if file else '', stage='call', call=0, unread=None),
        program.file, 'the callback')


def ended(program: Program) -> Fault:
    """The program has ended, though it should run until it is stopped."""
    found = raised(program) or _of_first_line(program.file)
    if found:
        return found
    code = program.code or 0
    if code < 0 and NO_QT in program.printed:
        return Fault(NO_SCREEN, _place(program.line_at_end()))
    if code < 0:
        return Fault('the node crashed: it got the signal %s.' % signal.Signals(-code).name)
    last = next((line.strip() for line in reversed(program.printed.splitlines()) if line.strip()), '')
    if code == 0:
        return Fault('the node ends by itself. It must wait for frames until it is stopped: call main() at the '
                     'end of the file, and rospy.spin() at the end of main().')
    return Fault('the node ended with the exit code %d. It printed last: %s' % (code, last or 'nothing.'))


def not_startable(path: str, error: OSError) -> Fault:
    """Why a program cannot be started at all."""
    return _of_first_line(path) or Fault(
        '%s cannot be started: %s. Its first line must name a program that is there: #!/usr/bin/env python3'
        % (os.path.basename(path), error.strerror))


def _place(line: int | None) -> str:
    return 'Line %d' % line if line else ''


def _of_first_line(path: str) -> Fault | None:
    """What is wrong with the line that says who runs a program."""
    name = os.path.basename(path)
    with open(path, 'rb') as file:
        first = file.readline(256)
    if not first.startswith((b'#!', b'\x7fELF')):
        return Fault('%s does not begin with the line that says who runs it: #!/usr/bin/env python3' % name)
    if first.endswith(b'\r\n'):
        return Fault('%s has the line ends of Windows, so its first line names no program. Save it with those '
                     'of Linux: sed -i "s/\\r$//" %s' % (name, path))
    return None


def no_node() -> Fault:
    return Fault('the program runs, but is no ROS node. Call rospy.init_node first in main(), and main() at '
                 'the end of the file.')


def no_subscription(camera: str, others: Sequence[str]) -> Fault:
    """``others``: the image topics to which it subscribes."""
    if others:
        return Fault('the node subscribes to %s, not to %s. Subscribe to that, or give camera:=%s.'
                     % (_listed(others), camera, others[0]))
    return Fault('the node does not subscribe to %s. Make a rospy.Subscriber of it in main().' % camera)


def other_cameras(camera: str, nodes: Sequence[str]) -> Fault:
    return Fault('the frames of the check would mix with those of %s, which publishes on %s, too. End it first.'
                 % (_listed(nodes), camera))


def no_topic(topic: str, name: str, kind: str, others: Sequence[str]) -> Fault:
    """``kind``: the type of the topic if it is a wrong one. ``others``: image topics of the node."""
    if kind:
        return Fault('the node publishes %s as %s, but it must be sensor_msgs/Image.' % (topic, kind))
    others = [each for each in others if each != topic]
    if others:
        # Of two images, the one with another name is not meant.
        meant = next((each for each in others if each.endswith('/' + name)), '')
        if not meant and name == 'image':
            meant = next((each for each in others if not each.endswith('/mask')), '')
        what = 'the node publishes nothing on %s, but on %s.' % (topic, _listed(others))
        if topic.startswith('/my_exercise'):
            what += " The node's name is part of that: is it %s, without anonymous=True?" % topic.split('/')[1]
        if meant and not ANONYMOUS.search(meant):
            what += ' If the topic is right, give %s:=%s (learn.py: --%s %s).' % (name, meant, name, meant)
        return Fault(what)
    return Fault('the node publishes no images. Make a rospy.Publisher of %s in main(), and publish in the '
                 'callback.' % topic)


def silent(topic: str, number: int) -> Fault:
    """It has a publisher, but nothing comes."""
    if number == 1:
        return Fault('nothing comes on %s, though frames arrive. Call publish at the end of the callback, for '
                     'each frame.' % topic)
    return Fault('nothing comes on %s for this frame. Publish an image for each frame, also if there is '
                 'nothing to draw.' % topic, 'Frame %d' % number)


def hangs(line: int | None, number: int) -> Fault:
    return Fault('the callback never ends for frame %d. Does a loop in it ever end?' % number,
                 _place(line))


def unreadable(topic: str, encoding: str, error: Exception) -> Fault:
    return Fault('what comes on %s cannot be read as an image: its encoding is "%s". Publish an array of '
                 'uint8, with bgr8 if it has colors, else with mono8: bridge.cv2_to_imgmsg(image, "bgr8").'
                 % (topic, encoding))


def several(topic: str, nodes: Sequence[str]) -> Fault:
    return Fault('%s is published by several: %s. Then frames of all of them are mixed; end the others.'
                 % (topic, _listed(nodes)))


def late_publisher(topic: str) -> Fault:
    return Fault('the publisher of %s is made in the callback, when the first frame comes. Who listens is not '
                 'connected yet then, and misses it: make the publisher once in main(), before the subscriber.'
                 % topic)


def exchanged_colors() -> Fault:
    return Fault('blue and red are exchanged in what the node publishes. Name the same encoding in both '
                 'directions: imgmsg_to_cv2(message, "bgr8") and cv2_to_imgmsg(image, "bgr8").')


def no_stamp() -> str:
    return 'The images do not have the stamp of their frames, so others cannot match them: ' \
        'result.header = message.header.'


def _listed(names: Sequence[str]) -> str:
    return ', '.join(names[:SHOWN]) + (', ...' if len(names) > SHOWN else '')
