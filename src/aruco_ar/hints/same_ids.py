"""Tags with the same id."""
from __future__ import annotations

from typing import Sequence

import numpy as np

from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

from .lasting import Lasting

LASTING_S = 2.0  # a hint is given when an id has been several times in sight for this time
GONE_S = 0.5     # an id of which this was not seen for this time is not several times in sight any more


class SameIds:
    """Watches, while no area is known, whether an id is several times in sight.

    ``hint``: a sentence that names such ids, with what to do; None without them.
    """

    def __init__(self) -> None:
        self._lasting: Lasting[int, None] = Lasting(LASTING_S, GONE_S)
        self.reset()

    def reset(self) -> None:
        """Forget the frames before."""
        self.hint: str | None = None
        self._lasting.reset()

    def update(self, stamp: float, tags: Sequence[Tag], has_area: bool) -> None:
        """Take in the tags of a frame at a time, seconds. ``has_area``: whether the area is known."""
        if has_area:
            self.reset()
            return
        ids = sorted(self._lasting.update(stamp, dict.fromkeys(_several_times(tags))))
        self.hint = None if not ids else (
            '%s several times in sight: %s. Nothing shows which one is meant, so the area does not use %s. '
            'Hang up four tags with different ids, each once.' % (
                ('An id is', ids[0], 'it') if len(ids) == 1 else
                ('%d ids are' % len(ids), ', '.join(map(str, ids[:8])), 'them')))


def _several_times(tags: Sequence[Tag]) -> set[int]:
    """The ids of which there are tags in different places."""
    first: dict[int, Tag] = {}
    found = set()
    for tag in tags:
        other = first.setdefault(tag.id, tag)
        if np.linalg.norm(tag.center - other.center) > side_of(tag.corners[None])[0]:
            found.add(tag.id)
    return found
