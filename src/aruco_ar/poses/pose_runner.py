"""The poses in each frame of a camera."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Sequence

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package
from aruco_ar.calibration.lens_check import LensCheck
from aruco_ar.geometry.lens import Lens
from aruco_ar.settings.settings import PoseSettings
from aruco_ar.tags.tag import DICTIONARIES
from aruco_ar.tracking.learned_wall import LearnedWall
from aruco_ar.tracking.observer import FOLLOWED, Observer
from aruco_ar.tracking.sight import Sight
from aruco_ar.walls.wall import Wall, load_wall

from .area_pose import AreaPose
from .estimator import CameraPose, PoseEstimator, TagPose
from .wall_watch import WallWatch

# After a change of one of these settings, the places of the tags are learned anew.
RELEARN_AFTER = 'dictionary', 'tag_size', 'tag_sizes', 'wall'


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses in one frame. Without a lens there are none.

    ``tags``: a TagPose for each tag in sight, by id. ``area``, ``camera``: the
    poses of the area and of the camera relative to the wall, or None if they
    are not known or not wanted. ``misfit``: what is wrong with the wall's file,
    in a sentence, or None. ``hint``: what is wrong with the lens, or None.
    ``work``: functions that check the lens, which takes some tenths of a second;
    they may be called in another thread.
    """

    tags: Sequence[TagPose] = ()
    area: AreaPose | None = None
    camera: CameraPose | None = None
    misfit: str | None = None
    hint: str | None = None
    work: Sequence[Callable[[], None]] = ()


class PoseRunner:
    """Estimates the poses in each frame of a camera, as a Runner runs an exercise."""

    def __init__(self, settings: PoseSettings, previous: PoseRunner | None = None,
                 in_thread: bool = False) -> None:
        """``previous``: the PoseRunner with the settings before a change. It keeps what is still of use.

        ``in_thread``: see Observer. Raises InputError if there is no such wall, or if its tags are of another
        dictionary.
        """
        self._settings, self._in_thread = settings, in_thread
        self._lens_check: LensCheck = LensCheck() if previous is None else previous._lens_check
        self._others = {tag_id for tag_id, _ in settings.tag_sizes}  # tags of another size than most
        self._observer: Observer = Observer([settings], FOLLOWED,
                                            previous=None if previous is None else previous._observer,
                                            in_thread=in_thread)
        self._wall: Wall | None
        self._estimator: PoseEstimator
        self._watch: WallWatch
        if previous is not None and all(getattr(settings, name) == getattr(previous._settings, name)
                                        for name in RELEARN_AFTER):
            self._wall, self._estimator, self._watch = previous._wall, previous._estimator, previous._watch
        else:
            is_same_wall = previous is not None and previous._settings.wall == settings.wall
            self._wall = previous._wall if previous is not None and is_same_wall else _load_wall(settings)
            _check_dictionary(settings, self._wall)
            self._reset_poses()

    def run(self, frame: Image, stamp: float, lens: Lens | None = None,
            wants_area: bool = True) -> tuple[Sight, Poses]:
        """The Sight of a frame, and the Poses in it.

        ``wants_area``: whether the area's pose is wanted, too. The other arguments are those of Observer.look.
        """
        sight = self._observer.look(frame, stamp, lens)
        check = self._lens_check.update(stamp, [tag for tag in sight.tags if tag.id not in self._others], lens)
        hint, work = self._lens_check.hint, () if check is None else (check,)
        if lens is None:
            return sight, Poses(hint=hint, work=work)
        tags = sorted(self._estimator.update(sight.tags, lens, stamp), key=lambda pose: pose.id)
        area, camera = sight.areas[0].area if wants_area else None, self._estimator.camera()
        return sight, Poses(tags, None if area is None else self._estimator.area(area, lens), camera,
                            self._watch.check(tags, camera, stamp), hint, work)

    def changed(self, settings: Sequence[PoseSettings]) -> PoseRunner:
        """A new PoseRunner with changed settings of its one area. This one is unchanged. Raises InputError."""
        own, = settings
        return PoseRunner(own, self, self._in_thread)

    def learned_walls(self) -> list[LearnedWall]:
        """See Observer."""
        return self._observer.learned_walls()

    def reset(self) -> None:
        """Forget all that was learned from frames."""
        self._observer.reset()
        self._reset_poses()

    def _reset_poses(self) -> None:
        settings = self._settings
        self._estimator = PoseEstimator(settings.tag_size, dict(settings.tag_sizes), self._wall)
        self._watch = WallWatch(self._wall, settings.wall)


def _load_wall(settings: PoseSettings) -> Wall | None:
    """The Wall that settings name; None if the places of its tags are learned."""
    return None if settings.learns_places else load_wall(in_package(settings.wall))


def _check_dictionary(settings: PoseSettings, wall: Wall | None) -> None:
    """Raise InputError if the tags of a wall are of another dictionary than settings say."""
    if wall is not None and DICTIONARIES[wall.dictionary] != DICTIONARIES[settings.dictionary]:
        raise InputError('The wall "%s" has tags of the dictionary %s, but the node looks for tags of %s. '
                         "Give the wall's dictionary: dictionary:=%s."
                         % (settings.wall, wall.dictionary, settings.dictionary, wall.dictionary))
