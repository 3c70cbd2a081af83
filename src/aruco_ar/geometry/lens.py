"""The lens of a calibrated camera: the ray of light that each pixel sees.

*Undistorted* pixels are those of a camera with the same matrix K but without distortion. In them, straight
lines are straight, and a homography maps a plane to the frame.
"""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Callable

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Floats, Image, Numbers

from .homography import transform

MAX_STEPS = 20      # number of steps of Newton's method, at most
EXACT_PX = 1e-9     # a ray is exact if its pixel is off by less than this
MAX_ERROR_PX = 1e-3  # if the pixel is off by more than this after the last step, no ray belongs to it
GRID_PX = 8         # step of the grid on which the undistorted positions of pixels are exact
MAX_RAY = 20.0      # tan of the largest angle to the optical axis that is considered, 87 degrees
FIRST_STEPS = cv2.TERM_CRITERIA_COUNT, 10, 0.0  # ten steps of OpenCV's own method give a first approximation


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

    @cached_property
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
            rays[finite] = self.rays_of_undistorted(wanted[finite])
        elif finite.any():
            rays[finite] = self._rays_of_finite(wanted[finite])
        return rays.reshape(pixels.shape)

    def undistort(self, pixels: Numbers) -> Floats:
        """(..., 2) float64: pixels of a frame, (..., 2), as undistorted pixels; NaN as in ``rays``."""
        return self.undistorted_of_rays(self.rays(pixels))

    def undistorted_of_rays(self, rays: Numbers) -> Floats:
        """(..., 2) float64: the undistorted pixels that see rays, (..., 2)."""
        return np.asarray(rays, np.float64) @ self.matrix[:2, :2].T + self.matrix[:2, 2]

    def rays_of_undistorted(self, undistorted: Numbers) -> Floats:
        """(..., 2) float64: the rays that undistorted pixels, (..., 2), see."""
        return np.asarray(undistorted, np.float64) @ self._inverse[:2, :2].T + self._inverse[:2, 2]

    def distort(self, undistorted: Numbers) -> Floats:
        """(..., 2) float64: undistorted pixels, (..., 2), as pixels of a frame.

        No lens sees rays beyond a certain angle, and the model may fold back there. Such a ray is moved
        toward the optical axis to that angle. So the result is outside of the frame in the right direction.
        """
        rays = self.rays_of_undistorted(undistorted)
        lengths = np.linalg.norm(rays, axis=-1, keepdims=True)
        rays = rays * np.minimum(1, self._longest_ray / np.maximum(lengths, 1e-9))
        return self.project_rays(rays.reshape(-1, 2))[0].reshape(rays.shape)

    @cached_property
    def undistorted_pixels(self) -> Image:
        """(height, width, 2) float32: each pixel of the frame as an undistorted pixel; NaN as in ``rays``."""
        return _from_grid(self.undistort, self.width, self.height)

    @cached_property
    def _inverse(self) -> Floats:
        return np.linalg.inv(self.matrix)

    @cached_property
    def _longest_ray(self) -> float:
        """The length of the shortest ray, (x/z, y/z), beyond which the model folds back; at most MAX_RAY."""
        lengths = np.geomspace(0.01, MAX_RAY, 400)
        angles = np.arange(16) * np.pi / 8
        rays = lengths[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        with np.errstate(all='ignore'):
            pixels, slopes = self.project_rays(rays.reshape(-1, 2))
            from_middle = np.linalg.norm(pixels - self.matrix[:2, 2], axis=1).reshape(rays.shape[:2])
            folds = (np.diff(from_middle, axis=0) <= 0).any(axis=1)
            folds |= (np.linalg.det(slopes).reshape(rays.shape[:2]) <= 0).any(axis=1)[1:]
        return float(lengths[np.argmax(folds)] if folds.any() else MAX_RAY)

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
            seen, slopes = self.project_rays(rays)
            for _ in range(MAX_STEPS):
                off = wanted - seen
                if np.nanmax(np.abs(off), initial=0.0) < EXACT_PX:
                    break
                rays = rays + _divided(off, slopes)
                seen, slopes = self.project_rays(rays)
            # Far outside, a model may fold back and map further rays to the same pixels, mirrored.
            good = (np.abs(wanted - seen).max(axis=1) < MAX_ERROR_PX) & (np.linalg.det(slopes) > 0)
        return np.where(good[:, None], rays, np.nan)

    def ray_steps(self, rays: Floats, steps: Floats) -> Floats:
        """(..., 2): how rays, (..., 2), change if their pixels are moved by small steps, (..., 2)."""
        slopes = self.project_rays(rays.reshape(-1, 2))[1]
        return _divided(steps.reshape(-1, 2), slopes).reshape(rays.shape)

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
        front = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
        if front.any():
            pixels[front] = self.project_rays(points[front, :2] / points[front, 2:])[0]
        return pixels


def rectify(frame: Image, homography: Floats, size: tuple[int, int], lens: Lens | None = None) -> Image:
    """A view of a plane in a frame, of ``size``, (width, height); black where the frame ends.

    This is cv2.warpPerspective with a lens. ``homography``: (3, 3), from pixels of the view to undistorted
    pixels of the frame. ``lens``: the Lens of the frame, or None.
    """
    if lens is None:
        return cv2.warpPerspective(frame, homography, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    positions = _from_grid(lambda grid: lens.distort(transform(homography, grid)), *size)
    return cv2.remap(frame, positions, NO_ARRAY, cv2.INTER_LINEAR)


def _from_grid(positions_of: Callable[[Floats], Floats], width: int, height: int) -> Image:
    """(height, width, 2) float32: positions that a function gives for pixels, (m, n, 2).

    They are exact for every GRID_PX-th pixel. Between these they are linear, which is off by some hundredths of
    a pixel.
    """
    x, y = (np.arange(0, side + GRID_PX, GRID_PX) for side in (width, height))
    positions = positions_of(np.stack(np.meshgrid(x, y), axis=-1).astype(np.float64))
    for axis, side in (0, height), (1, width):
        before, part = np.divmod(np.arange(side), GRID_PX)
        part = np.expand_dims(part / GRID_PX, (1, 2) if axis == 0 else (0, 2))
        positions = (1 - part) * positions.take(before, axis) + part * positions.take(before + 1, axis)
    return np.asarray(positions, np.float32)


def _divided(off: Floats, slopes: Floats) -> Floats:
    """(n, 2): the solutions x of slopes @ x = off, for (n, 2, 2) and (n, 2); not finite if singular."""
    a, b, c, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0], slopes[:, 1, 1]
    x, y = off.T
    return np.stack([d * x - b * y, a * y - c * x], axis=1) / (a * d - b * c)[:, None]

