"""The lens of a calibrated camera: which ray of light each pixel sees."""
from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Floats, Numbers
from aruco_ar.tags.edges import PART

STEPS = 20        # of Newton's method, at most
CLOSE_PX = 1e-9   # rays whose pixels are as near as this are exact
FAR_PX = 1e-3     # and those that end farther off are no rays: the lens shows no such pixel
FIRST_STEPS = cv2.TERM_CRITERIA_COUNT, 10, 0.0


@dataclass(frozen=True, eq=False)
class Lens:
    """How a calibrated camera maps rays to pixels.

    ``width``, ``height``: of the frames that it is for, pixels. ``matrix``:
    (3, 3) float64, K; the middle of the top left pixel is (0, 0).
    ``distortion``: (n,) float64, OpenCV's 0, 4, 5, 8, 12 or 14 numbers (ROS
    calls them plumb_bob and rational_polynomial), or with ``fisheye`` the 4 of
    its fisheye model (which ROS calls equidistant).
    """

    width: int
    height: int
    matrix: Floats
    distortion: Floats
    fisheye: bool = False

    @property
    def bends(self) -> bool:
        """Whether straight lines may look bent through it."""
        return self.fisheye or bool(np.any(self.distortion))

    def rays(self, pixels: Numbers) -> Floats:
        """(..., 2) float64: the rays, x/z and y/z in the optical frame, that (..., 2) pixels see.

        Exact, by Newton's method on the model that ``project`` applies; NaN
        where the lens shows no ray before the camera at that pixel.
        """
        pixels = np.asarray(pixels, np.float64)
        wanted = pixels.reshape(-1, 2)
        rays = np.full(wanted.shape, np.nan)
        finite = np.isfinite(wanted).all(axis=1)
        if not self.bends:
            up = np.linalg.inv(self.matrix)
            rays[finite] = wanted[finite] @ up[:2, :2].T + up[:2, 2]
        elif finite.any():
            rays[finite] = self._inverted(wanted[finite])
        return rays.reshape(pixels.shape)

    def _inverted(self, wanted: Floats) -> Floats:
        """The same for (n, 2) finite pixels, n > 0."""
        points = wanted[:, None]
        with np.errstate(all='ignore'):
            if self.fisheye:
                first = cv2.fisheye.undistortPoints(points, self.matrix, self.distortion)
            else:
                first = cv2.undistortPointsIter(points, self.matrix, self.distortion, NO_ARRAY, NO_ARRAY,
                                                FIRST_STEPS)
            rays = np.asarray(first, np.float64)[:, 0]
            for _ in range(STEPS):
                seen, slopes = self.look(rays)
                off = wanted - seen
                if np.nanmax(np.abs(off), initial=0.0) < CLOSE_PX:
                    break
                rays = rays + _divided(off, slopes)
            seen, slopes = self.look(rays)
            # Beyond where a lens folds back, where rays turn over, models see things twice.
            good = (np.abs(wanted - seen).max(axis=1) < FAR_PX) & (np.linalg.det(slopes) > 0)
        return np.where(good[:, None], rays, np.nan)

    def look(self, rays: Floats) -> tuple[Floats, Floats]:
        """(n, 2) pixels that see (n, 2) rays, and how they move with the rays, (n, 2, 2)."""
        if not self.bends:
            slope = self.matrix[:2, :2]
            return rays @ slope.T + self.matrix[:2, 2], np.broadcast_to(slope, (len(rays), 2, 2))
        points, none = np.concatenate([rays, np.ones((len(rays), 1))], axis=1)[:, None], np.zeros(3)
        # Moving the scene to the side moves a point at depth 1 as it moves its ray.
        if self.fisheye:
            pixels, slopes = cv2.fisheye.projectPoints(points, none, none, self.matrix, self.distortion)
            slopes = slopes[:, 11:13]  # after those of K, the distortion and the rotation
        else:
            pixels, slopes = cv2.projectPoints(points, none, none, self.matrix, self.distortion)
            slopes = slopes[:, 3:5]    # after those of the rotation
        return np.asarray(pixels, np.float64)[:, 0], np.asarray(slopes, np.float64).reshape(-1, 2, 2)

    def project(self, points: Numbers) -> Floats:
        """(n, 2) float64: the pixels that see (n, 3) points, meters in the optical frame; NaN behind it."""
        points = np.asarray(points, np.float64).reshape(-1, 3)
        pixels = np.full((len(points), 2), np.nan)
        before = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
        if before.any():
            pixels[before] = self.look(points[before, :2] / points[before, 2:])[0]
        return pixels

    def corner_rays(self, quads: Numbers) -> Floats:
        """(n, 4, 2) float64: the rays to the corners of tags found at quads, (n, 4, 2) pixels.

        A detected corner is where the straight lines through two edges cross
        (see fit_tags). Edges that the lens bends bulge beyond their ends, by up
        to some tenths of a pixel: this is taken off.
        """
        quads = np.asarray(quads, np.float64)
        rays = self.rays(quads)
        if not (self.bends and len(quads)):
            return rays
        seen = np.nan_to_num(rays)
        edges = seen[:, :, None] + (np.roll(seen, -1, axis=1) - seen)[:, :, None] * PART[:, None]
        pixels = self.look(edges.reshape(-1, 2))[0].reshape(edges.shape)
        middle = pixels.mean(axis=2)
        arm = PART - PART.mean()
        along = np.einsum('s,ntsk->ntk', arm / (arm @ arm), pixels)
        crossing = _crossings(middle - along * PART.mean(), along)
        return self.rays(2 * quads - crossing)


def _divided(off: Floats, slopes: Floats) -> Floats:
    """(n, 2): the steps by which (n, 2, 2) slopes give off, (n, 2); NaN where they are flat."""
    a, b, c, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0], slopes[:, 1, 1]
    x, y = off.T
    return np.stack([d * x - b * y, a * y - c * x], axis=1) / (a * d - b * c)[:, None]


def _crossings(first: Floats, along: Floats) -> Floats:
    """(n, 4, 2): where each of four lines, first + k along, crosses the one before it."""
    toward, before = np.roll(along, 1, axis=1), np.roll(first, 1, axis=1)
    gap = first - before
    crossed = toward[..., 0] * along[..., 1] - toward[..., 1] * along[..., 0]
    far = (gap[..., 0] * along[..., 1] - gap[..., 1] * along[..., 0]) / np.where(crossed == 0, 1e-9, crossed)
    return before + far[..., None] * toward
