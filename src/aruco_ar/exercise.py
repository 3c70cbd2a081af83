"""What an exercise is: a function of a frame, which a Runner calls in a camera's node or for a bag."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Sequence

from .base.arrays import Image
from .geometry.lens import Lens
from .looks.hanging import OnWall
from .painting.paint import visible
from .painting.picture import Picture
from .painting.place import Place
from .tags.tag import Tag
from .tracking.area import Area

TAGS, LENS, AREA, PICTURE = 'tags', 'lens', 'area', 'picture'  # what an exercise may need


@dataclass(frozen=True)
class Scene:
    """One frame, and what an exercise may need to work on it.

    ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``image``: what to
    paint on, of the same size. It is the frame itself, or a copy of it into
    which other areas have been painted already. ``settings``: the node's
    parameters. ``tags``: those in sight, if the exercise needs them or the
    area. ``area``: the Area, or None if it is not known or not needed.
    ``picture``: the Picture to paint, or None if it is not needed or has not
    arrived yet. ``lens``: the Lens, if the camera is calibrated and its lens
    bends straight lines, else None. ``on_wall``: how the picture looks on its
    wall, or None if the settings do not ask for that.
    """

    frame: Image
    image: Image
    settings: Any
    tags: Sequence[Tag] = ()
    area: Area | None = None
    picture: Picture | None = None
    lens: Lens | None = None
    on_wall: OnWall | None = None

    def visible(self, warped: Image, place: Place) -> tuple[Image, Image]:
        """The mask of a Place, and a picture warped to it, as far as the picture is visible.

        The first is to be subtracted from the window, the second to be added: see painting.paint.visible. The
        settings may ask for a picture that is not opaque, or that people stay in front.
        """
        mask = place.mask
        if self.on_wall is not None:
            warped, mask = self.on_wall.apply(warped, place)
        return visible(place.window, warped, mask, self.settings.opacity)


@dataclass(frozen=True)
class Result:
    """The result for one frame: an image for each topic, and the tags in sight."""

    images: Sequence[Image]
    tags: Sequence[Tag]


@dataclass(frozen=True)
class Exercise:
    """An exercise by the name of its node. ``step`` turns a Scene into a Result.

    ``needs``: TAGS if it asks which tags are in sight, AREA if it asks where
    the area is, PICTURE if it paints one, LENS if it asks only for the lens.
    ``topics``: the names of its image topics.
    """

    name: str
    step: Callable[[Scene], Result]
    needs: Sequence[str] = ()
    topics: Sequence[str] = ('image',)
