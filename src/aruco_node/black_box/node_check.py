"""The check of a node of an exercise: runs it, and judges what it publishes."""
import os
import time
from dataclasses import dataclass, replace

import cv2
import rospy
from aruco_ar import load_picture
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package, write_whole
from aruco_course.black_box.verdict import NodeVerdict
from aruco_course.check import Check
from aruco_course.exercises import CHECKS
from aruco_course.judge.verdict_picture import verdict_picture
from aruco_course.trial import Trial, fault_of_speed

from .black_box import BlackBox, Topics
from .program import program_of

CAMERA = '/camera/rgb/image_raw'
MAX_PRINTED = 2000  # characters
EARTH = os.path.join('images', 'earth.jpg')


@dataclass
class Options:
    """What to check, and how. For those that are empty, see ``check_node``."""

    exercise: str
    node: str
    image: str = ''
    mask: str = ''
    picture: str = ''
    camera: str = CAMERA
    bag: str = ''
    verdict: str = ''


def check_node(options, is_shared):
    """Run a node and judge it; returns a NodeVerdict. This process must be a ROS node.

    By default the node of exercise 5.4 publishes on /my_exercise5_4/image, and that of 5.5 on mask beside its
    image; the picture of 5.6 is images/earth.jpg of the node's package, or else ours; and the frames are the
    check's own. ``is_shared``: whether the ROS master stays after the check. Raises InputError if there can be
    no verdict.
    """
    began = time.monotonic()
    check = check_of(options.exercise)
    verdict = NodeVerdict(check.number, options.node, False)
    try:
        path, package = program_of(options.node)
    except InputError as error:
        verdict.fault = str(error)
        return verdict
    views = _views(check, options, package)
    topics = Topics(rospy.resolve_name(options.camera), _outputs(check, options))
    collected = BlackBox(path, topics, views, is_shared).run()
    fault = collected.fault or check.judge(collected.shown)
    if fault is None:
        fault = fault_of_speed(Trial(seconds=collected.seconds, baseline_seconds=collected.baseline_seconds))
    verdict.passed = fault is None
    if fault is not None:
        verdict.fault, verdict.place = fault.what, fault.place
    verdict.remarks, verdict.printed = collected.remarks, collected.printed[-MAX_PRINTED:]
    if options.verdict:
        verdict.picture = _save_picture(fault, collected.shown, options.verdict)
    verdict.seconds = round(time.monotonic() - began, 2)
    return verdict


def check_of(number):
    """The Check of an exercise. Raises InputError if it is not there, or has no node."""
    known = {check.number: check for check in CHECKS}
    if number not in known:
        raise InputError('There is no exercise %s; there are %s.' % (number, ', '.join(known)))
    if not isinstance(known[number], Check):
        raise InputError('The program of exercise %s is no node. Check it with: learn.py check %s'
                         % (number, number))
    return known[number]


def _outputs(check, options):
    """{the name of an output: its topic}."""
    image = rospy.resolve_name(options.image or '/my_%s/image' % check.name)
    beside = {name: '%s/%s' % (image.rpartition('/')[0], name) for name in check.outputs[:-1]}
    if options.mask and 'mask' in beside:
        beside['mask'] = rospy.resolve_name(options.mask)
    return {**beside, check.outputs[-1]: image}


def _views(check, options, package):
    views = list(check.views())
    paints = views[0].picture is not None
    if options.bag:
        from .bag_views import views_of_bag  # which takes long to import
        views = views_of_bag(options.bag, rospy.resolve_name(options.camera))
    if not paints:
        return views
    own = os.path.join(package or '', EARTH)
    path = options.picture or (own if package and os.path.exists(own) else in_package(EARTH))
    picture = load_picture(path)[..., :3]
    return [replace(view, picture=picture) for view in views]


def _save_picture(fault, shown, path):
    """Save the verdict's picture as PNG, if there is anything to see. Returns its path, or nothing."""
    picture = verdict_picture(fault, shown[0] if shown else None)
    if picture is None:
        return ''
    write_whole(path, cv2.imencode('.png', picture)[1].tobytes())
    return path
