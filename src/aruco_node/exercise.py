"""An exercise as a node."""
from inspect import signature

from .camera_node import CameraNode
from .manual import camera_manual
from .memory import keep_memory
from .node import run_node
from .settings import TOPIC, AreaSettings, PictureSettings, Settings


def run(name, step, topics=('image',)):
    """Run an exercise as a node until ROS shuts down.

    For each frame ``step`` is called with the frame, (h, w, 3) BGR uint8,
    which is its own to write into, and with what its other arguments are
    named after: ``tags``, a list of Tag; ``area``, the Area that the tags in
    this frame and before it show, or None (see Tracker); ``picture``, what the
    parameter ~picture shows at that time, or None; ``fit``, ``opacity``, the
    parameters of these names. Where ~areas names several, ``step`` is called for one
    after the other, each time with the image it returned. It returns the image
    to publish as ~image or, with several ``topics``, one for each of them in
    that order. ``step`` is called only while somebody listens, and only with
    the newest frame.
    """
    keep_memory()
    takes = takes_of(step)
    kind = PictureSettings if 'picture' in takes else AreaSettings if 'area' in takes else Settings
    screen = [('TOPIC', 'sensor_msgs/Image', 'with ~picture %sTOPIC' % TOPIC)] if 'picture' in takes else []
    run_node(name, lambda: _Exercise(step, takes, topics, kind).spin(),
             camera_manual(topics, kind, 'area' in takes, screen))


def takes_of(step):
    """The names of what a step takes besides the frame."""
    return list(signature(step).parameters)[1:]


class _Exercise(CameraNode):
    """Calls a step with frames and what it takes, and publishes what it returns."""

    def __init__(self, step, takes, topics, kind_of_settings):
        self._step, self._single = step, len(topics) == 1
        super().__init__(takes, topics, kind_of_settings)

    def answer(self, frame, given, header, stamp):
        images = frame
        for each in given:
            images = self._step(images, *each)
        return [images] if self._single else images
