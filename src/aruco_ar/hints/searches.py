"""Searches for tags now and then, which take a small share of the time of another thread."""
from __future__ import annotations

import time
from functools import partial
from typing import Callable, FrozenSet, Generic, TypeVar

import cv2

from aruco_ar.base.arrays import Image

LARGE_PX = 1000  # larger frames are shrunk until their longer side is LARGE_PX
SHARE = 0.05     # of the time: the searches take no more, unless they are sooner

Found = FrozenSet[int]  # ids of tags
Item = TypeVar('Item')


class Searches(Generic[Item]):
    """Says when to search next, and keeps the set that the last search found until it is taken."""

    def __init__(self, pause: float) -> None:
        """``pause``: seconds between two searches, at least."""
        self._pause = self._wait = pause
        self._began = float('-inf')
        self._running = False
        self._resets = 0  # a search that began before the last one is of no use
        self._result: tuple[int, frozenset[Item]] | None = None

    def reset(self) -> None:
        """Forget what was found, and what is being found."""
        self._resets += 1

    def take(self) -> frozenset[Item] | None:
        """What the last search found, once; None if there is nothing new."""
        result = self._result
        if result is None:
            return None
        self._result = None
        resets, found = result
        return found if resets == self._resets else None

    def is_due(self, stamp: float, factor: float = 1.0) -> bool:
        """Whether to search in a frame at a time, seconds. ``factor``: of the usual pause."""
        return self._result is None and self.may_be_due(stamp, factor)

    def may_be_due(self, stamp: float, factor: float = 1.0) -> bool:
        """Whether to search in a frame at a time, once what the last search found is taken."""
        return not (self._running or 0 <= stamp - self._began < factor * self._wait)

    def start(self, stamp: float, find: Callable[[], frozenset[Item]]) -> Callable[[], None]:
        """The work of a search in a frame at a time, seconds, for another thread: it calls ``find``."""
        self._began, self._running = stamp, True
        return partial(self._search, self._resets, find)

    def _search(self, resets: int, find: Callable[[], frozenset[Item]]) -> None:
        began = time.thread_time()
        try:
            self._result = resets, find()
        finally:
            self._wait = max(self._pause, (time.thread_time() - began) / SHARE)
            self._running = False  # last of all: another thread looks at it first


def shrunk(frame: Image) -> tuple[Image, float]:
    """A frame, uint8, BGR or gray, at most LARGE_PX wide and high, and by which factor it was resized."""
    scale = max(min(1.0, LARGE_PX / max(frame.shape[:2])), 1 / min(frame.shape[:2]))  # a pixel must be left
    if scale == 1:
        return frame, 1.0
    return cv2.resize(frame, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), scale
