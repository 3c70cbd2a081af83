"""Runs an exercise on the frames of a camera."""
from __future__ import annotations

from dataclasses import replace
from typing import Callable, Protocol, Sequence

from .base.arrays import NO_ARRAY, Image
from .exercise import AREA, PICTURE, TAGS, Exercise, Result, Scene
from .geometry.lens import Lens
from .looks.hanging import Hanging
from .painting.picture import Picture
from .settings.settings import DetectionSettings, PictureSettings
from .tracking.learned_wall import LearnedWall
from .tracking.observer import FOUND, NEEDED, Observer, is_same_area
from .tracking.sight import SeenArea, Sight


class Source(Protocol):
    """The source of a picture, such as a Still or a Clip."""

    def at(self, stamp: float) -> Image | None:
        """The picture to show at a time, seconds; None if there is none yet."""


class Runner:
    """Runs an Exercise on the frames of a camera, once for each area."""

    def __init__(self, exercise: Exercise, settings: Sequence[DetectionSettings],
                 open_source: Callable[[str], Source], previous: Runner | None = None,
                 in_thread: bool = False, observer: Observer | None = None) -> None:
        """``settings``: the node's parameters, for each area.

        ``open_source``: a function that opens the Source that the parameter ``picture`` names. ``previous``:
        the Runner with the settings before a change. What it has learned and its sources are kept, as far as
        their own settings are unchanged. ``in_thread``: see Observer. ``observer``: the Observer of these
        settings, if several Runners share it; else the Runner has its own. Raises InputError.
        """
        self._exercise, self._open_source, self._in_thread = exercise, open_source, in_thread
        self._observer: Observer = observer or Observer(
            settings, FOUND if TAGS in exercise.needs else NEEDED, AREA in exercise.needs,
            None if previous is None else previous._observer, in_thread)
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
        return self.show(self._observer.look(frame, stamp, lens), keeps_frame)

    def show(self, sight: Sight, keeps_frame: bool = False) -> tuple[Sight, Sequence[Image]]:
        """The same as ``run``, of a frame at which the Observer has already looked."""
        frame = sight.frame
        image = frame.copy() if keeps_frame or len(self._canvases) > 1 else frame
        is_own = AREA not in self._exercise.needs  # it may also find the tags itself, as 5.2 does
        seen_areas = [SeenArea(None, sight.tags)] if is_own else sight.areas
        result = Result([image], sight.tags)
        for canvas, seen in zip(self._canvases, seen_areas):
            result = self._exercise.step(canvas.scene(sight, seen, result.images[-1]))
        return replace(sight, tags=tuple(result.tags)) if is_own else sight, result.images

    def changed(self, settings: Sequence[DetectionSettings]) -> Runner:
        """A new Runner with changed settings. This one is unchanged. Raises InputError."""
        return Runner(self._exercise, settings, self._open_source, self, self._in_thread)

    def learned_walls(self) -> list[LearnedWall]:
        """See Observer."""
        return self._observer.learned_walls()

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
