"""Exercise 5.6 as it runs in its node, on frames."""
from aruco_ar.exercise import Runner
from aruco_ar.painting.sources import Still
from aruco_ar.settings.settings import PictureSettings
from exercise5_6 import EXERCISE


class Painter:
    """Paints a picture, (h, w, 3) BGR, into frames. ``changes``: of the node's parameters."""

    def __init__(self, picture, lens=None, **changes):
        self._lens = lens
        self._runner = Runner(EXERCISE, [PictureSettings(**changes)], lambda _: Still(picture))

    def paint(self, frame, stamp):
        """(the Sight of a frame, (h, w, 3) BGR uint8, which remains as it is, the painted image)."""
        sight, (image,) = self._runner.run(frame, stamp, self._lens, keeps_frame=True)
        return sight, image
