"""Exercise 5.6 as it runs in its node, on frames."""
from dataclasses import replace

from aruco_ar.exercise import Stage
from aruco_ar.painting.sources import Still
from aruco_node.parameters.settings import PictureSettings
from exercise5_6 import EXERCISE


class Painter:
    """Paints a picture, (h, w, 3) BGR, into frames. ``changes``: of the node's parameters."""

    def __init__(self, picture, lens=None, **changes):
        self._lens = lens
        self._stage = Stage(EXERCISE.needs, replace(PictureSettings(), **changes), lambda _: Still(picture))

    def paint(self, frame, stamp):
        """The Result for a frame, (h, w, 3) BGR uint8, which remains as it is."""
        return EXERCISE.step(self._stage.scene(frame, frame.copy(), stamp, self._lens))
