"""Looks at each frame of a camera once, for all who want to know something of it."""
from __future__ import annotations

from typing import Callable, Sequence

from aruco_ar.base.arrays import Image
from aruco_ar.geometry.lens import Lens
from aruco_ar.settings.settings import CORRECT, AreaSettings, DetectionSettings, LensSettings
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import Tag

from .area_tracker import AreaTracker
from .followed_tags import FollowedTags
from .learned_wall import LearnedWall
from .sight import Sight
from .tag_search import FrameSearch, TagSearch
from .tracker import see_areas

# Which tags are wanted: those that tell where an area is; all that a search of the frame finds; or all, but
# new ones may be found a little later, which takes a small part of the time (see FollowedTags).
NEEDED, FOUND, FOLLOWED = 'needed', 'found', 'followed'


class Observer:
    """Makes the Sight of each frame. Nothing else searches the frames of a camera for tags."""

    def __init__(self, settings: Sequence[DetectionSettings], tags: str = NEEDED, tracks: bool = True,
                 previous: Observer | None = None, in_thread: bool = False) -> None:
        """``settings``: those of each area; AreaSettings if it is tracked.

        ``tags``: which are wanted in each frame, NEEDED, FOUND or FOLLOWED. ``tracks``: whether the areas are
        tracked. ``previous``: the Observer with the settings before a change. What it has learned is kept, as
        far as is_same_area. ``in_thread``: whether a remembered wall is searched for in a thread of its own, so
        that no frame is late. Raises InputError.
        """
        for own in settings:
            Detector(**own.of_detector())  # raises if the dictionary does not have the ids
        self._corrects = isinstance(settings[0], LensSettings) and settings[0].lens == CORRECT
        any_id = not all(own.ids for own in settings)
        self._ids = None if any_id else {tag_id for own in settings for tag_id in own.ids}
        # It searches for all ids, since other tags on the same plane help to locate an area.
        self._search = TagSearch(**{**settings[0].of_detector(), 'ids': ()})
        detector = self._search.detector
        self._find: Callable[[Image, float], list[Tag] | None] = {
            NEEDED: lambda frame, stamp: None,
            FOUND: lambda frame, stamp: detector.detect(frame),
            FOLLOWED: FollowedTags(detector).find}[tags]
        self._areas = [own for own in settings if tracks and isinstance(own, AreaSettings)]
        before = [] if previous is None else list(zip(previous._areas, previous._trackers))
        self._trackers: list[AreaTracker] = []
        for number, own in enumerate(self._areas):
            if number < len(before) and is_same_area(before[number][0], own):
                self._trackers.append(before[number][1])
            else:
                self._trackers.append(AreaTracker(own.ids, own.upright, own.remembered_wall(), in_thread))

    def look(self, frame: Image, stamp: float, lens: Lens | None = None) -> Sight:
        """The Sight of a frame, (h, w, 3) BGR uint8.

        ``stamp``: its time, seconds. ``lens``: its Lens, or None if the camera is not calibrated. What was
        learned of the areas is forgotten if the time goes back, or if the frame's size or the lens changes.
        """
        bending = lens if lens is not None and self._corrects and lens.bends else None
        found = self._find(frame, stamp)
        areas = see_areas(self._trackers, [own.hold for own in self._areas],
                          FrameSearch(self._search, frame, bending, found), stamp)
        tags = [tag for area in areas for tag in area.tags] if found is None else \
            [tag for tag in found if self._ids is None or tag.id in self._ids]
        return Sight(frame, stamp, lens, bending, tuple(tags), tuple(areas))

    def learned_walls(self) -> list[LearnedWall]:
        """What was learned of the wall of each area. Raises InputError if one is not known well enough."""
        return [tracker.learned() for tracker in self._trackers]

    def reset(self) -> None:
        """Forget all that was learned of the areas."""
        self._search.reset()
        for tracker in self._trackers:
            tracker.reset()


def is_same_area(before: AreaSettings, after: AreaSettings) -> bool:
    """Whether what was learned of an area is of use after a change of its settings."""
    return (before.of_detector() == after.of_detector() and before.upright == after.upright
            and before.wall == after.wall)
