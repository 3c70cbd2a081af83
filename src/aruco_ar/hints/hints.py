"""All that a user of a camera may have overlooked."""
from __future__ import annotations

from typing import Any, Callable, Mapping, Protocol

from aruco_ar.tracking.frame_clock import FrameClock
from aruco_ar.tracking.sight import Sight

from .area_hints import AreaHints
from .light import Light
from .missed_tags import MissedTags
from .other_tags import OF_NODES, USUAL_BORDER, OtherTags, Words
from .same_ids import SameIds
from .shortfall import Shortfall


class Watcher(Protocol):
    """What watches for one thing that keeps tags from being found. Hints.update gives it what it needs.

    ``hint``: a sentence about it with the remedy; None without it.
    """

    hint: str | None

    def reset(self) -> None:
        """Forget the frames before."""


class Hints:
    """Watches frames and what is found in them.

    ``warning``: a sentence about what keeps tags from being found, or None. It ends with the remedy. A node
    logs each last word once, since the rest may change from frame to frame. ``notes``: {kind: sentence} about
    what may surprise the user.
    """

    def __init__(self, detection: Mapping[str, Any], upright: str | None, needs_area: bool = True,
                 words: Words = OF_NODES) -> None:
        """``detection``: the arguments of the Detector. ``upright``: see Tracker; None without one.

        ``needs_area``: whether tags that span no area are of no use. ``words``: see Words.
        """
        ids = detection['ids']
        self._other_tags = OtherTags(detection['dictionary'], ids, detection.get('border', USUAL_BORDER), words)
        self._missed_tags = MissedTags(detection)
        self._same_ids, self._light, self._shortfall = SameIds(), Light(), Shortfall()
        self._area_hints = AreaHints(ids, upright)
        # Of several warnings, the first one counts.
        self._warnings: tuple[Watcher, ...] = (self._same_ids, self._other_tags, self._missed_tags, self._light,
                                               self._shortfall)
        self._needs_area, self._clock = needs_area, FrameClock()

    @property
    def warning(self) -> str | None:
        return next((each.hint for each in self._warnings if each.hint), None)

    @property
    def notes(self) -> dict[str, str]:
        return self._area_hints.sentences

    def reset(self) -> None:
        """Begin anew, after a pause without frames."""
        self._area_hints.reset()
        for each in self._warnings:
            each.reset()

    def may_search(self, stamp: float) -> bool:
        """Whether a frame with that stamp, seconds, may be searched: then nothing must be drawn into it."""
        then = self._clock.now + self._clock.passed(stamp)
        return self._other_tags.may_search(then) or self._missed_tags.may_search(then)

    def update(self, sight: Sight) -> list[Callable[[], None]]:
        """Take in what is seen in a frame. Unless ``may_search`` was true, the frame may be painted on by now.

        Returns functions that search the frame for other tags. They may be called in another thread, and bring
        hints later.
        """
        self._clock.advance(sight.stamp)
        stamp, frame, areas = self._clock.now, sight.frame, sight.areas
        has_area = any(seen.area is not None for seen in areas)
        tags = [*sight.tags, *(tag for seen in areas for tag in seen.repeated)]
        ids = {tag.id for tag in tags}
        searches = [self._other_tags.update(frame, stamp, ids, has_area)]
        # Tags of another kind can look like a wanted one that is hard to see.
        if self._other_tags.has_looked and self._other_tags.hint is None:
            searches.append(self._missed_tags.update(frame, stamp, ids, has_area))
        else:
            self._missed_tags.reset()
        self._same_ids.update(stamp, tags, has_area)
        self._light.update(frame, stamp, bool(tags) or has_area)
        if len(areas) == 1:
            self._shortfall.update(stamp, areas[0].shortfall if self._needs_area else None, has_area)
            self._area_hints.update(stamp, tags, areas[0].area)
        return [search for search in searches if search is not None]
