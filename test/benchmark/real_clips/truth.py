"""The truth about a real clip: where the area is in each frame, found without the four tags in it.

The area is located by the other tags of the same plane, if most frames show some, or else by the wall's
texture. In both cases the plane is found first, from the whole clip. The area's place in the plane is an
average over all frames that show its tags.
"""
from dataclasses import dataclass
from multiprocessing import Pool
from multiprocessing.pool import ThreadPool
from typing import Optional

import cv2
import numpy as np
from aruco_ar import DICTIONARIES
from aruco_ar.base.progress import progress
from aruco_ar.tags.tag import Tag

SMALL_PX, LARGER = 700, 3   # a narrower frame is enlarged LARGER times before tags are read
REACH_PX = 3.0              # an edge is searched this far to both sides
ACROSS = np.arange(-REACH_PX, REACH_PX + 0.01, 0.25)
ROUNDS = 12                 # of fitting places in the plane and homographies to each other
MIN_TAGS = 3                # that a frame must show besides the four
MAX_OFF_PX = 2.0            # median distance of corners from their places; beyond it, a frame has no truth
MIN_SIGHTS = 3              # frames of the clip that must show a tag
MIN_CORRELATION = 0.9       # of a registered frame with the reference
ECC_PX = 640                # the width of the frames that are registered by ECC
MIN_MATCHES, MAX_RATIO = 20, 0.75  # of SIFT features


@dataclass(frozen=True)
class Camera:
    """The calibration of frames: ``matrix``, (3, 3), and ``distortion``, as in OpenCV."""

    matrix: np.ndarray
    distortion: np.ndarray

    def undistort(self, pixels):
        """(n, 2): where a camera without distortion would see these pixels, (n, 2)."""
        pixels = np.float64(pixels).reshape(-1, 1, 2)
        return cv2.undistortPoints(pixels, self.matrix, self.distortion, None, None, self.matrix)[:, 0]

    def distort(self, pixels):
        """(n, 2): the inverse of ``undistort``."""
        rays = np.c_[pixels, np.ones(len(pixels))] @ np.linalg.inv(self.matrix).T
        return cv2.projectPoints(rays, np.zeros(3), np.zeros(3), self.matrix, self.distortion)[0][:, 0]


class _NoDistortion:
    """Takes the place of a Camera where there is no calibration."""

    def undistort(self, pixels):
        return np.float64(pixels).reshape(-1, 2)

    distort = undistort


def truth_of(frames, dictionary, ids, camera: Optional[Camera] = None):
    """The true corners of the area in all frames, and whether they come from "tags" or from "texture".

    The corners are (n, 4, 2) pixels, clockwise, NaN where unknown. ``frames``: a list of (h, w, 3) BGR.
    """
    lens = camera or _NoDistortion()
    seen = _read(frames, dictionary)
    others = [len(set(tags) - set(ids)) for tags in seen]
    if np.mean(np.array(others) >= MIN_TAGS) > 0.5:
        undistorted = [{tag_id: lens.undistort(quad) for tag_id, quad in tags.items()} for tags in seen]
        return _truth_by_tags(undistorted, ids, lens), 'tags'
    return _truth_by_texture(frames, seen, ids), 'texture'


def tags_of(frames, dictionary, ids, camera: Optional[Camera] = None):
    """[{id: (4, 2)}]: the true corners, pixels, of the tags with these ids in all frames; {} where unknown.

    The tags are in one plane. Each is where most of those that are read say, itself among them, so also where
    it is covered or out of view. ``frames``, ``camera``: see truth_of.
    """
    lens = camera or _NoDistortion()
    seen = [{tag_id: lens.undistort(quad) for tag_id, quad in tags.items() if tag_id in ids}
            for tags in _read(frames, dictionary)]
    places = _plane(seen)
    views = [_view(places, tags) for tags in seen]
    return [{} if view is None else {tag_id: lens.distort(_transform(view, quad)) for tag_id, quad in
                                     places.items()} for view in views]


def _read(frames, dictionary):
    """[{id: (4, 2) pixels}]: the tags that are read in all frames."""
    with Pool() as pool:
        return list(progress(pool.imap(_TagReader(dictionary), frames, 4), 'reading tags', len(frames)))


class _TagReader:
    """Reads the tags of a frame: {id: (4, 2) pixels}, refined as in AprilTag."""

    def __init__(self, dictionary):
        self._dictionary = dictionary

    def __call__(self, frame):
        detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(DICTIONARIES[self._dictionary]),
                                           cv2.aruco.DetectorParameters())
        scale = LARGER if frame.shape[1] < SMALL_PX else 1
        gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        if scale > 1:
            gray = cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
        quads, ids, _ = detector.detectMarkers(gray)
        ids = [] if ids is None else [int(tag_id) for tag_id in ids.ravel()]
        single = [number for number, tag_id in enumerate(ids) if ids.count(tag_id) == 1]
        return {ids[number]: (refined(gray, quads[number][0]) + 0.5) / scale - 0.5 for number in single}


def refined(gray, quad):
    """(4, 2) float64: a quadrilateral, (4, 2), moved to where the gray changes most across its sides.

    This follows AprilTag 3 (refine_edges in apriltag.c). Places across each side are weighted by the square of
    the change from dark inside to light outside. A line is fitted to their means.
    """
    quad = np.float64(quad)
    for _ in range(2):
        middles, along = [], []
        for first, last in zip(quad, np.roll(quad, -1, axis=0)):
            length = np.linalg.norm(last - first)
            outward = np.array([last[1] - first[1], first[0] - last[0]]) / max(length, 1e-9)
            count = max(16, int(length / 8))
            on_line = first + (np.arange(1, count + 1) / (count + 1))[:, None] * (last - first)
            places = on_line[:, None] + ACROSS[:, None] * outward
            change = _gray_at(gray, places + outward) - _gray_at(gray, places - outward)
            weight = np.maximum(change, 0)**2
            total = weight.sum(axis=1)
            good = total > 0
            if good.sum() < 2:
                return quad
            points = on_line[good] + ((weight[good] @ ACROSS) / total[good])[:, None] * outward
            middles.append(points.mean(axis=0))
            along.append(np.linalg.svd(points - middles[-1])[2][0])
        corners = []
        for number in range(4):
            before = number - 1
            system = np.array([along[before], -along[number]]).T
            if abs(np.linalg.det(system)) < 0.1:
                return quad
            step = np.linalg.solve(system, middles[number] - middles[before])[0]
            corners.append(middles[before] + step * along[before])
        if np.abs(corners - quad).max() > 4 * REACH_PX:
            return quad
        quad = np.array(corners)
    return quad


def _gray_at(gray, points):
    """(n, m): the gray at pixels, (n, m, 2)."""
    seen = cv2.remap(gray, np.float32(points), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return seen.astype(np.float64)


def _fit_homography(places, pixels):
    """The homography from places to pixels, (n, 2) each, and the errors, (n,) pixels; or None, None."""
    homography, _ = cv2.findHomography(places, pixels, cv2.LMEDS if len(places) > 8 else 0)
    if homography is None:
        return None, None
    off = np.linalg.norm(_transform(homography, places) - pixels, axis=1)
    good = off < max(3 * np.median(off), 0.5)
    homography, _ = cv2.findHomography(places[good], pixels[good])
    if homography is None:
        return None, None
    return homography, np.linalg.norm(_transform(homography, places) - pixels, axis=1)


def _transform(homography, points):
    return cv2.perspectiveTransform(np.float64(points).reshape(-1, 1, 2), homography)[:, 0]


def _plane(seen):
    """{id: (4, 2)}: the places of tags in their plane, in pixels of the frame that shows most tags."""
    places = dict(max(seen, key=len))
    for _ in range(ROUNDS):
        found = {}
        for tags in seen:
            view = _view(places, tags)
            if view is None:
                continue
            back = np.linalg.inv(view)
            for tag_id, quad in tags.items():
                found.setdefault(tag_id, []).append(_transform(back, quad))
        places = {tag_id: np.median(quads, axis=0) for tag_id, quads in found.items()
                  if len(quads) >= MIN_SIGHTS}
    return places


def _truth_by_tags(seen, ids, lens):
    places = _plane(seen)
    corners = _clockwise([_center(places[tag_id]) for tag_id in ids])
    truth = np.full((len(seen), 4, 2), np.nan)
    for number, tags in enumerate(seen):
        view = _view(places, {tag_id: quad for tag_id, quad in tags.items() if tag_id not in ids})
        if view is not None:
            truth[number] = lens.distort(_transform(view, corners))
    return truth


def _view(places, tags):
    """The homography from the plane to a frame in which these tags, {id: (4, 2)}, are read, or None."""
    known = [tag_id for tag_id in tags if tag_id in places]
    if len(known) < MIN_TAGS:
        return None
    homography, off = _fit_homography(np.vstack([places[tag_id] for tag_id in known]),
                                      np.vstack([tags[tag_id] for tag_id in known]))
    return homography if homography is not None and np.median(off) < MAX_OFF_PX else None


def _center(quad):
    """The intersection of the diagonals of a quadrilateral, (4, 2)."""
    return Tag(0, quad).center


def _clockwise(points):
    """(4, 2): points, (4, 2), in clockwise order."""
    points = np.array(points, np.float64)
    across, down = (points - points.mean(axis=0)).T
    return points[np.argsort(np.arctan2(down, across))]


def _truth_by_texture(frames, seen, ids):
    complete = [number for number, tags in enumerate(seen) if set(ids) <= set(tags)]
    if not complete:
        return np.full((len(frames), 4, 2), np.nan)
    grays = [cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) for frame in frames]
    best = max(complete, key=lambda number: cv2.Laplacian(grays[number], cv2.CV_64F).var())
    reference = _Reference(grays[best], seen[best], ids)
    with ThreadPool() as pool:
        to_frames = list(progress(pool.imap(reference.register, grays), 'registering frames', len(grays)))
    registered = [(tags, np.linalg.inv(homography)) for tags, homography in zip(seen, to_frames)
                  if homography is not None]
    # The tags' centers in the reference, from all frames that show them.
    centers = {tag_id: [_transform(back, [_center(tags[tag_id])])[0]
                        for tags, back in registered if tag_id in tags] for tag_id in ids}
    corners = _clockwise([np.median(centers[tag_id], axis=0) for tag_id in ids])
    return np.array([np.full((4, 2), np.nan) if homography is None else _transform(homography, corners)
                     for homography in to_frames])


class _Reference:
    """The frame to which the others are registered, by everything but the tags."""

    def __init__(self, gray, tags, ids):
        self.mask = np.full(gray.shape, 255, np.uint8)
        for quad in tags.values():
            middle = quad.mean(axis=0)
            cv2.fillConvexPoly(self.mask, np.int32(middle + (quad - middle) * 1.5), 0)
        # Only between the four tags: what is farther away need not be in their plane.
        corners = np.float32([tags[tag_id] for tag_id in ids]).reshape(-1, 2)
        self.mask &= cv2.fillConvexPoly(np.zeros_like(self.mask), cv2.convexHull(np.int32(corners)), 255)
        self.scale = min(1.0, ECC_PX / gray.shape[1])
        self.gray = _shrunk(gray, self.scale)
        self.small_mask = _shrunk(self.mask, self.scale)
        self.sift = cv2.SIFT_create().detectAndCompute(gray, self.mask)

    def register(self, gray):
        """(3, 3): the homography from the reference's pixels to the frame's, or None."""
        keypoints, descriptors = cv2.SIFT_create().detectAndCompute(gray, None)
        if descriptors is None or self.sift[1] is None:
            return None
        pairs = [pair[0] for pair in cv2.BFMatcher().knnMatch(self.sift[1], descriptors, 2)
                 if len(pair) == 2 and pair[0].distance < MAX_RATIO * pair[1].distance]
        if len(pairs) < MIN_MATCHES:
            return None
        homography, _ = cv2.findHomography(
            np.float64([self.sift[0][pair.queryIdx].pt for pair in pairs]),
            np.float64([keypoints[pair.trainIdx].pt for pair in pairs]), cv2.RANSAC, 2.0)
        if homography is None:
            return None
        size = np.diag([self.scale, self.scale, 1.0])
        start = (size @ homography @ np.linalg.inv(size)).astype(np.float32)
        start /= start[2, 2]
        try:
            correlation, found = cv2.findTransformECC(
                self.gray, _shrunk(gray, self.scale), start, cv2.MOTION_HOMOGRAPHY,
                (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-6), self.small_mask, 5)
        except cv2.error:
            return None
        return np.linalg.inv(size) @ np.float64(found) @ size if correlation > MIN_CORRELATION else None


def _shrunk(image, scale):
    return image if scale == 1 else cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
