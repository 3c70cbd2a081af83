"""The corners of tags in frames that a lens distorts."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Floats, Numbers
from aruco_ar.compiled.binding import PROFILE_POSITIONS
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.lines import crossing

from .tag import Tag

# The line through these two points of an edge that is bent like a parabola is the one that fits all profiles.
POINTS_OF_EDGE = np.mean(PROFILE_POSITIONS) + np.array([[-1.0], [1.0]]) * np.std(PROFILE_POSITIONS)


def corner_rays(lens: Lens, quads: Numbers) -> Floats:
    """(n, 4, 2) float64: the rays to the corners of tags that were found at quads, (n, 4, 2) pixels.

    A detected corner is the crossing of straight lines through two edges (see fit_tags). If the lens bends the
    edges, the crossing is off by up to some tenths of a pixel. This function corrects that error.
    """
    quads = np.asarray(quads, np.float64)
    rays = lens.rays(quads)
    if not (lens.bends and len(quads)):
        return rays
    off = quads - found_corners(lens, np.nan_to_num(rays))
    return rays + lens.ray_steps(rays, off)  # exact enough for some tenths of a pixel


def undistort_corners(lens: Lens, quads: Numbers) -> Floats:
    """(n, 4, 2) float64: the undistorted corners of tags that were found at quads, (n, 4, 2) pixels.

    This is ``corner_rays``, but faster, and only for corners in the frame. It starts from the position of the
    nearest pixels, and is exact to a thousandth of a pixel.
    """
    quads = np.asarray(quads, np.float64)
    first = cv2.remap(lens.undistorted_pixels, np.asarray(quads, np.float32), NO_ARRAY, cv2.INTER_LINEAR,
                      borderMode=cv2.BORDER_REPLICATE)
    rays = lens.rays_of_undistorted(first)
    return lens.undistorted_of_rays(rays + lens.ray_steps(rays, quads - found_corners(lens, rays)))


def straight_corners(tag: Tag, lens: Lens | None) -> Floats:
    """(4, 2) float64: the corners of a Tag in undistorted pixels. ``lens``: that of the frame, or None."""
    if lens is None:
        return np.asarray(tag.corners, np.float64)
    return undistort_corners(lens, tag.corners[None])[0]


def found_corners(lens: Lens, rays: Floats) -> Floats:
    """(n, 4, 2) pixels: where the corners of tags are found that are seen along these rays, (n, 4, 2)."""
    edges = rays[:, :, None] + (rays[:, [1, 2, 3, 0]] - rays)[:, :, None] * POINTS_OF_EDGE
    pixels = lens.project_rays(edges.reshape(-1, 2))[0].reshape(edges.shape)
    starts, directions = pixels[:, :, 0], pixels[:, :, 1] - pixels[:, :, 0]
    before = [3, 0, 1, 2]
    return crossing(starts[:, before], directions[:, before], starts, directions)
