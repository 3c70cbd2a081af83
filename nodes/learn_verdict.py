#!/usr/bin/env python3
"""Publish the picture of a learner's newest verdict on ~image, for the page.

learn.py saves it in .learn/pictures of the learner's package: what is expected,
and what his code shows. While there is none, there is no topic.
"""
import argparse
import os
from glob import escape, glob

import aruco_program  # noqa: F401  before all else
import rospy
from aruco_ar import InputError, load_picture
from aruco_node.messages.images import image_from_frame
from sensor_msgs.msg import Image
from std_msgs.msg import Header

PERIOD_S = 0.5


def parse(argv):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('package', metavar='FOLDER', help="the learner's package")
    return parser.parse_args(argv)


def newest_picture(package):
    """The newest picture of a verdict, (h, w, 3) BGR uint8, or None if there is none that can be read."""
    names = os.path.join(escape(package), '.learn', 'pictures', '[0-9]_[0-9].png')
    try:
        path = max(glob(names), key=os.path.getmtime)
        return load_picture(path)[..., :3]
    except (ValueError, OSError, InputError):  # there is none, or it is just being replaced
        return None


def main(package):
    rospy.init_node('learn_verdict')
    publisher = None
    while not rospy.is_shutdown():
        picture = newest_picture(package)
        if picture is not None:
            publisher = publisher or rospy.Publisher('~image', Image, queue_size=1)
            publisher.publish(image_from_frame(picture, Header(stamp=rospy.Time.now())))
        rospy.sleep(PERIOD_S)


if __name__ == '__main__':
    try:
        main(parse(rospy.myargv()[1:]).package)
    except rospy.ROSInterruptException:  # it was stopped while it slept
        pass
