"""The command line: learn.py, script/learn and aruco-learn."""
from __future__ import annotations

import argparse
import os
import subprocess
import sys
from typing import Sequence

from aruco_ar import InputError
from aruco_ar.base.files import write_whole

from . import say
from .check import Exercise
from .course import Course
from .exercises import CHECKS
from .learner import package as learner
from .learner.page import page
from .learner.report import report
from .terminal import Screen
from .verdict import try_challenges
from .watch import watch

RIGHT, WRONG, USAGE = 0, 1, 2

DESCRIPTION = """\
Write the nodes of the course yourself, and be told whether they are right.

First, "start" makes a package of your own. Then leave "watch" open in a
terminal, which looks at your files each time you save them.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line says. Returns 0 if it is right, 1 if not, 2 if nothing could be judged."""
    options = _parser().parse_args(arguments)
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=DESCRIPTION, formatter_class=argparse.RawDescriptionHelpFormatter)
    shared = argparse.ArgumentParser(add_help=False)
    for each, default in (parser, None), (shared, argparse.SUPPRESS):
        each.add_argument('--package', metavar='FOLDER', default=default,
                          help='your package (default: the one around this folder, else %s)'
                               % os.path.join(learner.WORKSPACE, learner.NAME))
        each.add_argument('--plain', action='store_true', default=default or False if each is parser else default,
                          help='plain text, line by line, for example for a screen reader')
        each.add_argument('--called', help=argparse.SUPPRESS,  # how this program was started
                          default='rosrun unit5 learn.py' if each is parser else default)
    parser.set_defaults(run=_watch)
    commands = parser.add_subparsers(metavar='COMMAND')

    def command(name: str, run: object, text: str) -> argparse.ArgumentParser:
        made = commands.add_parser(name, help=text, description=text[:1].upper() + text[1:] + '.', parents=[shared])
        made.set_defaults(run=run)
        return made

    def about_exercise(made: argparse.ArgumentParser) -> argparse.ArgumentParser:
        made.add_argument('exercise', nargs='?', help='its number, such as 5.4 (default: the first that is not done)')
        return made
    command('start', _start, 'make a package of your own, or bring back files that are gone').add_argument(
        'folder', nargs='?', help='where (default: %s, or here if there is no such workspace)'
                                  % os.path.join(learner.WORKSPACE, learner.NAME))
    command('watch', _watch, 'show the exercise at hand, and a verdict each time you save (the default)')
    check = about_exercise(command('check', _check, 'say once whether an exercise is right; "all" for all of them'))
    check.add_argument('--node', action='store_true', help='also start it as a ROS node, and judge what it publishes')
    about_exercise(command('hint', _hint, 'give a hint; there are three, and each tells more'))
    about_exercise(command('solution', _solution, 'show the difference to our solution'))
    about_exercise(command('reset', _reset, 'bring back the file as it was in the beginning; yours is kept'))
    command('report', _report, 'print as JSON what was done').add_argument(
        '--judge', action='store_true', help='judge all files now, instead of trusting what was noted')
    made = command('page', _page, 'make a page of what was done, with your pictures, to print')
    made.add_argument('--name', default='', help='your name, as the page shall show it')
    made.add_argument('--output', metavar='FILE', help='the file to write (default: course.html in your package)')
    return parser


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
    started = learner.start(options.folder or options.package or learner.default_folder(), CHECKS, options.called)
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
    screen.lines('cd %s' % say.shortest(package.folder))
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
        codes.append(_check_one(course, check, options.node, screen))
    return max(codes)


def _check_one(course: Course, check: Exercise, with_node: bool, screen: Screen) -> int:
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
        say.challenge(screen, tried, fault)
        course.note_challenge(check, tried, fault)
    if with_node and learner.has_node(check):
        return _check_node(course, check, screen)
    return RIGHT


def _check_node(course: Course, check: Exercise, screen: Screen) -> int:
    """Start the node in a ROS of its own, and say what is wrong with what it publishes."""
    from .black_box.verdict import NodeVerdict, command_for_node  # only those who have ROS need it
    screen.text()
    done = subprocess.run(command_for_node(check.number, course.package.source(check),
                                           verdict=course.package.picture(check)),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    judged = NodeVerdict.of_output(done.stdout)
    if judged is None:
        raise InputError(done.stderr.strip() or 'The node cannot be checked.')
    if judged.passed:
        screen.right('The node is right, too.')
        course.note_node(check)
    else:
        screen.wrong('The node is not right yet.')
        screen.text('%s: %s' % (judged.place, judged.fault) if judged.place else judged.fault)
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
