"""What is seen in one frame."""
from __future__ import annotations

from dataclasses import dataclass

from aruco_ar.base.arrays import Image
from aruco_ar.geometry.lens import Lens
from aruco_ar.tags.tag import Tag

from .area import Area


@dataclass(frozen=True, eq=False)
class SeenArea:
    """What is seen of one area in a frame.

    ``area``: the Area, or None if it is not known where it is. ``tags``: the
    tags in sight that may span it. ``repeated``: more tags with the same ids,
    while it is not known where the area is. ``is_located``: whether tags or the
    wall's texture show it in this frame. ``explanation``: how it is known where
    the area is, or why it is not, in a sentence. ``shortfall``: why the tags in
    sight span no area, until they have done so once; None without tags.
    """

    area: Area | None
    tags: tuple[Tag, ...] = ()
    repeated: tuple[Tag, ...] = ()
    is_located: bool = False
    explanation: str = ''
    shortfall: str | None = None


@dataclass(frozen=True, eq=False)
class Sight:
    """What is seen in one frame. It is made once, for all who want to know something of that frame.

    ``frame``: (h, w, 3) BGR uint8, as the camera sent it. ``stamp``: its time,
    seconds. ``lens``: its Lens, or None if that is unknown. ``bending``: the
    same, if it bends straight lines and the settings ask to correct that.
    ``tags``: those in sight with the ids that count. ``areas``: what is seen of
    each area that is tracked.
    """

    frame: Image
    stamp: float
    lens: Lens | None = None
    bending: Lens | None = None
    tags: tuple[Tag, ...] = ()
    areas: tuple[SeenArea, ...] = ()
