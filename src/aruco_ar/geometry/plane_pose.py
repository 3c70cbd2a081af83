"""The pose of a flat object from the rays to its points: both solutions, refined, with their covariances.

A pose is (R, t), meters: point in the camera = R @ point of the object + t.
Its error has six numbers, in the order of ROS: a shift of t, and then small
angles about the camera's axes. Such a turn multiplies R from the left.
"""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats

MAX_STEPS = 12             # number of steps of the Levenberg-Marquardt method, at most
FIRST_DAMPING = 1e-3
DAMPING_AFTER_SUCCESS, DAMPING_AFTER_FAILURE = 0.1, 8.0  # factors, after a step that lowered the cost or not
WORTHWHILE = 1e-3          # a step that promises less gain, relative to 1 + cost, is not made
FAR_WORSE = 100.0          # a pose with this many times the cost of the other one is not refined further
HALF_TURN = -0.9           # the cosine beyond which a turn is nearly a half one, whose sine is inaccurate
NEAR_M = 1e-3              # an object nearer to the camera than this, or behind it, cannot be seen
NUDGE = 1e-6               # a change of a ray that is negligible beside the errors of corners
MIN_EIGENVALUE = 1e-12     # added to a scaled information matrix: above rounding errors, below everything else
MAX_DEVIATION = np.array([1e2] * 3 + [1.0] * 3)  # no pose is reported as less certain than this; m and rad


def rotation_matrices(angles: Floats) -> Floats:
    """(n, 3, 3): the rotations for rotation vectors, (n, 3) rad (O. Rodrigues, 1840)."""
    angle = np.sqrt((angles * angles).sum(axis=1))[:, None, None]
    cross = cross_matrices(angles)
    return np.eye(3) + np.sinc(angle / np.pi) * cross + np.sinc(angle / (2 * np.pi))**2 / 2 * (cross @ cross)


def rotation_vector(rotation: Floats) -> Floats:
    """(3,) rad: the inverse of rotation_matrices, for one rotation (3, 3)."""
    sines = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                      rotation[1, 0] - rotation[0, 1]]) / 2
    sine, cosine = np.linalg.norm(sines), (np.trace(rotation) - 1) / 2
    if cosine < HALF_TURN:
        return np.asarray(cv2.Rodrigues(rotation)[0], np.float64).ravel()  # inaccurate for small turns only
    return sines / np.sinc(np.arctan2(sine, cosine) / np.pi)


def cross_matrices(vectors: Floats) -> Floats:
    """(..., 3, 3): the matrices M of vectors v, (..., 3), for which M @ w is the cross product of v and w."""
    matrix = np.zeros(vectors.shape + (3,))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = x, y, z
    matrix[..., 1, 2], matrix[..., 2, 0], matrix[..., 0, 1] = -x, -y, -z
    return matrix


def approximate_poses(points: Floats, rays: Floats) -> tuple[Floats, Floats] | None:
    """Both poses of a flat object, rotations (2, 3, 3) and translations (2, 3), or None if there are none.

    ``points``: (k, 3) meters, with z = 0. ``rays``: (k, 2), along which they are seen. The method is by
    T. Collins and A. Bartoli, Infinitesimal Plane-Based Pose Estimation, 2014.
    """
    # A tag in the middle of the view may be turned about one of its own edges. OpenCV then takes the root of a
    # rounding error, which may be negative. A second attempt with slightly changed rays succeeds.
    for nudge in (0, NUDGE * (np.arange(rays.size) % 3).reshape(rays.shape)):
        try:
            _, angles, shifts, _ = cv2.solvePnPGeneric(points, rays + nudge, np.eye(3), NO_ARRAY,
                                                       flags=cv2.SOLVEPNP_IPPE)
        except cv2.error:
            return None
        if not len(angles):
            return None
        rotations = np.array([cv2.Rodrigues(vector)[0] for vector in angles], np.float64)
        shifts = np.array(shifts, np.float64).reshape(-1, 3)
        good = np.isfinite(rotations).all(axis=(1, 2)) & np.isfinite(shifts).all(axis=1)
        good &= shifts[:, 2] > NEAR_M
        if good.any():
            keep = np.resize(np.flatnonzero(good), 2)
            return rotations[keep], shifts[keep]
    return None


def refine(points: Floats, rays: Floats, weights: Floats, rotation: Floats, translation: Floats,
           spread: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Refine m poses at once, so that points are seen as exactly as possible along rays.

    The poses come in pairs, which are the two poses of one object. A pose that
    is far worse than the other one of its pair may stay unrefined.

    ``points``: (m, k, 3) or (k, 3) meters. ``rays``: (m, k, 2) or (k, 2).
    ``weights``: (..., 2, 2), which turn a ray's error into standard deviations.
    ``spread``: (k, 3, q) meters, how the points deviate together, for each of
    q independent deviations. Their amounts have a standard deviation of 1.

    Returns rotations (m, 3, 3), translations (m, 3), the amounts of the
    deviations (m, q), the squared errors of all points (m, k), and the
    covariance of pose and amounts (m, 6 + q, 6 + q).
    """
    if spread is None:
        spread = np.zeros((points.shape[-2], 3, 0))
    count = spread.shape[-1]
    amounts = np.zeros((len(rotation), count))
    here: tuple[Floats, ...] = _linearize(points, rays, weights, rotation, translation, amounts, spread)
    damping = np.full(len(rotation), FIRST_DAMPING)
    for _ in range(MAX_STEPS):
        cost, _, gradient, hessian = here
        damped = hessian + damping[:, None, None] * hessian * np.eye(6 + count)
        step = np.linalg.solve(damped, gradient[..., None])[..., 0]
        least = np.repeat(cost.reshape(-1, 2).min(axis=1), 2)
        if np.all(((step * gradient).sum(axis=1) < WORTHWHILE * (1 + cost)) | (cost > FAR_WORSE * (1 + least))):
            break
        other = (rotation_matrices(step[:, 3:6]) @ rotation, translation + step[:, :3], amounts + step[:, 6:])
        there = _linearize(points, rays, weights, *other, spread)
        better = there[0] < cost
        damping *= np.where(better, DAMPING_AFTER_SUCCESS, DAMPING_AFTER_FAILURE)
        rotation, translation, amounts = (_where(better, *pair)
                                          for pair in zip(other, (rotation, translation, amounts)))
        here = tuple(_where(better, *pair) for pair in zip(there, here))
    information = here[3].copy()
    information[:, np.arange(6), np.arange(6)] += MAX_DEVIATION ** -2
    return rotation, translation, amounts, here[1], _inverted(information)


def _inverted(information: Floats) -> Floats:
    """(m, n, n): the inverses of information matrices, kept positive definite.

    Their entries differ greatly in size. What is hardly determined by them may
    be lost in rounding errors, so that an entry seems to be 0 or negative.
    """
    size = np.sqrt(np.einsum('mii->mi', information))
    scaled = information / (size[:, :, None] * size[:, None]) + MIN_EIGENVALUE * np.eye(information.shape[-1])
    root = np.linalg.inv(np.linalg.cholesky(scaled)) / size[:, None]
    return root.swapaxes(1, 2) @ root


def _where(choice: Booleans, one: Floats, other: Floats) -> Floats:
    """(m, ...): the entries of ``one`` where ``choice``, (m,), is true, of ``other`` elsewhere."""
    return np.where(choice.reshape((-1,) + (1,) * (one.ndim - 1)), one, other)


def _linearize(points: Floats, rays: Floats, weights: Floats, rotation: Floats, translation: Floats,
               amounts: Floats, spread: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """One Gauss-Newton linearization for each pose; the arguments are as in ``refine``.

    Returns the costs (m,), the squared errors of the points (m, k), the negative half gradients of the costs
    (m, 6 + q), and the approximate half Hessian matrices (m, 6 + q, 6 + q).
    """
    if amounts.shape[1]:
        points = points + (spread @ amounts[:, None, :, None])[..., 0]
    arms = points @ rotation.transpose(0, 2, 1)              # (m, k, 3)
    in_camera = arms + translation[:, None]
    depth = np.maximum(in_camera[..., 2], NEAR_M)
    seen = in_camera[..., :2] / depth[..., None]
    errors = (weights @ (rays - seen)[..., None])[..., 0]    # (m, k, 2) standard deviations
    by_point = np.zeros(seen.shape + (3,))                   # derivatives by a point's coordinates
    by_point[..., 0, 0] = by_point[..., 1, 1] = 1 / depth
    by_point[..., 2] = -seen / depth[..., None]
    by_point = weights @ by_point
    jacobian = np.zeros(seen.shape + (6 + amounts.shape[1],))
    jacobian[..., :3] = by_point
    jacobian[..., 3:6] = -by_point @ cross_matrices(arms)
    if amounts.shape[1]:
        jacobian[..., 6:] = by_point @ rotation[:, None] @ spread
    jacobian = jacobian.reshape(len(jacobian), -1, jacobian.shape[-1])
    flat = errors.reshape(len(errors), -1)
    transposed = jacobian.transpose(0, 2, 1)
    gradient, hessian = (transposed @ flat[..., None])[..., 0], transposed @ jacobian
    number = np.arange(6, 6 + amounts.shape[1])
    hessian[:, number, number] += 1
    gradient[:, 6:] -= amounts
    squares = (errors * errors).sum(axis=2)
    behind = np.where(in_camera[..., 2] < NEAR_M, 1e9, 0.0).sum(axis=1)  # a penalty if behind the camera
    return squares.sum(axis=1) + (amounts * amounts).sum(axis=1) + behind, squares, gradient, hessian
