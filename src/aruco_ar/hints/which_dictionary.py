"""Which dictionary the tags in some frames are of."""
from __future__ import annotations

from collections import Counter
from typing import Sequence

import cv2

from aruco_ar.base.arrays import Image

from .other_tags import FOUR, USUAL_BORDER
from .searches import shrunk
from .squares import PLAIN, read_squares, smallest_with

LEAST_SHARE = 0.4  # a tag must be in this share of the frames: by chance, anything looks like one in a few


def dictionary_in(frames: Sequence[Image], usual: str) -> str | None:
    """The dictionary of most tags in some frames, (h, w, 3) BGR uint8; None if these are fewer than four.

    It is ``usual`` if that has these tags, and else the smallest dictionary that has them.
    """
    times: Counter[tuple[tuple[str, ...], int]] = Counter()
    for frame in frames:
        squares = read_squares(shrunk(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))[0], [USUAL_BORDER])
        times.update({(kind.family, tag_id) for meanings in squares for kind, tag_id in meanings.items()
                      if kind.way == PLAIN})
    tags = [tag for tag, count in times.items() if count >= LEAST_SHARE * len(frames)]
    counts = Counter(family for family, _ in tags)
    if not counts:
        return None
    family = max(counts, key=lambda each: (counts[each], usual in each))
    if counts[family] < FOUR:
        return None
    highest = max(tag_id for each, tag_id in tags if each == family)
    return smallest_with([usual] * (usual in family) + list(family), highest)
