"""The images that the page shows."""
from __future__ import annotations

from typing import NamedTuple

CAMERA = 'camera/rgb/image_raw'


class Tile(NamedTuple):
    """One of the images that the page shows. ``tags``: the name of the tags in sight.

    Without a ``number``, the tile is there only if its image is there when the page is opened. Then only
    tiles whose images are there are shown.
    """

    number: str
    title: str
    topic: str
    tags: str

    @property
    def node(self) -> str:
        """The full name of the node that makes it."""
        return self.topic.rpartition('/')[0]


TILES = [
    Tile('5.1', 'The wall with its tags', CAMERA, 'exercise5_2/tags'),
    Tile('5.2', 'Tags detected', 'exercise5_2/image', 'exercise5_2/tags'),
    Tile('', 'Your 5.2', 'my_exercise5_2/image', 'my_exercise5_2/tags'),  # of learner's packages, see learn.py
    Tile('5.3', 'Centers, as they come', 'exercise5_3/image', 'exercise5_3/tags'),
    Tile('', 'Your 5.3', 'my_exercise5_3/image', 'my_exercise5_3/tags'),
    Tile('5.4', 'Centers in order', 'exercise5_4/image', 'exercise5_4/tags'),
    Tile('', 'Your 5.4', 'my_exercise5_4/image', 'my_exercise5_4/tags'),
    Tile('5.5', 'The area subtracted', 'exercise5_5/image', 'exercise5_5/tags'),
    Tile('', 'Your 5.5', 'my_exercise5_5/image', 'my_exercise5_5/tags'),
    Tile('5.6', 'A picture in its place', 'exercise5_6/image', 'exercise5_6/tags'),
    Tile('', 'Your 5.6', 'my_exercise5_6/image', 'my_exercise5_6/tags'),
    Tile('', 'Your last verdict', 'learn_verdict/image', 'learn_verdict/tags'),  # see nodes/learn_verdict.py
    Tile('', 'Calibration', 'calibrate_live/image', 'calibrate_live/tags')]
