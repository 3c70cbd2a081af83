"""All tags in a sequence of frames, found at a small part of the cost of searching each frame."""
from __future__ import annotations

import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.tags.detector import Detector
from aruco_ar.tags.tag import Tag

from .frame_clock import FrameClock

SEARCH_S = 0.2    # new tags are looked for at least this often
RETURN_S = 1.0    # a tag that was lost is looked for in each frame for this time
GAP_S = 0.1       # frames that are farther apart say little about where a tag is next
FOUR = 4          # while fewer tags than this are in sight, each frame is searched for more: an area needs four


class FollowedTags:
    """Looks for the tags of the last frame where they should be now.

    The whole frame is searched while one of them is not there, and now and then for new ones. A tag must look
    the same in both cases, so what is found is as certain.
    """

    def __init__(self, detector: Detector) -> None:
        self._detector, self._clock = detector, FrameClock()
        self._tags: list[Tag] = []
        self._speeds: Floats = np.zeros((0, 4, 2), np.float32)  # pixels per second, of the corners
        self._shape: tuple[int, ...] = ()
        self._seen_at: dict[int, float] = {}  # when each id was last in sight
        self._searched_at = -np.inf

    def find(self, frame: Image, stamp: float) -> list[Tag]:
        """The tags in a frame, (h, w, 3) BGR or (h, w) gray, uint8, at a time, seconds."""
        is_next = not self._clock.goes_back(stamp) and frame.shape == self._shape
        passed = self._clock.advance(stamp)
        self._shape = frame.shape
        tags = self._followed(frame, passed) if is_next and passed <= GAP_S else []
        if not tags:
            tags = self._detector.detect(frame)
            self._searched_at = self._clock.now
        before = {tag.id: tag for tag in self._tags}
        self._speeds = np.array([(tag.corners - before.get(tag.id, tag).corners) / passed for tag in tags],
                                np.float32).reshape(-1, 4, 2)
        self._tags = tags
        self._seen_at.update((tag.id, self._clock.now) for tag in tags)
        return tags

    def _followed(self, frame: Image, passed: float) -> list[Tag]:
        """The tags of the last frame in this one; none of them if the frame must be searched."""
        now, ids = self._clock.now, {tag.id for tag in self._tags}
        self._seen_at = {tag_id: seen for tag_id, seen in self._seen_at.items() if now - seen < RETURN_S}
        if len(ids) < FOUR or now - self._searched_at >= SEARCH_S or self._seen_at.keys() - ids:
            return []
        quads = np.stack([tag.corners for tag in self._tags]) + np.float32(passed) * self._speeds
        tags = self._detector.find_at(frame, [tag.id for tag in self._tags], quads)
        return tags if len(tags) == len(self._tags) else []
