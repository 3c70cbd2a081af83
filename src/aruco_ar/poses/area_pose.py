"""The pose of the area on its wall."""
from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.geometry.plane_pose import NEAR_M, rotation_matrices, rotation_vector
from aruco_ar.tracking.area import Area

from .belief import mixed_covariance
from .observations import WallFit

AREA_PX = 0.1       # the standard deviation of a corner of the area
# The steps for numerical derivatives.
WALL_STEP = 1e-6    # step of the wall's pose, in meters and radians
CORNER_STEP = 1e-3  # step of the corners, in units of AREA_PX


@dataclass(frozen=True, eq=False)
class AreaPose:
    """The pose and the size of the area on the wall.

    Its origin is where its diagonals cross. Its x axis points from the top left
    to the top right corner, y up, z out of the wall. ``corners``: (4, 2)
    pixels, as given. ``points``: (4, 3) meters, the corners on the wall in the
    optical frame. ``rotation``, ``translation``, ``covariance``: as in
    TagPose. ``width`` and ``height``: meters, the means of opposite sides.
    """

    corners: Floats
    points: Floats
    rotation: Floats
    translation: Floats
    covariance: Floats
    width: float
    height: float


def area_pose(fit: WallFit, area: Area, lens: Lens) -> AreaPose | None:
    """The AreaPose of an Area, seen through a Lens on the wall of a WallFit, or None if it is impossible."""
    pixels = np.asarray(area.corners, np.float64)
    rays = lens.rays(pixels)
    if not (np.isfinite(rays).all() and is_quadrilateral(pixels)):
        return None
    rotation, translation, covariance = fit.poses[0]
    slopes = np.linalg.inv(lens.project_rays(rays)[1]) * AREA_PX                  # (4, 2, 2)
    # The pose depends on the wall's six numbers and the corners' eight. Row 0 is the pose
    # itself; the others are small steps of each number, up and down.
    changes = np.zeros((29, 14))
    steps = np.array([WALL_STEP] * 6 + [CORNER_STEP] * 8)
    changes[1:15], changes[15:] = np.diag(steps), -np.diag(steps)
    moved = rays + np.einsum('kij,mkj->mki', slopes, changes[:, 6:].reshape(-1, 4, 2))
    found = _area_on(rotation_matrices(changes[:, 3:6]) @ rotation, translation + changes[:, :3], moved)
    if found is None:
        return None
    off = np.concatenate([found.center - found.center[0],
                          rotation_vector(found.axes @ found.axes[0].T)], axis=1)
    slope = ((off[1:15] - off[15:]) / (2 * steps[:, None])).T
    spread = np.eye(14)
    spread[:6, :6] = covariance
    one = found.axes[0], found.center[0], slope @ spread @ slope.T
    by_other = _area_on(fit.rotation[1:], fit.translation[1:], rays[None])
    other = one if by_other is None else (by_other.axes[0], by_other.center[0], one[2])
    return AreaPose(area.corners, found.points[0], one[0], one[1], mixed_covariance(one, other, fit.weight),
                    float(found.width[0]), float(found.height[0]))


class _OnWalls(NamedTuple):
    """An area on m walls, in the optical frame.

    ``points``: (m, 4, 3), its corners. ``axes``: (m, 3, 3), its rotations. ``center``: (m, 3). ``width``,
    ``height``: (m,). All but the axes are in meters.
    """

    points: Floats
    axes: Floats
    center: Floats
    width: Floats
    height: Floats


def _area_on(rotation: Floats, translation: Floats, rays: Floats) -> _OnWalls | None:
    """An area on m walls, or None if a ray to it does not meet a wall.

    ``rotation``: (m, 3, 3) and ``translation``: (m, 3), the poses of the walls. ``rays``: (m, 4, 2), those to
    the area's corners.
    """
    normal = rotation[..., 2]
    lines = np.concatenate([rays, np.ones(rays.shape[:2] + (1,))], axis=2)
    with np.errstate(divide='ignore', invalid='ignore'):  # a ray along the wall does not meet it
        far = np.einsum('mi,mi->m', normal, translation)[:, None] / np.einsum('mi,mki->mk', normal, lines)
    if not np.all((far > NEAR_M) & np.isfinite(far)):
        return None
    corners = far[..., None] * lines
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(sides, axis=2)
    right = sides[:, 0] / lengths[:, :1]
    diagonal, other_diagonal = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    cross = np.cross(diagonal, other_diagonal)
    fraction = np.einsum('mi,mi->m', np.cross(sides[:, 0], other_diagonal), cross) \
        / np.einsum('mi,mi->m', cross, cross)
    center = corners[:, 0] + fraction[:, None] * diagonal
    axes = np.stack([right, np.cross(normal, right), normal], axis=2)
    width, height = (lengths[:, 0] + lengths[:, 2]) / 2, (lengths[:, 1] + lengths[:, 3]) / 2
    return _OnWalls(corners, axes, center, width, height)
