"""What an exercise is: a function of a frame, called by a camera's node or for the frames of a bag."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Protocol, Sequence

from .base.arrays import Image
from .geometry.lens import Lens
from .looks.look import Look, asks_for_look
from .settings.settings import CORRECT
from .tags.detector import Detector
from .tags.tag import Tag
from .tracking.area import Area
from .tracking.tracker import Tracker

TRACKER, PICTURE, LENS = 'tracker', 'picture', 'lens'  # what an exercise may need
# The parameters of a Detector.
DETECTION = 'dictionary', 'ids', 'search', 'correction', 'likeness', 'min_side', 'border'
# A change of one of these parameters makes a new tracker.
TRACKER_PARAMETERS = (*DETECTION, 'upright')


@dataclass(frozen=True)
class Scene:
    """One frame, and what an exercise may need to work on it.

    ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``image``: what to paint on, of the same size. It is
    the frame itself, or a copy of it into which other areas have been painted already. ``stamp``: the frame's
    time, seconds. ``settings``: the node's parameters. ``tracker``: the Tracker of the area. ``picture``:
    (h, w, 3) BGR or (h, w, 4) BGRA uint8; it is None until the first picture has arrived. The tracker and the
    picture are None for an exercise that does not need them. ``lens``: the Lens, if the camera is calibrated
    and its lens bends straight lines, else None. ``look``: the Look of the picture on its wall, or None.
    """

    frame: Image
    image: Image
    stamp: float
    settings: Any
    tracker: Any = None
    picture: Image | None = None
    lens: Lens | None = None
    look: Look | None = None

    def on_wall(self, picture: Image, mask: Image, area: Area, part: Area) -> tuple[Image, Image]:
        """A warped picture as it looks on the wall, as far as the settings ask for it, and its mask.

        ``area``: the Area in the frame. ``part``: the same, in the pixels of ``picture`` and ``mask``. For
        these and the result, see Look.apply.
        """
        if self.look is None or not asks_for_look(self.settings):
            return picture, mask
        self.look.update(self.frame, self.stamp, area, self.tracker.tags, self.settings, self.tracker.located)
        return self.look.apply(picture, mask, part, self.settings)

    def hide_tags(self, area: Area) -> None:
        """Cover the wall's tags in the image, if the settings ask for it. This comes after ``on_wall``."""
        if self.look is not None and asks_for_look(self.settings):
            self.look.hide_tags(self.frame, self.image, area, self.tracker.tags, self.settings,
                                self.tracker.located)


@dataclass(frozen=True)
class Result:
    """The result for one frame: an image for each topic, the tags in sight, and the Area, if it is known."""

    images: Sequence[Image]
    tags: Sequence[Tag]
    area: Area | None = None


@dataclass(frozen=True)
class Exercise:
    """An exercise by the name of its node. ``step`` turns a Scene into a Result.

    ``needs``: TRACKER if it asks where the area is, PICTURE if it paints one, LENS if it needs only the
    lens. ``topics``: the names of its image topics.
    """

    name: str
    step: Callable[[Scene], Result]
    needs: Sequence[str] = ()
    topics: Sequence[str] = ('image',)


def detection(settings: Any) -> dict[str, Any]:
    """The arguments of a Detector as settings ask for them."""
    return {name: getattr(settings, name) for name in DETECTION}


def find_tags(scene: Scene) -> list[Tag]:
    """The tags in a Scene's frame, found as its settings ask for: exercise 5.2."""
    return Detector(**detection(scene.settings)).detect(scene.frame)


def new_tracker(settings: Any) -> Tracker:
    """A Tracker as settings ask for it. Raises InputError."""
    return Tracker(hold=settings.hold, upright=settings.upright, **detection(settings))


class Source(Protocol):
    """The source of a picture, such as a Still or a Clip."""

    def at(self, stamp: float) -> Image | None:
        """The picture to show at a time, seconds; None if there is none yet."""


class Stage:
    """What is kept from frame to frame for one area: the settings, the Tracker, and the picture's Source."""

    def __init__(self, needs: Sequence[str], settings: Any, open_source: Callable[[str], Source],
                 previous: Stage | None = None) -> None:
        """Make a Stage for ``settings``, the node's parameters.

        ``needs``: see Exercise. ``open_source``: a function that opens the Source that the parameter
        ``picture`` names. ``previous``: the Stage with the settings before the change. Its tracker and its
        source are kept if their own parameters are unchanged. Raises InputError.
        """
        self.settings = settings
        self._needs, self._open_source = needs, open_source
        self.tracker: Tracker | None = None
        self.source: Source | None = None
        self.look: Look | None = None
        if TRACKER in needs:
            self.tracker = previous.tracker if previous and self._has_same(previous, TRACKER_PARAMETERS) else \
                new_tracker(settings)
        if PICTURE in needs:
            self.source = previous.source if previous and self._has_same(previous, [PICTURE]) else \
                open_source(settings.picture)
            self.look = previous.look if previous and previous.tracker is self.tracker else Look()

    def _has_same(self, other: Stage, parameters: Sequence[str]) -> bool:
        return all(getattr(self.settings, name) == getattr(other.settings, name) for name in parameters)

    def scene(self, frame: Image, image: Image, stamp: float, lens: Lens | None = None) -> Scene:
        """The Scene of a frame; the arguments are those of Scene, and ``lens`` is any Lens, or None."""
        if lens is not None and not (lens.bends and self.settings.lens == CORRECT):
            lens = None
        if self.tracker is not None:
            self.tracker.hold, self.tracker.lens = self.settings.hold, lens
        picture = None if self.source is None else self.source.at(stamp)
        if picture is not None:
            picture.setflags(write=False)  # so what is computed from it once is kept (see levels_of)
        return Scene(frame, image, stamp, self.settings, self.tracker, picture, lens, self.look)

    def changed(self, settings: Any) -> Stage:
        """A new Stage with changed settings. Raises InputError; this Stage is unchanged in either case."""
        return Stage(self._needs, settings, self._open_source, self)

    def reset(self) -> None:
        """Forget all that was learned from frames."""
        for learned in self.tracker, self.look:
            if learned is not None:
                learned.reset()
