"""The pose of a flat object from the rays to its points: both solutions, refined, with their covariances.

A pose is (R, t), meters: point in the camera = R @ point of the object + t.
Its error has six numbers, in the order of ROS: a shift of t, and then small
angles about the camera's axes. Such a turn multiplies R from the left.
"""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats
from aruco_ar.compiled import binding

HALF_TURN = -0.9           # the cosine beyond which a turn is nearly a half one, whose sine is inaccurate
NEAR_M = binding.NEAREST_M  # an object nearer than this cannot be seen


def rotation_matrices(angles: Floats) -> Floats:
    """(n, 3, 3): the rotations for rotation vectors, (n, 3) rad (O. Rodrigues, 1840)."""
    angle = np.sqrt((angles * angles).sum(axis=1))[:, None, None]
    cross = cross_matrices(angles)
    return np.eye(3) + np.sinc(angle / np.pi) * cross + np.sinc(angle / (2 * np.pi))**2 / 2 * (cross @ cross)


def rotation_vector(rotation: Floats) -> Floats:
    """(..., 3) rad: the inverse of rotation_matrices, for rotations (..., 3, 3)."""
    sines = (rotation[..., (2, 0, 1), (1, 2, 0)] - rotation[..., (1, 2, 0), (2, 0, 1)]) / 2
    sine, cosine = np.sqrt((sines * sines).sum(axis=-1)), (np.einsum('...ii->...', rotation) - 1) / 2
    vectors = sines / np.sinc(np.arctan2(sine, cosine) / np.pi)[..., None]
    for where in np.argwhere(cosine < HALF_TURN):
        exact = cv2.Rodrigues(rotation[tuple(where)])[0]  # inaccurate for small turns only
        vectors[tuple(where)] = np.asarray(exact, np.float64).ravel()
    return vectors


def cross_matrices(vectors: Floats) -> Floats:
    """(..., 3, 3): the matrices M of vectors v, (..., 3), for which M @ w is the cross product of v and w."""
    matrix = np.zeros(vectors.shape + (3,))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = x, y, z
    matrix[..., 1, 2], matrix[..., 2, 0], matrix[..., 0, 1] = -x, -y, -z
    return matrix


def approximate_poses(points: Floats, rays: Floats) -> tuple[Floats, Floats, Booleans]:
    """Both poses of n flat objects: rotations (n, 2, 3, 3), translations (n, 2, 3), and whether any, (n,).

    ``points``: (n, k, 3) meters, with z = 0. ``rays``: (n, k, 2), along which they are seen. The method is by
    T. Collins and A. Bartoli, Infinitesimal Plane-Based Pose Estimation, 2014. OpenCV has it, too, but returns
    wrong poses of some objects that are seen from right in front.
    """
    return binding.find_pose_pairs(points, rays)


def refine(points: Floats, rays: Floats, weights: Floats, rotations: Floats, translations: Floats,
           spread: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Refine both poses of n objects, so that points are seen as exactly as possible along rays.

    A pose that is far worse than the other one of its object may stay
    unrefined. The method is in plane_poses.c.

    ``points``: (n, k, 3) meters. ``rays``: (n, k, 2). ``weights``: (n, k, 2, 2),
    which turn a ray's error into standard deviations. ``rotations``:
    (n, 2, 3, 3). ``translations``: (n, 2, 3). ``spread``: (k, 3, q) meters, how
    the points deviate together, for each of q independent deviations. Their
    amounts have a standard deviation of 1.

    Returns rotations (n, 2, 3, 3), translations (n, 2, 3), the amounts of the
    deviations (n, 2, q), the squared errors of all points (n, 2, k), and the
    covariance of pose and amounts (n, 2, 6 + q, 6 + q).
    """
    return binding.refine_pose_pairs(points, rays, weights, rotations, translations, spread)
