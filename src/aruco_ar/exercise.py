"""An exercise: what is made of each frame, whether a camera's node or a bag brings it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Protocol, Sequence

from .base.arrays import Image
from .tags.detector import Detector
from .tags.tag import Tag
from .tracking.area import Area
from .tracking.tracker import Tracker

TRACKER, PICTURE = 'tracker', 'picture'  # what an exercise may need
# After a change of these parameters the tracker starts anew.
STARTS = 'dictionary', 'ids', 'upright', 'search', 'correction', 'likeness', 'min_side'


@dataclass(frozen=True)
class Scene:
    """One frame, and what an exercise may need to work on it.

    ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``image``: what to paint on, of the same size. It is
    the frame itself, or a copy of it into which other areas have been painted already. ``stamp``: the frame's
    time, seconds. ``settings``: the node's parameters. ``tracker``: the Tracker that follows the area.
    ``picture``: (h, w, 3) BGR or (h, w, 4) BGRA uint8, None until there is one. Both are None for an exercise
    that does not need them.
    """

    frame: Image
    image: Image
    stamp: float
    settings: Any
    tracker: Any = None
    picture: Image | None = None


@dataclass(frozen=True)
class Result:
    """What an exercise makes of a frame: an image for each topic, the tags in sight, and the Area, if known."""

    images: Sequence[Image]
    tags: Sequence[Tag]
    area: Area | None = None


@dataclass(frozen=True)
class Exercise:
    """An exercise by the name of its node. ``step`` turns a Scene into a Result.

    ``needs``: TRACKER to ask where the area is, PICTURE to paint one. ``topics``: the names of its images.
    """

    name: str
    step: Callable[[Scene], Result]
    needs: Sequence[str] = ()
    topics: Sequence[str] = ('image',)


def find_tags(scene: Scene) -> list[Tag]:
    """The tags in a Scene's frame, found as its settings ask for: exercise 5.2."""
    settings = scene.settings
    return Detector(settings.dictionary, settings.ids, settings.search, settings.correction, settings.likeness,
                    settings.min_side).detect(scene.frame)


def new_tracker(settings: Any) -> Tracker:
    """A Tracker as settings ask for it. Raises InputError."""
    return Tracker(settings.dictionary, settings.ids, settings.hold, settings.upright, search=settings.search,
                   correction=settings.correction, likeness=settings.likeness, min_side=settings.min_side)


class Source(Protocol):
    """Where a picture comes from, such as a Still or a Clip."""

    def at(self, stamp: float) -> Image | None:
        """The picture that is shown at a time, seconds."""


class Stage:
    """What is kept from frame to frame, for one area: settings, Tracker, and where its picture comes from."""

    def __init__(self, needs: Sequence[str], settings: Any, open_source: Callable[[str], Source],
                 before: Stage | None = None) -> None:
        """``needs``: see Exercise. ``open_source`` opens what the parameter ``picture`` names.

        ``before``: the Stage whose settings were changed to these. It hands on what they leave as it was.
        Raises InputError.
        """
        self.settings = settings
        self._needs, self._open_source = needs, open_source
        self.tracker: Tracker | None = None
        self.source: Source | None = None
        if TRACKER in needs:
            self.tracker = before.tracker if before and self._agrees(before, STARTS) else new_tracker(settings)
        if PICTURE in needs:
            self.source = before.source if before and self._agrees(before, [PICTURE]) else \
                open_source(settings.picture)

    def _agrees(self, other: Stage, names: Sequence[str]) -> bool:
        return all(getattr(self.settings, name) == getattr(other.settings, name) for name in names)

    def scene(self, frame: Image, image: Image, stamp: float) -> Scene:
        """The Scene of a frame: see there."""
        if self.tracker is not None:
            self.tracker.hold = self.settings.hold
        picture = None if self.source is None else self.source.at(stamp)
        return Scene(frame, image, stamp, self.settings, self.tracker, picture)

    def changed(self, settings: Any) -> Stage:
        """The Stage from a change of settings on. Raises InputError, and then this one stays as it is."""
        return Stage(self._needs, settings, self._open_source, self)

    def reset(self) -> None:
        """Forget what was learned from frames."""
        if self.tracker is not None:
            self.tracker.reset()
