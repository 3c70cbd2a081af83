"""Finding a remembered wall in a frame by its features, without tags and from any side."""
from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image
from aruco_ar.geometry.homography import UNIT_SQUARE, transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.walls.remembered import Features

from .features import Gray, find_features, gray_of, undistorted

SEARCH_S = 0.7           # from one search to the next. Each takes some hundredths of a second
# The longer side of the frame in which is searched, at most, and how many features at most. These alternate:
# a small frame takes a third of the time, and shows the wall in most views.
SIZES = (640, 400), (320, 250), (320, 250)
OLD_S = 5.0              # after this time, what was found does not help any more
NEIGHBORS = 4            # so many features of the wall are compared with each: some of them may be the same one
ELSEWHERE = 0.02         # features of the wall that are farther apart, in sides of the area, are different ones
DISTINCT = 0.8           # the best one must differ by less than this share of the next one: see _find_features
MIN_FEATURES = 14        # that fit together. On other walls, up to 10 did in some hundred frames
TOLERANCE_PX = 3.0       # by which each of them may be off
FLOW_PX, FLOW_LEVELS = 21, 3  # windows and levels of the optical flow that takes a find to a later frame


class _Find(NamedTuple):
    """Where features of the wall were found. ``places``: (n, 2), in its plane. ``pixels``: (n, 2), as seen."""

    gray: Gray
    places: Floats
    pixels: Floats


class WallSearch:
    """Searches frames for a wall, now and then."""

    def __init__(self, features: Features, in_thread: bool) -> None:
        """``in_thread``: whether a search goes on while frames pass, so that none is late.

        Then the wall is found some frames later, and how many depends on the computer.
        """
        self._features = features
        self._thread = ThreadPoolExecutor(1, 'wall') if in_thread else None
        self._search: Future[_Find | None] | None = None
        self._began = -np.inf  # when the last search began, seconds
        self._count = 0        # searches that have begun

    def find(self, frame: Image, lens: Lens | None, now: float) -> Floats | None:
        """(4, 2) undistorted pixels: the area's corners in a frame, about; None if it was not found.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``lens``: its Lens, or None. ``now``: its time, seconds.
        """
        if len(self._features.places) < MIN_FEATURES:
            return None
        if self._search is not None:
            if not self._search.done():
                return None
            search, self._search = self._search, None
            found = search.result()
            if found is not None and now - self._began < OLD_S:
                return _corners_in(found, frame, lens)
        if now < self._began + SEARCH_S:
            return None
        self._began = now
        longest, most = SIZES[self._count % len(SIZES)]
        self._count += 1
        gray = gray_of(frame, longest)
        if self._thread is not None:
            self._search = self._thread.submit(self._find_features, gray, most, lens)
            return None
        found = self._find_features(gray, most, lens)
        return None if found is None else _corners_of(found.places, undistorted(found.pixels, lens))

    def _find_features(self, gray: Gray, most: int, lens: Lens | None) -> _Find | None:
        """The features of the wall in a frame, if enough fit together.

        They are told apart as in D. Lowe, Distinctive image features from scale-invariant keypoints, 2004,
        section 7.1.
        """
        pixels, descriptors = find_features(gray, most)
        wall = self._features
        if len(pixels) < MIN_FEATURES:
            return None
        places, seen = [], []
        # OpenCV compares floats three times as fast as bytes.
        of_frame, of_wall = np.asarray(descriptors, np.float32), np.asarray(wall.descriptors, np.float32)
        for matches in cv2.BFMatcher(cv2.NORM_L2).knnMatch(of_frame, of_wall, k=NEIGHBORS):
            best, *rest = matches
            place = wall.places[best.trainIdx]
            others = [match.distance for match in rest
                      if np.abs(wall.places[match.trainIdx] - place).max() > ELSEWHERE]
            if not others or best.distance < DISTINCT * others[0]:
                places.append(place)
                seen.append(pixels[best.queryIdx])
        if len(places) < MIN_FEATURES:
            return None
        flat = undistorted(np.array(seen), lens)
        fits = _homography(np.array(places, np.float64), flat)[1]
        if np.count_nonzero(fits) < MIN_FEATURES:
            return None
        return _Find(gray, np.array(places, np.float64)[fits], np.array(seen)[fits])


def _corners_in(found: _Find, frame: Image, lens: Lens | None) -> Floats | None:
    """The same as WallSearch.find, in a frame somewhat later than the one that was searched."""
    gray = gray_of(frame, max(found.gray.image.shape))
    before = np.asarray((found.pixels + 0.5) * found.gray.scale - 0.5, np.float32)
    after, good, _ = cv2.calcOpticalFlowPyrLK(found.gray.image, gray.image, before, np.empty_like(before),
                                              winSize=(FLOW_PX, FLOW_PX), maxLevel=FLOW_LEVELS)
    is_good = good[:, 0] > 0
    pixels = (np.asarray(after, np.float64)[is_good] + 0.5) / gray.scale - 0.5
    return _corners_of(found.places[is_good], undistorted(pixels, lens))


def _corners_of(places: Floats, pixels: Floats) -> Floats | None:
    """(4, 2): the area's corners. Features at places, (n, 2), are seen at undistorted pixels, (n, 2)."""
    if len(places) < MIN_FEATURES:
        return None
    homography, fits = _homography(places, pixels)
    if homography is None or np.count_nonzero(fits) < MIN_FEATURES:
        return None
    corners = transform(homography, UNIT_SQUARE)
    return corners if is_quadrilateral(corners) else None


def _homography(places: Floats, pixels: Floats) -> tuple[Floats | None, Floats]:
    """(3, 3): the homography that most features fit, or None; and (n,), whether each fits."""
    known = np.isfinite(pixels).all(axis=1)
    fits = np.zeros(len(places), bool)
    if np.count_nonzero(known) < MIN_FEATURES:
        return None, fits
    homography, inliers = cv2.findHomography(places[known], pixels[known], cv2.USAC_MAGSAC, TOLERANCE_PX)
    if homography is None:
        return None, fits
    fits[known] = inliers[:, 0] > 0
    return np.asarray(homography, np.float64), fits
