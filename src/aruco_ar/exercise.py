"""What an exercise is: a function of a frame, called by a camera's node or for the frames of a bag."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, Protocol, Sequence

from .base.arrays import NO_ARRAY, Image
from .geometry.lens import Lens
from .looks.hanging import Hanging, OnWall
from .painting.paint import shares
from .painting.picture import Picture
from .painting.place import Place
from .settings.settings import DetectionSettings, PictureSettings
from .tags.tag import Tag
from .tracking.area import Area
from .tracking.observer import Observer, is_same_area
from .tracking.sight import SeenArea, Sight

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

    def shares(self, warped: Image, place: Place) -> tuple[Image, Image]:
        """What to add to the window of a Place to paint a warped picture, and what to subtract from it first.

        See painting.paint.shares. The settings may ask for more, such as that people stay in front.
        """
        mask = place.mask
        if self.on_wall is not None:
            warped, mask = self.on_wall.apply(warped, place)
        return shares(place.window, warped, mask, self.settings.opacity)


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


class Source(Protocol):
    """The source of a picture, such as a Still or a Clip."""

    def at(self, stamp: float) -> Image | None:
        """The picture to show at a time, seconds; None if there is none yet."""


class Runner:
    """Runs an Exercise on the frames of a camera, once for each area."""

    def __init__(self, exercise: Exercise, settings: Sequence[DetectionSettings],
                 open_source: Callable[[str], Source], previous: Runner | None = None) -> None:
        """``settings``: the node's parameters, for each area.

        ``open_source``: a function that opens the Source that the parameter ``picture`` names. ``previous``:
        the Runner with the settings before a change. What it has learned and its sources are kept, as far as
        their own settings are unchanged. Raises InputError.
        """
        self.needs, self._exercise, self._open_source = exercise.needs, exercise, open_source
        self._observer: Observer = Observer(settings, TAGS in exercise.needs, AREA in exercise.needs,
                                            None if previous is None else previous._observer)
        opens = open_source if PICTURE in exercise.needs else None
        before: Sequence[_Canvas | None] = [None] * len(settings) if previous is None else previous._canvases
        self._canvases: list[_Canvas] = [_Canvas(own, opens, kept) for own, kept in zip(settings, before)]

    @property
    def sources(self) -> list[Source]:
        """The sources of the pictures of all areas."""
        return [canvas.source for canvas in self._canvases if canvas.source is not None]

    def run(self, frame: Image, stamp: float, lens: Lens | None = None,
            keeps_frame: bool = False) -> tuple[Sight, Sequence[Image]]:
        """The Sight of a frame, and what the exercise makes of it: an image for each of its topics.

        ``keeps_frame``: whether the frame must stay as it is. Otherwise it may be painted on. The other
        arguments are those of Observer.look.
        """
        sight = self._observer.look(frame, stamp, lens)
        image = frame.copy() if keeps_frame or len(self._canvases) > 1 else frame
        seen_areas = sight.areas or [SeenArea(None, sight.tags)]
        tags: list[Tag] = []
        images: Sequence[Image] = [image]
        for canvas, seen in zip(self._canvases, seen_areas):
            result = self._exercise.step(canvas.scene(sight, seen, images[-1]))
            tags, images = [*tags, *result.tags], result.images
        return replace(sight, tags=tuple(tags)), images

    def changed(self, settings: Sequence[DetectionSettings]) -> Runner:
        """A new Runner with changed settings. This one is unchanged. Raises InputError."""
        return Runner(self._exercise, settings, self._open_source, self)

    def reset(self) -> None:
        """Forget all that was learned from frames."""
        self._observer.reset()
        for canvas in self._canvases:
            canvas.reset()


class _Canvas:
    """What is kept from frame to frame to paint one area. Without a picture, it keeps nothing."""

    def __init__(self, settings: DetectionSettings, open_source: Callable[[str], Source] | None,
                 previous: _Canvas | None) -> None:
        """``open_source``: None if no picture is needed. The others are those of Runner, for this area."""
        self._settings = settings
        self.source: Source | None = None
        self._hanging, self._picture = Hanging(), Picture(NO_ARRAY)
        if open_source is None or not isinstance(settings, PictureSettings):
            return
        if previous is not None and isinstance(previous._settings, PictureSettings):
            if is_same_area(previous._settings, settings):
                self._hanging = previous._hanging
            if previous._settings.picture == settings.picture:
                self.source = previous.source
        if self.source is None:
            self.source = open_source(settings.picture)

    def scene(self, sight: Sight, seen: SeenArea, image: Image) -> Scene:
        """The Scene of the area in a frame. ``image``: what to paint on. Tags are hidden in it if asked for."""
        pixels = None if self.source is None else self.source.at(sight.stamp)
        scene = Scene(sight.frame, image, self._settings, seen.tags, seen.area, lens=sight.bending)
        if pixels is None or not isinstance(self._settings, PictureSettings):
            return scene
        if pixels is not self._picture.pixels:
            self._picture = Picture(pixels)
        return replace(scene, picture=self._picture,
                       on_wall=self._hanging.update(sight, seen, image, self._settings))

    def reset(self) -> None:
        """Forget what was learned of the wall."""
        self._hanging.reset()
