"""The features of a wall, by which it is found again from any side without its tags.

They are gathered from frames in which tags show the area, from several sides. What does not stay in its place
in the plane, such as a person who passes or the room behind a board, is left out.
"""
from __future__ import annotations

from math import sqrt
from typing import NamedTuple, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Floats, Image
from aruco_ar.geometry.homography import homography_from, transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.walls.remembered import DESCRIPTOR, MAX_FEATURES, NO_FEATURES, Features

TAUGHT_PX = 640          # the longer side of a frame, at most, in which the wall's features are looked for
MAX_TAUGHT = 600         # features of a frame, at most, to learn the wall from
CONTRAST = 0.01          # the least contrast of a feature: see cv2.SIFT. Dark walls have little
MAX_VIEWS = 8            # frames that are kept
APART = 0.05             # least difference of these: see _shape_of
SIZE_SHARE = 1 / 3       # by so much a difference in size by the factor e counts as much as one in shape
REACH = 1.0              # features are kept this far around the area, in its sides
NEAR = 0.15              # only so far, if they are from one side alone, which does not tell what is on the wall
SAME_PX = 2.0            # features in two frames that are nearer to each other, in the plane, are the same one


class Gray(NamedTuple):
    """A frame in which features are looked for: (h, w) gray uint8, and its size as a share of the frame's."""

    image: Image
    scale: float


class _View(NamedTuple):
    """A frame that shows the wall. ``corners``: (4, 2) pixels, the area's. ``shape``: see _shape_of."""

    gray: Gray
    corners: Floats
    shape: Floats
    lens: Lens | None


class Views:
    """Frames in which tags showed the area: as many as are needed, as different as possible."""

    def __init__(self, known: Features = NO_FEATURES) -> None:
        """``known``: what is known of the wall before."""
        self._views: tuple[_View, ...] = ()
        self._known = known

    def copy(self) -> Views:
        """The same views, which stay as they are now."""
        other = Views(self._known)
        other._views = self._views
        return other

    def take_in(self, frame: Image, corners: Floats, lens: Lens | None) -> None:
        """Keep a frame, (h, w, 3) BGR or (h, w) gray uint8, if it shows something new.

        ``corners``: (4, 2) undistorted pixels, the area's. ``lens``: the Lens of the frame, or None.
        """
        shape = _shape_of(corners)
        if all(np.linalg.norm(shape - view.shape) > APART for view in self._views):
            views = [*self._views, _View(gray_of(frame, TAUGHT_PX), corners.copy(), shape, lens)]
            self._views = tuple(views if len(views) <= MAX_VIEWS else _without_likest(views))

    def features(self) -> Features:
        """The Features of the wall. This takes some tenths of a second."""
        if not self._views:
            return self._known
        found = [_features_in(view) for view in self._views]
        places, descriptors, sizes = (np.concatenate(parts) for parts in zip(*found))
        numbers = np.repeat(np.arange(len(found)), [len(each[0]) for each in found])
        if len(found) > 1:
            count = _sightings(places, sizes, numbers)
        else:
            count = 1 + ((places > -NEAR) & (places < 1 + NEAR)).all(axis=1)
        room = MAX_FEATURES - min(len(self._known.places), MAX_FEATURES // 2)
        order = np.argsort(-count, kind='stable')[:min(room, np.count_nonzero(count > 1))]
        places = np.asarray(places[order], np.float32)
        return Features(np.concatenate([places, self._known.places])[:MAX_FEATURES],
                        np.concatenate([descriptors[order], self._known.descriptors])[:MAX_FEATURES])


def gray_of(frame: Image, longest: int) -> Gray:
    """A frame, (h, w, 3) BGR or (h, w) gray uint8, as a Gray. It does not change when the frame does.

    ``longest``: its longer side is at most so many pixels.
    """
    gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) if frame.ndim == 3 else frame.copy()
    scale = min(1.0, longest / max(gray.shape))
    size = [max(round(scale * side), 1) for side in gray.shape[::-1]]
    return Gray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA) if scale < 1 else gray, scale)


def find_features(gray: Gray, most: int) -> tuple[Floats, Image]:
    """At most so many features of a frame: (n, 2) pixels of the whole frame, and (n, DESCRIPTOR) uint8."""
    finder = cv2.SIFT.create(most, contrastThreshold=CONTRAST)
    keys, descriptors = finder.detectAndCompute(gray.image, NO_ARRAY)
    if descriptors is None:
        return np.empty((0, 2)), np.empty((0, DESCRIPTOR), np.uint8)
    pixels = (np.array([key.pt for key in keys]) + 0.5) / gray.scale - 0.5
    return pixels, np.asarray(descriptors, np.uint8)


def undistorted(pixels: Floats, lens: Lens | None) -> Floats:
    """(n, 2): undistorted pixels, which may be NaN beyond the lens."""
    return pixels if lens is None else lens.undistort(pixels)


def _features_in(view: _View) -> tuple[Floats, Image, Floats]:
    """The features in a view: places, descriptors, and how large SAME_PX are there, as a share of the area."""
    pixels, descriptors = find_features(view.gray, MAX_TAUGHT)
    pixels = undistorted(pixels, view.lens)
    places = transform(homography_from(view.corners), pixels)
    size = SAME_PX / view.gray.scale / sqrt(cv2.contourArea(np.asarray(view.corners, np.float32)))
    with np.errstate(invalid='ignore'):
        is_near = ((places > -REACH) & (places < 1 + REACH)).all(axis=1)
    return places[is_near], descriptors[is_near], np.full(np.count_nonzero(is_near), size)


def _sightings(places: Floats, sizes: Floats, views: Floats) -> Floats:
    """(n,): in how many views each feature was seen in its place, at least 1.

    ``places``: (n, 2). ``sizes``: (n,), how near a feature must be to another to be the same. ``views``: (n,).
    """
    count = np.zeros(len(places), int)
    for view in np.unique(views):
        others = places[views == view]
        off = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1)
        count += off < np.maximum(sizes, sizes[views == view].max())
    return count


def _shape_of(corners: Floats) -> Floats:
    """(9,): what tells from which side, and from how far, an area with these corners, (4, 2), is seen.

    Where it is in the frame, and how the camera is turned about its axis, does not count.
    """
    middle = corners - corners.mean(axis=0)
    size = np.linalg.norm(middle)
    across = middle[1] + middle[2] - middle[0] - middle[3]
    x, y = across / max(float(np.linalg.norm(across)), 1e-9)
    upright = middle @ np.array([[x, -y], [y, x]]) / size
    return np.append(upright, SIZE_SHARE * np.log(size))


def _without_likest(views: Sequence[_View]) -> list[_View]:
    """All but one of the two views that are most alike: the older one."""
    pairs = [(float(np.linalg.norm(views[a].shape - views[b].shape)), a)
             for b in range(len(views)) for a in range(b)]
    return [view for number, view in enumerate(views) if number != min(pairs)[1]]
