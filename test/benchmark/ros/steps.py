"""Where the time of exercise5_6.py goes: its steps, one by one, without sockets and threads."""
import io
import os
import time

import cv2
from aruco_ar import Tracker, load_picture
from aruco_ar.painting.paint import put_in, warp
from aruco_ar.painting.picture import Picture
from aruco_ar.painting.place import find_place
from aruco_node.messages.images import ImageDecoder, image_from_frame
from aruco_node.ros_internals.subscribers import tolerant
from rig import PACKAGE
from sensor_msgs.msg import Image
from std_msgs.msg import Header

OF_RELAY = 'read', 'write'  # what a node does that only passes frames on


class Steps:
    """The milliseconds of each step: ``took`` is {name: a list}."""

    def __init__(self):
        self.took = {}

    def time(self, name, function, *arguments):
        """What the function returns."""
        start = time.thread_time()
        result = function(*arguments)
        self.took.setdefault(name, []).append(1000 * (time.thread_time() - start))
        return result


def _written(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def take_steps(frames, rate, dictionary, ids):
    """The Steps of some frames, (h, w, 3) BGR, of a camera with that rate."""
    cv2.setNumThreads(1)
    steps, decode, tracker = Steps(), ImageDecoder(), Tracker(dictionary, ids)
    picture = Picture(load_picture(os.path.join(PACKAGE, 'images', 'earth.jpg')))
    for number, frame in enumerate(frames):
        data = _written(image_from_frame(frame, Header()))
        message = steps.time('read', tolerant(Image)().deserialize, data)
        own = steps.time('decode', decode, message)
        area = steps.time('find the area', tracker.update, own, number / rate)
        if area is not None:
            place = steps.time('find the place', find_place, own, area, picture)
            mask = steps.time('mask', lambda: place.mask)
            warped = steps.time('warp', warp, picture, place.homography, mask)
            steps.time('put in', put_in, place.window, warped, mask)
        steps.time('write', _written, image_from_frame(own, Header()))
    return steps


def run(name, frames, rate, dictionary, ids=()):
    """Print the mean of each step, and what is left of a node that only reads and writes."""
    steps = take_steps(frames, rate, dictionary, ids)
    took = {step: sum(each) / len(frames) for step, each in steps.took.items()}
    whole, relay = sum(took.values()), sum(took[step] for step in OF_RELAY)
    print("%-24s steps, ms a frame: %s; all %.2f, of which %.2f are a relay's, too\n" % (
        name, ', '.join('%s %.2f' % each for each in took.items()), whole, relay), flush=True)
