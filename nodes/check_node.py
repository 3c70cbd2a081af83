#!/usr/bin/env python3
"""Check a node of an exercise as a black box: show it frames, and judge what it publishes.

NODE is any executable, in any language: package/program, or the path of a
file. It needs no roscore: the check has a ROS master of its own. A class is
checked with rostest unit5 check.test exercise:=5.4 node:=my_unit5/exercise5_4.py.
It returns 0 if the node is right, 1 if it is not, and 2 if that cannot be told.
"""
import argparse
import os
import signal
import sys
from contextlib import ExitStack
from xml.etree import ElementTree

import aruco_program  # noqa: F401  before all else
import rospy
from aruco_ar import InputError
from aruco_course.check import Fault
from aruco_node.black_box.node_check import CAMERA, Options, check_node
from aruco_node.black_box.own_master import own_master


def parse(argv):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('exercise', metavar='EXERCISE', help='number of the exercise, such as 5.4')
    parser.add_argument('node', metavar='NODE', help='such as my_unit5/exercise5_4.py')
    parser.add_argument('--image', metavar='TOPIC', default='',
                        help='topic of its images (default: such as /my_exercise5_4/image)')
    parser.add_argument('--mask', metavar='TOPIC', default='',
                        help='topic of the masks of exercise 5.5 (default: mask beside the images)')
    parser.add_argument('--picture', metavar='FILE', default='',
                        help='what it paints in exercise 5.6 (default: images/earth.jpg in its package)')
    parser.add_argument('--camera', metavar='TOPIC', default=CAMERA,
                        help='topic on which it gets frames (default: %(default)s)')
    parser.add_argument('--bag', metavar='FILE', default='',
                        help="a bag with frames (default: the check's own frames)")
    parser.add_argument('--verdict', metavar='FILE.png', default='',
                        help='where to save a picture of what is expected and what the node shows')
    parser.add_argument('--json', action='store_true', help='print the verdict as a line of JSON')
    parser.add_argument('--gtest_output', help=argparse.SUPPRESS)  # rostest gives it: where results go
    return parser.parse_args(argv)


def main(argv):
    # roslaunch adds arguments of its own, such as __name:=..., which rospy reads.
    args = parse([arg for arg in rospy.myargv(argv) if not arg.startswith('__')])
    options = Options(args.exercise, args.node, args.image, args.mask, args.picture, args.camera, args.bag,
                      args.verdict)
    for name in signal.SIGTERM, signal.SIGHUP:  # the node ends with the check, also if its terminal is closed
        signal.signal(name, lambda number, _: sys.exit(128 + number))
    with ExitStack() as stack:
        if not args.gtest_output:
            stack.enter_context(own_master())
        try:
            rospy.init_node('check_node', anonymous=not args.gtest_output, disable_signals=True)
            verdict = check_node(options, is_shared=bool(args.gtest_output))
        except InputError as error:
            print('check_node: %s' % error, file=sys.stderr)
            if args.gtest_output:
                write_results(args.gtest_output, options, str(error))
            return 2
        said = str(Fault(verdict.fault, verdict.place))
        for remark in verdict.remarks:
            print('Remark: %s' % remark)
        print(verdict.line() if args.json else said or 'Right.', flush=True)
        if args.gtest_output:
            write_results(args.gtest_output, options, said)
        rospy.signal_shutdown('done')
    return 0 if verdict.passed else 1


def write_results(output, options, said):
    """Write the results for rostest. ``output``: xml:PATH. ``said``: what is wrong, or nothing."""
    suite = ElementTree.Element('testsuite', name='check', tests='1', failures=str(int(bool(said))), errors='0',
                                time='0')
    case = ElementTree.SubElement(suite, 'testcase', classname='check.exercise' + options.exercise,
                                  name=options.node, time='0')
    if said:
        ElementTree.SubElement(case, 'failure', type='', message=said).text = said
    path = output.partition(':')[2]
    os.makedirs(os.path.dirname(path), exist_ok=True)
    ElementTree.ElementTree(suite).write(path, encoding='utf-8', xml_declaration=True)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
