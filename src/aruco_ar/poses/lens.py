"""The lens of a calibrated camera: the ray of light that each pixel sees."""
from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Floats, Numbers
from aruco_ar.geometry.lines import crossing
from aruco_ar.tags.edges import PROFILE_POSITIONS

MAX_STEPS = 20      # of Newton's method
EXACT_PX = 1e-9     # a ray is exact if its pixel is off by less than this
MAX_ERROR_PX = 1e-3  # if it is off by more than this in the end, no ray belongs to that pixel
FIRST_STEPS = cv2.TERM_CRITERIA_COUNT, 10, 0.0  # of OpenCV's own method, for a first approximation


@dataclass(frozen=True, eq=False)
class Lens:
    """How a calibrated camera maps rays to pixels.

    ``width``, ``height``: the size of its frames, pixels. ``matrix``: (3, 3)
    float64, the camera matrix K; the middle of the top left pixel is (0, 0).
    ``distortion``: (n,) float64, the 0, 4, 5, 8, 12 or 14 coefficients of
    OpenCV's model (ROS calls it plumb_bob or rational_polynomial). With
    ``fisheye``, the 4 of its fisheye model (ROS calls it equidistant).
    """

    width: int
    height: int
    matrix: Floats
    distortion: Floats
    fisheye: bool = False

    @property
    def bends(self) -> bool:
        """Whether it distorts: straight lines may look bent."""
        return self.fisheye or bool(np.any(self.distortion))

    def rays(self, pixels: Numbers) -> Floats:
        """(..., 2) float64: the rays that pixels, (..., 2), see, as x/z and y/z in the optical frame.

        They are exact, by Newton's method on the model of ``project``. A ray is
        NaN if no ray in front of the camera belongs to its pixel.
        """
        pixels = np.asarray(pixels, np.float64)
        wanted = pixels.reshape(-1, 2)
        rays = np.full(wanted.shape, np.nan)
        finite = np.isfinite(wanted).all(axis=1)
        if not self.bends:
            inverse = np.linalg.inv(self.matrix)
            rays[finite] = wanted[finite] @ inverse[:2, :2].T + inverse[:2, 2]
        elif finite.any():
            rays[finite] = self._rays_of_finite(wanted[finite])
        return rays.reshape(pixels.shape)

    def _rays_of_finite(self, wanted: Floats) -> Floats:
        """(n, 2): the rays that finite pixels, (n, 2), see through a lens that distorts; n > 0."""
        points = wanted[:, None]
        with np.errstate(all='ignore'):
            if self.fisheye:
                first = cv2.fisheye.undistortPoints(points, self.matrix, self.distortion)
            else:
                first = cv2.undistortPointsIter(points, self.matrix, self.distortion, NO_ARRAY, NO_ARRAY,
                                                FIRST_STEPS)
            rays = np.asarray(first, np.float64)[:, 0]
            for _ in range(MAX_STEPS):
                seen, slopes = self.project_rays(rays)
                off = wanted - seen
                if np.nanmax(np.abs(off), initial=0.0) < EXACT_PX:
                    break
                rays = rays + _divided(off, slopes)
            seen, slopes = self.project_rays(rays)
            # Far outside, a model may fold back and map further rays to the same pixels, mirrored.
            good = (np.abs(wanted - seen).max(axis=1) < MAX_ERROR_PX) & (np.linalg.det(slopes) > 0)
        return np.where(good[:, None], rays, np.nan)

    def project_rays(self, rays: Floats) -> tuple[Floats, Floats]:
        """The pixels that see rays, (n, 2) each, and the derivatives of the pixels by the rays, (n, 2, 2)."""
        if not self.bends:
            slope = self.matrix[:2, :2]
            return rays @ slope.T + self.matrix[:2, 2], np.broadcast_to(slope, (len(rays), 2, 2))
        points, none = np.concatenate([rays, np.ones((len(rays), 1))], axis=1)[:, None], np.zeros(3)
        # At depth 1, the derivatives by a ray are those by a sideways translation of the scene.
        if self.fisheye:
            pixels, slopes = cv2.fisheye.projectPoints(points, none, none, self.matrix, self.distortion)
            slopes = slopes[:, 11:13]  # after the columns for K, the distortion and the rotation
        else:
            pixels, slopes = cv2.projectPoints(points, none, none, self.matrix, self.distortion)
            slopes = slopes[:, 3:5]    # after the columns for the rotation
        return np.asarray(pixels, np.float64)[:, 0], np.asarray(slopes, np.float64).reshape(-1, 2, 2)

    def project(self, points: Numbers) -> Floats:
        """(n, 2) float64: the pixels that see points, (n, 3) meters in the optical frame; NaN if behind it."""
        points = np.asarray(points, np.float64).reshape(-1, 3)
        pixels = np.full((len(points), 2), np.nan)
        before = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
        if before.any():
            pixels[before] = self.project_rays(points[before, :2] / points[before, 2:])[0]
        return pixels

    def corner_rays(self, quads: Numbers) -> Floats:
        """(n, 4, 2) float64: the rays to the corners of tags that were found at quads, (n, 4, 2) pixels.

        A detected corner is the crossing of straight lines through two edges
        (see fit_tags). If the lens bends the edges, the crossing is off by up to
        some tenths of a pixel. This function corrects that error.
        """
        quads = np.asarray(quads, np.float64)
        rays = self.rays(quads)
        if not (self.bends and len(quads)):
            return rays
        seen = np.nan_to_num(rays)
        edges = seen[:, :, None] + (np.roll(seen, -1, axis=1) - seen)[:, :, None] * PROFILE_POSITIONS[:, None]
        pixels = self.project_rays(edges.reshape(-1, 2))[0].reshape(edges.shape)
        middle = pixels.mean(axis=2)
        arm = PROFILE_POSITIONS - PROFILE_POSITIONS.mean()
        directions = np.einsum('s,ntsk->ntk', arm / (arm @ arm), pixels)
        starts = middle - directions * PROFILE_POSITIONS.mean()
        found = crossing(np.roll(starts, 1, axis=1), np.roll(directions, 1, axis=1), starts, directions)
        return self.rays(2 * quads - found)


def _divided(off: Floats, slopes: Floats) -> Floats:
    """(n, 2): the solutions x of slopes @ x = off, for (n, 2, 2) and (n, 2); not finite if singular."""
    a, b, c, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0], slopes[:, 1, 1]
    x, y = off.T
    return np.stack([d * x - b * y, a * y - c * x], axis=1) / (a * d - b * c)[:, None]

