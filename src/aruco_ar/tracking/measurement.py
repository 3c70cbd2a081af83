"""The tags in a frame as a measurement for AreaMotion, and which of them are consistent with each other."""
from __future__ import annotations

from typing import Iterable, Mapping, Sequence

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.tags.edges import side_of
from aruco_ar.tags.tag import Tag

from .layout import Layout, tolerance_of
from .motion import AreaMotion

# A corner's bias is the same in every frame. It is BIAS_PX for a tag with a side of SMALL_PX, and four times as
# much for a tag half as large.
BIAS_PX, SMALL_PX = 0.10, 30.0
# A tag that is blurred, by motion or by a lens out of focus, has a lower likeness than this. Each corner may
# then be off by this share of the tag's side for each 1 that is missing. All are off alike, outward or inward.
SHARP_LIKENESS, SOFT_SIDES = 0.97, 0.3
# If more tags than this contradict each other, several are left out at once.
MANY_TAGS = 12


def measurement(layout: Layout, seen: Mapping[int, Tag],
                ids: Iterable[int]) -> tuple[Floats, Floats, Floats, Floats]:
    """The first arguments of AreaMotion.correct, for some tags: points, pixels, deviation and bias.

    ``seen``: {id: Tag}. ``ids``: the tags to take.
    """
    tags = [seen[tag_id] for tag_id in ids]
    quads = np.array([tag.corners for tag in tags], np.float64)
    deviations, biases = [], []
    for tag, side in zip(tags, side_of(quads).tolist()):
        soft = softness_of(tag, side)
        deviations += [0.15 + 0.002 * side + soft] * 4
        biases += [bias_of(side, soft)] * 4
    return layout.quads(ids).reshape(-1, 2), quads.reshape(-1, 2), np.array(deviations), np.array(biases)


def softness_of(tag: Tag, side: float) -> float:
    """Pixels: how far off the corners of a tag may be since it is blurred. ``side``: its mean side, pixels."""
    return SOFT_SIDES * side * max(SHARP_LIKENESS - tag.likeness, 0)


def bias_of(side: float, soft: float) -> float:
    """Pixels: the bias of a tag's corners. ``side``: its mean side, pixels. ``soft``: see softness_of."""
    return BIAS_PX * (SMALL_PX / side)**2 + soft


def consistent_tags(layout: Layout, seen: Mapping[int, Tag], motion: AreaMotion, limit: float) -> list[int]:
    """The ids of the tags that are, all together, not more unlikely than ``limit`` in that motion.

    ``seen``: {id: Tag}, the known tags.
    """
    def unlikeliness(some: Sequence[int]) -> float:
        points, pixels, _, _ = measurement(layout, seen, some)
        deviation = np.repeat(tolerance_of(pixels.reshape(-1, 4, 2)) / 3, 4)
        return motion.unlikeliness(points, pixels, deviation)
    ids = list(seen)
    if len(ids) > MANY_TAGS:  # leaving out each of them in turn would take too long
        alone = {tag_id: unlikeliness([tag_id]) for tag_id in ids}
        ids.sort(key=alone.__getitem__)
        while len(ids) > MANY_TAGS and unlikeliness(ids) > limit:
            del ids[-(len(ids) // MANY_TAGS):]
    while ids and unlikeliness(ids) > limit:
        ids = min(([other for other in ids if other != tag_id] for tag_id in ids),
                  key=lambda some: unlikeliness(some) if some else 0)
    return ids
