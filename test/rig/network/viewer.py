#!/usr/bin/env python3
"""Print a line of JSON for each painted frame that arrives: topic, stamp, age, painted share.

The arguments are pairs of topics: that of the frames, and that of the painted frames.
"""
import json
import sys
import threading
import time

import numpy as np
import rospy
from aruco_node.messages.images import frame_from_image
from aruco_node.ros_internals.subscribers import subscribe_newest
from sensor_msgs.msg import Image

KEPT = 30  # number of frames that are kept until their painted frames arrive
OTHER = 60  # gray levels: a pixel that differs by more is painted
PRINTING = threading.Lock()


class Viewer:
    """Compares each frame with its painted frame."""

    def __init__(self, frames, painted):
        self._topic, self._frames, self._lock = painted, {}, threading.Lock()
        for topic, take in (frames, self._keep), (painted, self._compare):
            subscribe_newest(topic, Image, take)

    def _keep(self, message):
        with self._lock:
            self._frames[message.header.stamp] = message
            if len(self._frames) > KEPT:
                del self._frames[min(self._frames)]

    def _compare(self, message):
        now, stamp = time.time(), message.header.stamp
        with self._lock:
            frame = self._frames.get(stamp)
        part = None
        if frame is not None:
            off = np.abs(frame_from_image(frame)[::4, ::4].astype(int) - frame_from_image(message)[::4, ::4])
            part = float((off > OTHER).any(axis=2).mean())
        with PRINTING:
            print(json.dumps([self._topic, stamp.to_sec(), now - stamp.to_sec(), part]), flush=True)


if __name__ == '__main__':
    rospy.init_node('viewer', anonymous=True)
    for pair in zip(sys.argv[1::2], sys.argv[2::2]):
        Viewer(*pair)
    rospy.spin()
