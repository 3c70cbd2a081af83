"""The wall's own texture, between and around the tags, which locates the area while tags do not.

It is learned while the tags are in sight. The *template* is a picture of the
area and a margin around it, rectified as if seen from straight ahead. Some
points in it are chosen that differ from their neighborhood. A later frame is
rectified in the same way, by the expected area. Then sparse optical flow shows
how far each point is off.

A point is used only after tags have confirmed that it stays in its place. So a
screen, a passer-by, or a shadow does not lead the tracker astray.
"""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.geometry.homography import homography_from, homography_to, transform
from aruco_ar.geometry.lens import Lens, rectify

MARGIN = 0.15            # width of the template's margin around the area, as a share of the area's size
MAX_LENGTH_PX = 320      # the template's longer side
MIN_SIDE_PX = 40         # an area with a shorter side in the frame shows too little texture
PAPER_SIDES = 1.7        # the width of the paper around a tag, in sides of the tag
MAX_POINTS = 80
QUALITY, MIN_DISTANCE_PX = 0.02, 7   # limits for the choice of points: see cv2.goodFeaturesToTrack
WINDOW_PX, LEVELS = 15, 3            # parameters of the optical flow: see cv2.calcOpticalFlowPyrLK
SMOOTH_PX = 6            # brightness is relative to its mean around, so that shadows and exposure do not matter
TARGET_CONTRAST = 16     # the template is scaled to this contrast, in gray levels
MIN_CONTRAST = 1.0       # a lower contrast, in gray levels, is noise
# The correlation of a point's patch with the template. A point needs the first to be confirmed. The second is
# enough to use it: motion may blur the frame, and most points have to fit together then.
CONFIRMING_LIKENESS, USABLE_LIKENESS = 0.75, 0.5
PATCH_PX = 11
STAYS_PX = 1.0           # a point that is farther off, in pixels of the template, is not on the wall
MIN_CONFIRMED = 2        # a point is used after tags have confirmed it this many times
OUTLIER_PX = 1.5         # a point farther off the homography of the others is left out; pixels of the template
MIN_POINTS, MIN_SHARE = 10, 0.4  # this many points, and this share of those in sight, must fit together
MIN_LEFT = 0.4           # if a smaller share of the learned points is left, a new template is learned
SHARPER = 1.3            # if the frame's contrast is this many times the template's, a new template is learned
ERROR_PX = 0.15          # the least common error of points that fit together, in pixels of the frame
INDEPENDENT_POINTS = 8   # all points count as much as this many, since the errors of neighbors are alike
CHECKS_S = 0.1, 0.2, 0.3, 0.5, 1.0, 2.0  # the times between checks after learning; the last one repeats
LEARN_AGAIN_S = 1.0      # the wait before a new template is learned
MEAN_OF = 20             # a point's place is the running mean of about this many checks


class Texture:
    """Learns the template of the wall's texture, and finds it in later frames."""

    def __init__(self, lens: Lens | None = None) -> None:
        """``lens``: the Lens of the frames, or None. With a lens, positions are undistorted pixels."""
        self._lens = lens
        self.reset()

    def reset(self) -> None:
        """Forget the template and its points."""
        self._points = np.empty((0, 2), np.float32)  # pixels of the template
        self._places = np.empty((0, 2))              # the same points in the plane of the area
        self._confirmed = np.empty(0, int)           # how often tags have confirmed each point
        self._checks, self._due = 0, -np.inf

    def is_due(self, now: float) -> bool:
        """Whether ``study`` has something to do at that time, seconds."""
        return now >= self._due

    def study(self, frame: Image, corners: Floats, tags: Floats, now: float) -> None:
        """Learn a template, or check its points, in a frame in which tags show the area.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``corners``: (4, 2)
        pixels, the area's. ``tags``: (n, 4, 2) pixels, the corners of the tags,
        which are left out. ``now``: seconds, a time at which it is due.
        """
        self._due = now + LEARN_AGAIN_S
        if not len(self._points):
            self._learn(frame, corners, tags)
        elif not self._confirm(frame, corners):
            self.reset()
            self._due = now + LEARN_AGAIN_S
        if len(self._points):
            self._due = now + CHECKS_S[min(self._checks, len(CHECKS_S) - 1)]

    def _confirm(self, frame: Image, corners: Floats) -> bool:
        """Drop the points that are not in their places. Returns False if a new template should be learned."""
        rectified, contrast = self._rectified_and_even(frame, corners)
        found, likeness, in_sight = self._matches(rectified, corners, frame.shape)
        off = self._to_plane(found) - self._places
        stays = (likeness > CONFIRMING_LIKENESS) & (np.linalg.norm(off * self._inner, axis=1) < STAYS_PX)
        self._confirmed += stays
        # The mean includes the places by the template's own frame, which are no more exact than the others.
        self._places += np.where(stays, 1 / np.minimum(self._confirmed + 1, MEAN_OF), 0)[:, None] * off
        kept = stays | ~in_sight
        self._points, self._places = self._points[kept], self._places[kept]
        self._confirmed = self._confirmed[kept]
        self._checks += 1
        enough = len(self._points) >= max(MIN_POINTS, MIN_LEFT * self._learned)
        return enough and contrast <= SHARPER * self._contrast

    def find(self, frame: Image, corners: Floats) -> tuple[Floats, Floats, Floats, Floats] | None:
        """Find the learned points in a frame, in which the area is expected at corners, (4, 2) pixels.

        Returns a measurement for AreaMotion.correct: the first four arguments,
        of n points, n being a multiple of four. It is None if too few points are
        recognized.
        """
        if (self._confirmed >= MIN_CONFIRMED).sum() < MIN_POINTS:
            return None
        rectified, _ = self._rectified_and_even(frame, corners)
        found, likeness, in_sight = self._matches(rectified, corners, frame.shape)
        usable = (likeness > USABLE_LIKENESS) & (self._confirmed >= MIN_CONFIRMED)
        if usable.sum() < max(MIN_POINTS, MIN_SHARE * in_sight.sum()):
            return None
        points, found = self._from_plane(self._places[usable]), found[usable]
        fitting, fits = cv2.findHomography(points, found, cv2.RANSAC, OUTLIER_PX)
        if fitting is None or fits.sum() < max(MIN_POINTS, MIN_SHARE * in_sight.sum()):
            return None
        points, found = points[fits.ravel() > 0], found[fits.ravel() > 0]
        off = transform(np.asarray(fitting, np.float64), points) - found
        # Pixels of the frame for each pixel of the template.
        scale = np.sqrt(cv2.contourArea(np.asarray(corners, np.float32)) / self._inner.prod())
        error = (ERROR_PX + scale * np.sqrt((off * off).mean())) * np.sqrt(len(points) / INDEPENDENT_POINTS)
        count = len(points) // 4 * 4
        pixels = transform(homography_to(corners), self._to_plane(found[:count]))
        return self._to_plane(points[:count]), pixels, np.full(count, error), np.zeros(count)

    def _learn(self, frame: Image, corners: Floats, tags: Floats) -> None:
        """Take the template from a frame, and choose points in it."""
        sides = np.linalg.norm(corners - corners[[1, 2, 3, 0]], axis=1)
        if sides.min() < MIN_SIDE_PX:
            return
        size = np.array([sides[[0, 2]].mean(), sides[[1, 3]].mean()])
        # The area's size in the template.
        self._inner = size * min(1, MAX_LENGTH_PX / (1 + 2 * MARGIN) / size.max())
        width, height = np.ceil(self._inner * (1 + 2 * MARGIN)).astype(int).tolist()
        self._size = width, height
        self._wall_region = self._draw_wall_region(tags, corners, frame.shape)
        self._template, self._contrast = self._rectified_and_even(frame, corners)
        if self._contrast < MIN_CONTRAST:
            return
        points = cv2.goodFeaturesToTrack(self._template, MAX_POINTS, QUALITY, MIN_DISTANCE_PX,
                                         mask=self._wall_region, blockSize=5)
        if points is not None:
            self._learned = len(points)
            self._points = np.asarray(points, np.float32).reshape(-1, 2)
            self._places = self._to_plane(self._points)
            self._confirmed = np.zeros(len(points), int)

    def _draw_wall_region(self, tags: Floats, corners: Floats, shape: tuple[int, ...]) -> Image:
        """(h, w) uint8: white where the template shows the wall: inside of the frame, and on no tag's paper.

        ``tags``: (n, 4, 2) pixels. ``shape``: that of the frame.
        """
        region = np.full(self._size[::-1], 255, np.uint8)
        centers = tags.mean(axis=1, keepdims=True)
        papers = transform(homography_from(corners), centers + PAPER_SIDES * (tags - centers))
        for paper in self._from_plane(papers):
            cv2.fillConvexPoly(region, np.round(paper).astype(np.int32), (0,))
        frame = np.full(shape[:2], 255, np.uint8)
        inside = cv2.erode(self._rectified(frame, corners), np.ones((WINDOW_PX, WINDOW_PX)),
                           borderType=cv2.BORDER_CONSTANT, borderValue=(0,))
        return cv2.bitwise_and(region, inside)

    def _to_plane(self, points: Floats) -> Floats:
        """(..., 2): pixels of the template as points in the plane of the area."""
        return (np.asarray(points, np.float64) + 0.5) / self._inner - MARGIN

    def _from_plane(self, points: Floats) -> Floats:
        """(..., 2): points in the plane of the area as pixels of the template."""
        return (points + MARGIN) * self._inner - 0.5

    def _rectified(self, frame: Image, corners: Floats) -> Image:
        """The wall in a frame, rectified by the area's corners like the template; black beyond the frame."""
        to_plane = np.array([[1 / self._inner[0], 0, 0.5 / self._inner[0] - MARGIN],
                             [0, 1 / self._inner[1], 0.5 / self._inner[1] - MARGIN], [0, 0, 1]])
        return rectify(frame, homography_to(corners) @ to_plane, self._size, self._lens)

    def _rectified_and_even(self, frame: Image, corners: Floats) -> tuple[Image, float]:
        """The wall in a frame, rectified, gray and evenly lit, (h, w) uint8, and its contrast, gray levels."""
        rectified = self._rectified(frame, corners)
        gray = np.asarray(rectified if rectified.ndim == 2 else cv2.cvtColor(rectified, cv2.COLOR_BGR2GRAY),
                          np.float32)
        fine = gray - cv2.GaussianBlur(gray, (0, 0), SMOOTH_PX)
        count = max(cv2.countNonZero(self._wall_region), 1)
        contrast = cv2.norm(fine, cv2.NORM_L2, self._wall_region) / np.sqrt(count)
        return cv2.convertScaleAbs(fine, alpha=TARGET_CONTRAST / max(contrast, 0.1), beta=128), contrast

    def _in_sight(self, corners: Floats, shape: tuple[int, ...]) -> Booleans:
        """(n,) bool: which points should be in the frame, with the windows around them."""
        reach = WINDOW_PX / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        around = self._points[:, None] + reach
        pixels = transform(homography_to(corners), self._to_plane(around))
        if self._lens is not None:
            pixels = self._lens.distort(pixels)
        return np.asarray(((pixels > 0) & (pixels < np.array(shape[1::-1]) - 1)).all(axis=(1, 2)))

    def _matches(self, rectified: Image, corners: Floats,
                 shape: tuple[int, ...]) -> tuple[Floats, Floats, Booleans]:
        """The points in a rectified frame, (n, 2) pixels, their likeness, (n,), and (n,) bool, if in sight."""
        moved, status, _ = cv2.calcOpticalFlowPyrLK(
            self._template, rectified, self._points, self._points.copy(), winSize=(WINDOW_PX, WINDOW_PX),
            maxLevel=LEVELS, flags=cv2.OPTFLOW_USE_INITIAL_FLOW)
        found = np.asarray(moved, np.float32)
        in_sight = self._in_sight(corners, shape)
        likeness = _correlation(_patches(self._template, self._points), _patches(rectified, found))
        return found, np.where(in_sight & (status.ravel() > 0), likeness, 0), in_sight


def _patches(image: Image, points: Floats) -> Floats:
    """(n, k) float32: the gray of the patches around points, (n, 2)."""
    arm = np.arange(PATCH_PX, dtype=np.float32) - PATCH_PX // 2
    around = np.stack(np.meshgrid(arm, arm), axis=-1).reshape(1, -1, 2)
    seen = cv2.remap(image, np.asarray(points[:, None] + around, np.float32), NO_ARRAY, cv2.INTER_LINEAR,
                     borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen, np.float32)


def _correlation(one: Floats, other: Floats) -> Floats:
    """(n,): the correlation of patches, (n, k)."""
    one, other = (each - each.mean(axis=1, keepdims=True) for each in (one, other))
    norm = (one * one).sum(axis=1) * (other * other).sum(axis=1)
    return (one * other).sum(axis=1) / np.sqrt(np.maximum(norm, 1e-6))
