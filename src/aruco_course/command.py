"""The command line: learn.py, script/learn and aruco-learn."""
from __future__ import annotations

import argparse
import importlib.util
import os
import shlex
import signal
import subprocess
import sys
from typing import Callable, Sequence

from aruco_ar import InputError
from aruco_ar.base.files import write_whole

from . import say
from .black_box.verdict import NodeVerdict, command_for_node
from .check import Check, Exercise, Fault
from .course import Course
from .exercises import CHECKS
from .learner import package as learner
from .learner.page import page
from .learner.report import report
from .terminal import Screen
from .trial import is_node_only
from .verdict import judge_recording, try_challenges
from .watch import watch

RIGHT, WRONG, USAGE = 0, 1, 2
Run = Callable[[argparse.Namespace, Screen], int]

DESCRIPTION = ('Write the nodes of the course yourself, and be told whether they are right. First, "start" '
               'makes a package of your own. Then leave "watch" open in a terminal: it looks at a file each '
               'time you save it.')
DEFAULT_PLACE = os.path.join(learner.WORKSPACE, learner.NAME)
CALLED = 'rosrun unit5 learn.py'


def aruco_learn() -> int:
    """The command that pip installs."""
    return main(called='aruco-learn')


def main(arguments: Sequence[str] | None = None, called: str = CALLED) -> int:
    """Do what the command line says. Returns 0 if it is right, 1 if not, 2 if nothing could be judged.

    ``called``: how this program is started, for what it says of itself.
    """
    for name in 'SIGTERM', 'SIGHUP':  # such as when the terminal is closed: what was started is ended, too
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), lambda number, _: sys.exit(128 + number))
    options = _parser(called).parse_args(arguments)
    screen = Screen(sys.stdout, options.plain)
    try:
        return int(options.run(options, screen))
    except InputError as error:
        Screen(sys.stderr, options.plain).text(str(error))
        return USAGE
    except KeyboardInterrupt:  # the usual end of watch
        return RIGHT if options.run is _watch else 130
    except BrokenPipeError:  # such as: learn.py solution | head
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return USAGE
    except OSError as error:  # such as: the folder in which one is, is gone
        Screen(sys.stderr, options.plain).text('The system refuses this: %s.' % error)
        return USAGE


def _parser(called: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=called, description=DESCRIPTION)
    # These may come before or after the command.
    _add_shared(parser, package=None, plain=False, called=called)
    shared = argparse.ArgumentParser(add_help=False)
    _add_shared(shared, package=argparse.SUPPRESS, plain=argparse.SUPPRESS, called=argparse.SUPPRESS)
    parser.set_defaults(run=_watch)
    commands = parser.add_subparsers(metavar='COMMAND')

    def command(name: str, run: Run, text: str, exercise: str | None = None) -> argparse.ArgumentParser:
        """``exercise``: the help of the argument that names one, if there is one."""
        made = commands.add_parser(name, help=text, parents=[shared],
                                   description=text[:1].upper() + text[1:] + '.')
        made.set_defaults(run=run)
        if exercise:
            made.add_argument('exercise', nargs='?', help=exercise)
        return made
    one = 'its number, such as 5.4 (default: the first that is not done)'
    command('start', _start, 'make a package of your own, or bring back files that are gone').add_argument(
        'folder', nargs='?', help='where (default: %s, or here if there is no such workspace)' % DEFAULT_PLACE)
    command('watch', _watch, 'show the exercise at hand, and a verdict each time you save (the default)')
    check = command('check', _check, 'say once whether an exercise is right', one + '; all: every one')
    check.add_argument('--node', action='store_true',
                       help='also start it as a ROS node, and judge what it publishes')
    check.add_argument('--image', metavar='TOPIC', default='',
                       help='with --node: the topic of its images (default: such as /my_exercise5_4/image)')
    check.add_argument('--mask', metavar='TOPIC', default='',
                       help="with --node: the topic of 5.5's masks (default: mask beside the images)")
    check.add_argument('--on', metavar='FILE', default='',
                       help='also judge it by what a camera recorded of four tags: a video, a picture, a '
                            'folder of pictures, or, with --node, a bag')
    command('hint', _hint, 'give a hint; there are three, and each tells more', one)
    command('solution', _solution, 'show the difference to our solution', one)
    command('reset', _reset, 'bring back the file as it was in the beginning; yours is kept', one)
    command('report', _report, 'print as JSON what was done').add_argument(
        '--judge', action='store_true', help='judge all files now, instead of trusting what was noted')
    made = command('page', _page, 'make a page of what was done, with your pictures, to print')
    made.add_argument('--name', default='', help='your name, as the page shall show it')
    made.add_argument('--output', metavar='FILE', help='file to write (default: course.html in your package)')
    return parser


def _add_shared(parser: argparse.ArgumentParser, package: str | None, plain: bool | str, called: str) -> None:
    parser.add_argument('--package', metavar='FOLDER', default=package,
                        help='your package (default: the one around this folder, else %s)' % DEFAULT_PLACE)
    parser.add_argument('--plain', action='store_true', default=plain,
                        help='plain text, line by line, for example for a screen reader')
    # How this program was started.
    parser.add_argument('--called', default=called, help=argparse.SUPPRESS)


def _course(options: argparse.Namespace) -> Course:
    """The learner's course. Raises InputError if there is no package yet."""
    if options.package is not None:
        package = learner.find(options.package)
        if package is None:
            raise InputError('"%s" is no package that was made here. To make one: %s start %s'
                             % (options.package, options.called, options.package))
    else:
        package = learner.find(os.getcwd()) or learner.find(learner.default_folder())
        if package is None:
            raise InputError('You have no package yet. To make one: %s start' % options.called)
    return Course(package, CHECKS)


def _exercise(options: argparse.Namespace, course: Course) -> Exercise:
    return course.exercise(options.exercise) if options.exercise else course.at_hand() or course.checks[-1]


def _start(options: argparse.Namespace, screen: Screen) -> int:
    folder = options.folder or options.package or learner.default_folder()
    started = learner.start(folder, CHECKS, options.called)
    package = started.package
    if not started.made:
        screen.text('Your package is complete: %s' % package.folder)
    else:
        screen.text('Your package is ready: %s' % package.folder, 'bold')
        screen.text('New in it: %s.' % ', '.join(started.made))
        if started.kept:
            screen.text('Left as they were: %s.' % ', '.join(started.kept))
    screen.text()
    screen.text('Open src/%s.py in an editor, and keep this open in a terminal:' % CHECKS[0].name)
    screen.lines('cd %s' % shlex.quote(say.shortest(package.folder)))
    screen.lines(options.called)
    return RIGHT


def _watch(options: argparse.Namespace, screen: Screen) -> int:
    return watch(_course(options), screen)


def _check(options: argparse.Namespace, screen: Screen) -> int:
    course = _course(options)
    checks = list(course.checks) if options.exercise == 'all' else [_exercise(options, course)]
    codes = []
    for number, check in enumerate(checks):
        if number:
            screen.text()
        codes.append(_check_one(course, check, options, screen))
    return max(codes)


def _check_one(course: Course, check: Exercise, options: argparse.Namespace, screen: Screen) -> int:
    is_bag = options.on.endswith('.bag')
    if is_bag and not options.node:
        raise InputError('Only a node is judged by a bag: add --node.')
    if options.node and learner.has_node(check) and is_node_only(course.package.source(check), check):
        screen.text('There is no function %s in it, so the node alone is judged.' % check.function)
        return _check_node(course, check, options, screen)
    judged = course.judge(check)
    if course.is_untouched(check):
        say.task(screen, check)
        screen.text()
    say.verdict(screen, course, judged)
    if not judged.passed:
        return WRONG
    for number, (tried, fault) in enumerate(try_challenges(check, course.package.folder)):
        if not number:
            say.challenges_begin(screen)
        say.challenge(screen, course, check, tried, fault)
        course.note_challenge(check, tried, fault)
    if options.on and not is_bag and (isinstance(check, Check) or options.exercise != 'all'):
        screen.text()
        recorded = judge_recording(check, course.package.folder, options.on)
        if recorded.fault is not None:
            screen.wrong('On your recording it is not right yet.')
            screen.text(str(recorded.fault))
            course.keep_picture(check, recorded)
            return WRONG
        screen.right('On your recording it is right, too.')
    if options.node and learner.has_node(check):
        return _check_node(course, check, options, screen)
    return RIGHT


def _check_node(course: Course, check: Exercise, options: argparse.Namespace, screen: Screen) -> int:
    """Start the node in a ROS of its own, and say what is wrong with what it publishes."""
    screen.text()
    try:
        if importlib.util.find_spec('rospy') is None:
            raise ImportError
        command = command_for_node(check.number, course.package.source(check), options.image, options.mask,
                                   bag=os.path.abspath(options.on) if options.on.endswith('.bag') else '',
                                   verdict=course.package.picture(check))
    except ImportError:
        raise InputError('A node needs ROS, which this Python does not find. Source its setup.bash.') from None
    done = subprocess.run(command, capture_output=True, text=True)
    judged = NodeVerdict.of_output(done.stdout)
    if judged is None:
        raise InputError((done.stderr.strip() or 'The node cannot be checked.').splitlines()[-1])
    if judged.passed:
        screen.right('The node is right.')
        course.note_node(check)
    else:
        screen.wrong('The node is not right yet.')
        screen.text(str(Fault(judged.fault, judged.place)))
    for remark in judged.remarks:
        screen.text(remark)
    return RIGHT if judged.passed else WRONG


def _hint(options: argparse.Namespace, screen: Screen) -> int:
    course = _course(options)
    check = _exercise(options, course)
    screen.text('%s %s' % (check.number, check.title), 'bold')
    say.hints(screen, check, course.hint(check))
    return RIGHT


def _solution(options: argparse.Namespace, screen: Screen) -> int:
    course = _course(options)
    check = _exercise(options, course)
    lines = course.solution(check)
    say.solution(screen, course, check, lines)
    return WRONG if lines is None else RIGHT


def _reset(options: argparse.Namespace, screen: Screen) -> int:
    course = _course(options)
    check = _exercise(options, course)
    say.was_reset(screen, course, check, course.reset(check))
    return RIGHT


def _report(options: argparse.Namespace, screen: Screen) -> int:
    course = _course(options)
    sys.stdout.write(report(course.package, course.checks, judge=course.judge if options.judge else None))
    return RIGHT


def _page(options: argparse.Namespace, screen: Screen) -> int:
    course = _course(options)
    path = options.output or course.package.path('course.html')
    write_whole(path, page(course.package, course.checks, options.name).encode())
    screen.text('Open it in a browser, and print it: %s' % say.shortest(path))
    return RIGHT
