"""What may surprise a user of an area that was found: which tags it is between, and which way up it is."""
from __future__ import annotations

from typing import Sequence

import numpy as np

from aruco_ar.tags.tag import Tag, listed
from aruco_ar.tracking.area import Area

from .lasting import Lasting

LASTING_S = 2.0  # a hint is given when it has been true for this time
GONE_S = 1.0     # and withdrawn after this time: more tags than those of the area are not found in every frame
NEAR = 0.1       # a corner this near to a tag's center is at that tag; a share of the area's shortest side
NOTES = MANY_TAGS, UPSIDE_DOWN = 'more than four tags', 'upside down'  # the kinds of sentences


class AreaHints:
    """Watches an area, frame by frame. ``sentences``: {kind: sentence}, those that are true now."""

    def __init__(self, ids: Sequence[int], upright: str | None) -> None:
        """``ids``: those that the area's tags must have, if any. ``upright``: see Tracker; None without one."""
        self._ids, self._upright = ids, upright
        self._lasting: Lasting[str, str] = Lasting(LASTING_S, GONE_S)
        self.reset()

    def reset(self) -> None:
        """Forget the frames before."""
        self.sentences: dict[str, str] = {}
        self._lasting.reset()

    def update(self, stamp: float, tags: Sequence[Tag], area: Area | None) -> None:
        """Take in a frame at a time, seconds, with the tags in sight and the Area, if it is known."""
        found: dict[str, str | None] = {}
        if area is not None:
            found = {MANY_TAGS: None if self._ids else _choice(tags, area),
                     UPSIDE_DOWN: _upside_down(area) if self._upright == 'tags' else None}
        true = {kind: sentence for kind, sentence in found.items() if sentence}
        self.sentences = self._lasting.update(stamp, true)


def _choice(tags: Sequence[Tag], area: Area) -> str | None:
    ids = sorted({tag.id for tag in tags})
    if len(ids) <= 4:
        return None
    centers = np.array([tag.center for tag in tags])
    away = np.linalg.norm(area.corners[:, None] - centers, axis=2)
    sides = np.linalg.norm(area.corners - np.roll(area.corners, -1, axis=0), axis=1)
    if away.min(axis=1).max() > NEAR * sides.min():
        return None  # a tag of the area is out of sight
    taken = [tags[number].id for number in away.argmin(axis=1)]
    return ('%d tags are in sight: %s. The area is between the outermost four. Keep these four by ids:=%s, '
            'or give four others that span the area you want.' % (
                len(ids), listed(ids), ','.join(map(str, taken))))


def _upside_down(area: Area) -> str | None:
    (x1, y1), (x2, y2), (x3, y3), (x4, y4) = area.corners.tolist()  # NumPy's mean takes ten times as long
    across, down = x3 + x4 - x1 - x2, y3 + y4 - y1 - y2  # from the top to the foot
    if down > -abs(across):
        return None
    return 'The tags hang upside down in the image, so the top of the area is below. Turn it by upright:=image.'
