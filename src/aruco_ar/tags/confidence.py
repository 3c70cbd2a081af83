"""How sure it is that what looks like a tag is one."""
from __future__ import annotations

from math import exp, log
from operator import mul

import numpy as np

from aruco_ar.base.arrays import Image

from .tag import get_dictionary

# How much each part of the evidence counts: the coefficients of a logistic regression, which
# "python3 -m benchmark.false_tags.fitting" finds.
COEFFICIENTS = -25.567, -2.966, 8.981, -2.833
LEAST_LACK = 0.004  # a likeness is not known better than this
TURNS = 4


class Confidence:
    """Tells how sure it is that a tag is one, 0 to 1: of tags at 0.9, nine of ten are true.

    This holds if a dictionary is looked for in about seven frames without any of its tags for each frame with
    some. Where tags are rarer, fewer of those found are true. ``dictionary``: its name. ``ids``: how many
    different ids are looked for; 0: all.
    """

    def __init__(self, dictionary: str, ids: int = 0) -> None:
        marker = get_dictionary(dictionary)
        patterns = len(marker.bytesList)
        self._cells = marker.markerSize**2
        # The fewer patterns there are to be found, the less likely is one by chance.
        self._of_fewer = log(patterns / (ids or patterns))
        self._of_one = log(patterns * TURNS)

    def of(self, likeness: float, changes: int, is_expected: bool = False) -> float:
        """The confidence in a tag.

        ``likeness``: see fit_tags. ``changes``: see count_changes. ``is_expected``: whether only this tag was
        looked for in this place, so that no other could have been found.
        """
        odds = sum(map(mul, COEFFICIENTS, evidence(likeness, changes, self._cells)))
        return 1 / (1 + exp(-odds - (self._of_one if is_expected else self._of_fewer)))


def evidence(likeness: float, changes: int, cells: int) -> tuple[float, float, float, float]:
    """What speaks for a tag, in the order of COEFFICIENTS; the first is always 1.

    How little its likeness lacks to be perfect, and how often its pattern changes from dark to light, since
    most other things are plain or striped. A larger pattern, of more ``cells`` without the border, has more
    changes anyway.
    """
    return 1, log(max(1 - likeness, 0) + LEAST_LACK), log(max(changes, 1)), log(cells)


def count_changes(cells: Image) -> int:
    """How many of a tag's cells differ from the one to the left, and from the one above.

    ``cells``: see tag_cells.
    """
    light = cells > 127
    return int(np.sum(light[:, 1:] != light[:, :-1]) + np.sum(light[1:] != light[:-1]))
