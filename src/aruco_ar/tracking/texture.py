"""The wall's own texture: what is between and around the tags, and shows where the area is when they do not.

It is learned in wall coordinates while the tags are in sight: a picture of the
area and a little more around it, as if seen from straight ahead, its *look*,
and points in it that can be told from their neighborhood. In a later frame the
wall is brought into the same view by where the area is expected, and sparse
optical flow says how far each point is off.

Nothing is trusted that the tags have not confirmed: what shows a film, walks
through or is a shadow is not where it was when they say where to look.
"""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.geometry.homography import homography_to, transform

MARGIN = 0.15            # of the area, so much is looked at around it
LONGER_PX = 320          # the longer side of a look at most
MIN_SIDE_PX = 40         # an area smaller than this in the frame has no texture to speak of
AROUND_TAG = 1.7         # times as wide as a tag is what counts as its paper
POINTS = 80
QUALITY, APART_PX = 0.02, 7
WINDOW_PX, LEVELS = 15, 3
SMOOTH_PX = 6            # light that changes less within this is taken off: shadows, exposure
TYPICAL = 16             # gray levels to which the contrast of what is left is brought
MIN_CONTRAST = 1.0       # gray levels: less is noise
# The correlation of a point's neighborhood with what was learned: to be confirmed, and to be of use, where
# motion may have blurred all and most points have to fit together.
LIKE, ALIKE = 0.75, 0.5
PATCH_PX = 11
STAYS_PX = 1.0           # pixels of the look: farther off, a point is not on the wall
CONFIRMED = 2            # as often must tags have confirmed a point
OUTLIER_PX = 1.5         # of the look, from the homography of most points
MIN_POINTS, MIN_PART = 10, 0.4  # that must fit together, of those in sight
FEW = 0.4                # of the points that were learned: when fewer are left, learn anew
SHARPER = 1.3            # times: also then
ERROR_PX = 0.15          # of points that fit together, all alike, in the frame: how exact they are at best
EQUIVALENT = 8           # points: neighbors err alike, so that all say as much as so many
CHECKS_S = 0.1, 0.2, 0.3, 0.5, 1.0  # after learning; and then again after the last of them
AGAIN_S = 1.0            # until what has to be learned anew is
MOST_CHECKS = 20         # over as many the place of a point is averaged


class Texture:
    """Learns the wall's look, and finds it again."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Forget all."""
        self._points = np.empty((0, 2), np.float32)  # pixels of the look
        self._places = np.empty((0, 2))              # where that is in the plane of the area
        self._confirmed = np.empty(0, int)
        self._checks, self._due = 0, -np.inf

    def is_due(self, now: float) -> bool:
        """Whether there is something to study at that time, seconds; most of the time there is not."""
        return now >= self._due

    def study(self, frame: Image, corners: Floats, tags: Floats, now: float) -> None:
        """Learn, or confirm what was learned, from a frame in which tags say where the area is.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``corners``: (4, 2)
        pixels, the area's; ``tags``: (n, 4, 2) pixels, what is not wall.
        ``now``: seconds, at which it is due (see is_due).
        """
        self._due = now + AGAIN_S
        if not len(self._points):
            self._learn(frame, corners, tags)
        elif not self._confirm(frame, corners):
            self.forget()
            self._due = now + AGAIN_S
        if len(self._points):
            self._due = now + CHECKS_S[min(self._checks, len(CHECKS_S) - 1)]

    def _confirm(self, frame: Image, corners: Floats) -> bool:
        """Keep the points that are where they were learned to be; whether enough are, and all is as sharp."""
        look, contrast = self._look_at(frame, corners)
        found, like, in_sight = self._flow(look, corners, frame.shape)
        off = self._to_plane(found) - self._places
        stays = (like > LIKE) & (np.linalg.norm(off * self._inner, axis=1) < STAYS_PX)
        self._confirmed += stays
        # The first look was no more exact than tags in one frame are.
        self._places += np.where(stays, 1 / np.minimum(self._confirmed + 1, MOST_CHECKS), 0)[:, None] * off
        kept = stays | ~in_sight
        self._points, self._places = self._points[kept], self._places[kept]
        self._confirmed = self._confirmed[kept]
        self._checks += 1
        enough = len(self._points) >= max(MIN_POINTS, FEW * self._learned)
        return enough and contrast <= SHARPER * self._contrast

    def find(self, frame: Image, corners: Floats) -> tuple[Floats, Floats, Floats, Floats] | None:
        """Where the wall is in a frame in which the area is expected at corners, (4, 2) pixels.

        Returns what AreaMotion.correct takes of n points of the plane, n being a
        multiple of four; None if too little of the wall is recognized.
        """
        if (self._confirmed >= CONFIRMED).sum() < MIN_POINTS:
            return None
        look, _ = self._look_at(frame, corners)
        found, like, in_sight = self._flow(look, corners, frame.shape)
        usable = (like > ALIKE) & (self._confirmed >= CONFIRMED)
        if usable.sum() < max(MIN_POINTS, MIN_PART * in_sight.sum()):
            return None
        points, found = self._from_plane(self._places[usable]), found[usable]
        fitting, fits = cv2.findHomography(points, found, cv2.RANSAC, OUTLIER_PX)
        if fitting is None or fits.sum() < max(MIN_POINTS, MIN_PART * in_sight.sum()):
            return None
        points, found = points[fits.ravel() > 0], found[fits.ravel() > 0]
        off = transform(np.asarray(fitting, np.float64), points) - found
        # Pixels of the frame for each of the look.
        scale = np.sqrt(cv2.contourArea(np.asarray(corners, np.float32)) / self._inner.prod())
        error = (ERROR_PX + scale * np.sqrt((off * off).mean())) * np.sqrt(len(points) / EQUIVALENT)
        count = len(points) // 4 * 4
        pixels = transform(homography_to(corners), self._to_plane(found[:count]))
        return self._to_plane(points[:count]), pixels, np.full(count, error), np.zeros(count)

    def _learn(self, frame: Image, corners: Floats, tags: Floats) -> None:
        """Take the wall's look as it is now, and choose points in it."""
        sides = np.linalg.norm(corners - corners[[1, 2, 3, 0]], axis=1)
        if sides.min() < MIN_SIDE_PX:
            return
        size = np.array([sides[[0, 2]].mean(), sides[[1, 3]].mean()])
        self._inner = size * min(1, LONGER_PX / (1 + 2 * MARGIN) / size.max())  # of the look, what is area
        self._size = tuple(int(side) for side in np.ceil(self._inner * (1 + 2 * MARGIN)))
        self._wall = self._without(tags, corners, frame.shape)
        self._look, self._contrast = self._look_at(frame, corners)
        if self._contrast < MIN_CONTRAST:
            return
        points = cv2.goodFeaturesToTrack(self._look, POINTS, QUALITY, APART_PX, mask=self._wall, blockSize=5)
        if points is not None:
            self._learned = len(points)
            self._points = np.asarray(points, np.float32).reshape(-1, 2)
            self._places = self._to_plane(self._points)
            self._confirmed = np.zeros(len(points), int)

    def _without(self, tags: Floats, corners: Floats, shape: tuple[int, ...]) -> Image:
        """White where the look shows the wall: in a frame of that shape, and no paper of a tag."""
        wall = np.full(self._size[::-1], 255, np.uint8)
        centers = tags.mean(axis=1, keepdims=True)
        papers = transform(np.linalg.inv(homography_to(corners)), centers + AROUND_TAG * (tags - centers))
        for paper in self._from_plane(papers):
            cv2.fillConvexPoly(wall, np.round(paper).astype(np.int32), (0,))
        frame = np.full(shape[:2], 255, np.uint8)
        inside = cv2.erode(self._rectified(frame, corners), np.ones((WINDOW_PX, WINDOW_PX)),
                           borderType=cv2.BORDER_CONSTANT, borderValue=(0,))
        return cv2.bitwise_and(wall, inside)

    def _to_plane(self, points: Floats) -> Floats:
        """(n, 2): points of the look in the plane of the area."""
        return (np.asarray(points, np.float64) + 0.5) / self._inner - MARGIN

    def _from_plane(self, points: Floats) -> Floats:
        return (points + MARGIN) * self._inner - 0.5

    def _rectified(self, frame: Image, corners: Floats) -> Image:
        """The wall as the look has it, by where the area's corners are; black where the frame ends."""
        to_plane = np.array([[1 / self._inner[0], 0, 0.5 / self._inner[0] - MARGIN],
                             [0, 1 / self._inner[1], 0.5 / self._inner[1] - MARGIN], [0, 0, 1]])
        return cv2.warpPerspective(frame, homography_to(corners) @ to_plane, self._size,
                                   flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)

    def _look_at(self, frame: Image, corners: Floats) -> tuple[Image, float]:
        """The wall's look in a frame, (h, w) uint8, its light evened out, and its contrast before that."""
        seen = self._rectified(frame, corners)
        gray = np.asarray(seen if seen.ndim == 2 else cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), np.float32)
        fine = gray - cv2.GaussianBlur(gray, (0, 0), SMOOTH_PX)
        contrast = cv2.norm(fine, cv2.NORM_L2, self._wall) / np.sqrt(max(cv2.countNonZero(self._wall), 1))
        return cv2.convertScaleAbs(fine, alpha=TYPICAL / max(contrast, 0.1), beta=128), contrast

    def _in_sight(self, corners: Floats, shape: tuple[int, ...]) -> Booleans:
        """(n,): which points should be in the frame, with what is around them."""
        reach = WINDOW_PX / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        around = self._points[:, None] + reach
        pixels = transform(homography_to(corners), self._to_plane(around))
        return np.asarray(((pixels > 0) & (pixels < np.array(shape[1::-1]) - 1)).all(axis=(1, 2)))

    def _flow(self, look: Image, corners: Floats, shape: tuple[int, ...]) -> tuple[Floats, Floats, Booleans]:
        """Where all points are in another look, (n, 2), how like they are, and which are in sight, (n,)."""
        moved, status, _ = cv2.calcOpticalFlowPyrLK(
            self._look, look, self._points, self._points.copy(), winSize=(WINDOW_PX, WINDOW_PX),
            maxLevel=LEVELS, flags=cv2.OPTFLOW_USE_INITIAL_FLOW)
        found = np.asarray(moved, np.float32)
        in_sight = self._in_sight(corners, shape)
        like = _likeness(_patches(self._look, self._points), _patches(look, found))
        return found, np.where(in_sight & (status.ravel() > 0), like, 0), in_sight


def _patches(look: Image, points: Floats) -> Floats:
    """(n, k) float32: what is around points, (n, 2)."""
    arm = np.arange(PATCH_PX, dtype=np.float32) - PATCH_PX // 2
    around = np.stack(np.meshgrid(arm, arm), axis=-1).reshape(1, -1, 2)
    seen = cv2.remap(look, np.asarray(points[:, None] + around, np.float32), NO_ARRAY, cv2.INTER_LINEAR,
                     borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen, np.float32)


def _likeness(one: Floats, other: Floats) -> Floats:
    """(n,): the correlation of patches, (n, k)."""
    one, other = (each - each.mean(axis=1, keepdims=True) for each in (one, other))
    norm = (one * one).sum(axis=1) * (other * other).sum(axis=1)
    return (one * other).sum(axis=1) / np.sqrt(np.maximum(norm, 1e-6))
