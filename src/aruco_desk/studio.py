"""What a camera films, and what the exercises make of it, again and again in a thread: for a page."""
from __future__ import annotations

import logging
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any, Callable, Iterable, Mapping, Tuple

from aruco_ar.base.arrays import NO_ARRAY, Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package
from aruco_ar.calibration.camera_file import read_camera
from aruco_ar.exercise import TAGS
from aruco_ar.geometry.lens import Lens
from aruco_ar.hints.hints import Hints
from aruco_ar.hints.which_dictionary import dictionary_in
from aruco_ar.painting.sources import Clip, Still, open_source
from aruco_ar.runner import Runner
from aruco_ar.settings.declaration import checked, parameters_of
from aruco_ar.settings.settings import PictureSettings
from aruco_ar.tracking.observer import FOUND, NEEDED, Observer
from aruco_ar.tracking.sight import Sight
from page_server.choices import EXERCISES
from page_server.tiles import CAMERA

from .options import with_options
from .paint import WORDS, exercise

PAINTER = EXERCISES[-1]
RETRY_S = 2.0    # a camera that is away is tried again after this time
LOOK_S = 1.0     # the dictionary is looked for so often
END_S = 3.0      # a camera has this time for a frame when all ends
LOST_S = 1.0     # after this time without the area, it is said why
DROPPED = 'dropped %d'  # the value of the parameter picture for a picture in memory
_log = logging.getLogger(__name__)

Deliver = Callable[[str, Any, float], None]
Frames = Iterable[Tuple[float, Image]]


class Studio:
    """Runs the exercises that somebody looks at on each frame of a camera.

    It lives on if the camera goes away. ``settings``: how tags are found, and what is painted. ``trouble``: why
    there are no frames, in a sentence; '' while there are.
    """

    def __init__(self, film: Callable[[], Frames], settings: PictureSettings, knows_dictionary: bool,
                 calibration: str | None, deliver: Deliver, on_change: Callable[[], None]) -> None:
        """``film``: a function that begins to film. It returns an iterable of (seconds, frame).

        It may raise InputError, also while it iterates. ``knows_dictionary``: whether the settings name the
        dictionary; if not, it is found. ``calibration``: the path of the camera's calibration, or None.
        ``deliver`` is called in the thread with a name, an image or a list of ids, and the time of the frame:
        for CAMERA, and for the ``image`` and the ``tags`` of each of EXERCISES that are ``wanted``.
        ``on_change`` is called, from any thread, when the settings or a sentence have changed. Raises
        InputError if the settings cannot be used.
        """
        self.settings, self.trouble = settings, 'The camera is being opened.'
        self.wanted: Mapping[str, bool] = {}
        self._film, self._deliver, self._on_change = film, deliver, on_change
        self._calibration, self._knows_dictionary = calibration, knows_dictionary
        self._told: set[str] = set()  # what the terminal has been told; each sentence once
        self._lens: Lens | None = None
        self._size: tuple[int, int] | None = None
        self._dropped: Image = NO_ARRAY  # the picture that was dropped last
        self._drop_count = 0
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._steps = {name: exercise(name[len('exercise'):].replace('_', '.')) for name in EXERCISES}
        self._observer = Observer([settings])  # looks at each frame once, for all exercises
        self._runners = {name: Runner(step, [settings], self._open, observer=self._observer)
                         for name, step in self._steps.items()}
        self._finds_all = False  # whether the Observer finds all tags, or those that tell where the area is
        self._advice = ''
        self._hints = self._new_hints()
        self._seen = self._looked = 0.0  # when the area was seen, and the dictionary was looked for
        self._searcher = ThreadPoolExecutor(1, 'searcher')
        self._thread = threading.Thread(target=self._run, name='studio', daemon=True)

    def start(self) -> None:
        """Begin to film."""
        self._thread.start()

    def end(self) -> None:
        """Film no longer. Waits until the current frame is done, but not for a camera that hangs."""
        self._ended.set()
        self._thread.join(END_S)

    @property
    def advice(self) -> tuple[str, bool]:
        """(a sentence for the user, whether it says why there are no frames); '' without a sentence."""
        return (self.trouble, True) if self.trouble else (self._advice, False)

    @property
    def drop_value(self) -> str:
        """The value of ``picture`` for the picture that was dropped last."""
        return DROPPED % self._drop_count

    def drop(self, picture: Image) -> None:
        """Take a picture, (h, w, 3 or 4) uint8, that can then be painted as ``drop_value``."""
        with self._lock:
            self._dropped = picture
            self._drop_count += 1

    def change(self, values: Mapping[str, Any]) -> None:
        """Change settings, {name: value}. Raises InputError if one cannot be used; then none is changed."""
        self._apply(values)
        self._knows_dictionary = self._knows_dictionary or 'dictionary' in values

    def _apply(self, values: Mapping[str, Any]) -> None:
        kinds = parameters_of(PictureSettings)
        taken = {name: checked(name, kinds[name], value) for name, value in values.items()}
        with self._lock:
            settings = replace(self.settings, **taken)
            self._use(settings)
            self.settings = settings
            self._hints = self._new_hints()
        self._on_change()

    def _use(self, settings: PictureSettings) -> None:
        observer = Observer([settings], FOUND if self._finds_all else NEEDED, previous=self._observer)
        self._runners = {name: Runner(step, [settings], self._open, self._runners[name], observer=observer)
                         for name, step in self._steps.items()}
        self._observer = observer

    def save_wall(self, path: str) -> None:
        """Write what was learned of the wall. Raises InputError if that is too little, or if writing fails."""
        with self._lock:
            wall, = self._runners[PAINTER].learned_walls()
        wall.remembered(self.settings.dictionary, self.settings.border).save(path)

    def _open(self, picture: str) -> Still | Clip:
        if self._drop_count and picture == self.drop_value:
            return Still(self._dropped)
        return open_source(in_package(picture))

    def _new_hints(self) -> Hints:
        return Hints(self.settings.of_detector(), self.settings.upright, words=WORDS)

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                for stamp, frame in self._film():
                    if self._ended.is_set():
                        return
                    self._say('')
                    self._show(frame, stamp)
                self._say('The camera sends no more frames.')
            except InputError as error:
                self._say(str(error))
            except Exception:  # whatever it is, the next frame may be all right
                _log.exception('A frame could not be shown')
                self._say('A frame could not be shown; the terminal says why.')
            self._ended.wait(RETRY_S)

    def _say(self, trouble: str) -> None:
        if trouble != self.trouble:
            self.trouble = trouble
            self._on_change()
        if trouble and trouble not in self._told:
            self._told.add(trouble)
            _log.warning('aruco-ar: %s', trouble)

    def _show(self, frame: Image, stamp: float) -> None:
        with self._lock:
            self._update_lens((frame.shape[1], frame.shape[0]))
            self._deliver(CAMERA, frame, stamp)
            wanted = [name for name in EXERCISES if self.wanted.get(name)]
            finds_all = any(TAGS in self._steps[name].needs for name in wanted)
            if finds_all != self._finds_all:
                self._finds_all = finds_all
                self._use(self.settings)
            sight = self._observer.look(frame, stamp, self._lens)
            for name in wanted:
                seen, images = self._runners[name].show(sight, keeps_frame=True)
                self._deliver(name + '/tags', sorted(tag.id for tag in seen.tags), stamp)
                self._deliver(name + '/image', images[-1], stamp)
            self._advise(sight)

    def _update_lens(self, size: tuple[int, int]) -> None:
        if self._calibration is not None and size != self._size:
            self._size, self._lens = size, read_camera(self._calibration, size)

    def _advise(self, sight: Sight) -> None:
        """Find out what a user should know of a frame, and the dictionary, if the area is not seen."""
        for search in self._hints.update(sight):
            self._searcher.submit(search)
        seen, lost = sight.areas[0], ''
        if seen.area is not None:
            self._seen = sight.stamp
        elif sight.stamp - self._seen > LOST_S:
            lost = seen.explanation
            if not self._knows_dictionary and sight.stamp - self._looked > LOOK_S:
                self._looked = sight.stamp
                self._searcher.submit(dictionary_in, [sight.frame], self.settings.dictionary).add_done_callback(
                    self._on_dictionary)
        advice = with_options(self._hints.warning or ' '.join(self._hints.notes.values()) or lost)
        if advice != self._advice:
            self._advice = advice
            self._on_change()

    def _on_dictionary(self, found: Future[str | None]) -> None:
        """Take the dictionary that four tags in a frame are of, unless it has been chosen meanwhile."""
        name = found.result() if not found.exception() else None
        if name is not None and name != self.settings.dictionary and not self._knows_dictionary:
            self._apply({'dictionary': name})
