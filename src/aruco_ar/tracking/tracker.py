"""The tracker, which keeps the area on the wall while tags come and go."""
from __future__ import annotations

from typing import Any, Iterable, Sequence

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.lens import Lens
from aruco_ar.settings.settings import HOLD_S, LEARN
from aruco_ar.tags.detector import Detector
from aruco_ar.walls.remembered import load_remembered

from .area import Area
from .area_tracker import AreaTracker
from .sight import SeenArea
from .tag_search import ANY_SIDE, FrameSearch, TagSearch


class Tracker(AreaTracker):
    """Tracks the area through a sequence of frames.

    The four tags must be seen together once. Then the tracker knows the places
    of all tags in the plane of the wall, and any of them locates the area.
    With a lens, it works in undistorted pixels, in which a wall is flat.

    ``dictionary``, ``ids``: see Detector. ``hold``: seconds, 0 or more. When
    the area cannot be located well enough, it is kept for at most this time.
    ``upright``: the picture's top is at the tags' own tops (``tags``) or at the
    frame's top (``image``). ``wall``: the path of a file that ``save_wall``
    wrote, with which the wall is known from the first frame on, or ``learn``.
    ``detection``: further arguments of Detector, such as ``search``, for frames
    in which no area is expected. Raises InputError for any other value.
    """

    def __init__(self, dictionary: str = 'DICT_6X6_250', ids: Iterable[int] = (), hold: float = HOLD_S,
                 upright: str = 'tags', wall: str = LEARN, **detection: Any) -> None:
        if not isinstance(hold, (int, float)) or not hold >= 0:
            raise InputError('An area cannot be held for %s; give seconds, 0 or more.' % (hold,))
        ids = frozenset(ids)
        Detector(dictionary, ids)  # raises if the dictionary does not have these ids
        # It searches for all ids, since other tags on the same plane help to locate the four.
        self._search, self._hold = TagSearch(dictionary, **detection), hold
        self._tags_are = dictionary, float(detection.get('border', 1.0))
        super().__init__(ids, upright, None if wall == LEARN else load_remembered(wall, *self._tags_are))

    def reset(self) -> None:
        super().reset()
        self._search.reset()

    def update(self, frame: Image, stamp: float, lens: Lens | None = None) -> Area | None:
        """The Area in a frame, or None.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``stamp``: its time in
        seconds. ``lens``: its Lens, or None if that is unknown or does not
        distort. The tracker is reset if the time goes back, or if the frame's
        size or the lens changes.
        """
        seen, = see_areas([self], [self._hold], FrameSearch(self._search, frame, lens), stamp)
        return seen.area

    def save_wall(self, path: str) -> None:
        """Write what was learned of the wall to a file. This takes some tenths of a second.

        Raises InputError if the wall is not known well enough yet, or if the file cannot be written.
        """
        self.learned().remembered(*self._tags_are).save(path)


def see_areas(trackers: Sequence[AreaTracker], holds: Sequence[float], search: FrameSearch,
              stamp: float) -> list[SeenArea]:
    """What each AreaTracker sees of its area in a frame. All together search the whole frame at most once.

    ``holds``: of each, how long the area is held, seconds: see Tracker. ``stamp``: the frame's time, seconds.
    """
    nearby = [tracker.find_nearby(search, stamp, hold) for tracker, hold in zip(trackers, holds)]
    smallest = [near.smallest for near in nearby if near.smallest is not None]
    beginners = [tracker for tracker, near in zip(trackers, nearby) if near.smallest == ANY_SIDE]
    found = search.find(min(smallest), lambda tags: all(
        tracker.shows_area(tags) for tracker in beginners)) if smallest else []
    return [tracker.locate(search, near, [] if near.smallest is None else found, hold)
            for tracker, near, hold in zip(trackers, nearby, holds)]
