"""The pose of flat things by the rays to their points: both solutions, exactly, and how exactly.

A pose is (R, t): point in the camera = R @ point of the thing + t, meters.
How it may be off is told by six numbers in the order of ROS: a shift of t, then a
turn by small angles about the camera's axes, R being multiplied from the left.
"""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats

STEPS = 12                 # of Levenberg and Marquardt's method, at most
DAMPING = 1e-3             # at first
LESSER, GREATER = 0.1, 8.0  # times as much after a step that helped, and after one that did not
ENOUGH = 1e-3              # of 1 + all squared deviations: a step that promises less is not worth it
FAR_WORSE = 100.0          # times as far off as the other pose: not worth it either
HALF_TURN = -0.9           # cosine: turns by more are nearly half ones, whose sines say little
NEAR_M = 1e-3              # a thing nearer to the camera than this, or behind it, is not seen
ASIDE = 1e-6               # of a ray: nothing beside what corners are off
LEAST_KNOWN = 1e-12        # of what else is known of a number: more than rounding makes, less than all else
UNKNOWN = np.array([1e2] * 3 + [1.0] * 3)  # m and rad: more unsure than that nobody is


def turned(angles: Floats) -> Floats:
    """(n, 3, 3): the rotations by (n, 3) rad about the axes that these point along (O. Rodrigues, 1840)."""
    angle = np.sqrt((angles * angles).sum(axis=1))[:, None, None]
    cross = crossed(angles)
    return np.eye(3) + np.sinc(angle / np.pi) * cross + np.sinc(angle / (2 * np.pi))**2 / 2 * (cross @ cross)


def angles_of(rotation: Floats) -> Floats:
    """(3,) rad: the inverse of ``turned``, for one rotation (3, 3)."""
    sines = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                      rotation[1, 0] - rotation[0, 1]]) / 2
    sine, cosine = np.linalg.norm(sines), (np.trace(rotation) - 1) / 2
    if cosine < HALF_TURN:
        return np.asarray(cv2.Rodrigues(rotation)[0], np.float64).ravel()  # which takes small turns for none
    return sines / np.sinc(np.arctan2(sine, cosine) / np.pi)


def crossed(vectors: Floats) -> Floats:
    """(..., 3, 3): the matrices that take the cross product of (..., 3) vectors with what follows."""
    matrix = np.zeros(vectors.shape + (3,))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = x, y, z
    matrix[..., 1, 2], matrix[..., 2, 0], matrix[..., 0, 1] = -x, -y, -z
    return matrix


def guesses(points: Floats, rays: Floats) -> tuple[Floats, Floats] | None:
    """Both poses, (2, 3, 3) and (2, 3), of flat (k, 3) points with z = 0 seen along (k, 2) rays.

    None where there are none. T. Collins, A. Bartoli, Infinitesimal Plane-Based Pose Estimation, 2014.
    """
    # Of a tag in the middle of the view that leans about one of its own edges, OpenCV takes the root of a
    # rounding error, which may be below 0: then not of one that is a little aside.
    for aside in (0, ASIDE * (np.arange(rays.size) % 3).reshape(rays.shape)):
        try:
            _, angles, shifts, _ = cv2.solvePnPGeneric(points, rays + aside, np.eye(3), NO_ARRAY,
                                                       flags=cv2.SOLVEPNP_IPPE)
        except cv2.error:
            return None
        if not len(angles):
            return None
        rotations = np.array([cv2.Rodrigues(turn)[0] for turn in angles], np.float64)
        shifts = np.array(shifts, np.float64).reshape(-1, 3)
        good = np.isfinite(rotations).all(axis=(1, 2)) & np.isfinite(shifts).all(axis=1)
        good &= shifts[:, 2] > NEAR_M
        if good.any():
            keep = np.resize(np.flatnonzero(good), 2)
            return rotations[keep], shifts[keep]
    return None


def refine(points: Floats, rays: Floats, weights: Floats, rotation: Floats, translation: Floats,
           spread: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The poses near those given at which points are best seen along rays, m of them at once.

    They come in pairs, the two poses of one thing after each other; one that
    is far worse than the other may stay far from its best.

    ``points``: (m, k, 3) or (k, 3) meters. ``rays``: (m, k, 2) or (k, 2).
    ``weights``: (..., 2, 2), what makes of a ray's deviation one in standard
    deviations. ``spread``: (k, 3, q) meters, how the points may deviate
    together for each of q numbers whose standard deviation is 1.

    Returns rotations (m, 3, 3), translations (m, 3), those numbers (m, q), the
    squared deviations of all points (m, k), and the covariance (m, 6 + q, 6 + q).
    """
    if spread is None:
        spread = np.zeros((points.shape[-2], 3, 0))
    count = spread.shape[-1]
    own = np.zeros((len(rotation), count))
    here: tuple[Floats, ...] = _look(points, rays, weights, rotation, translation, own, spread)
    damping = np.full(len(rotation), DAMPING)
    for _ in range(STEPS):
        cost, _, slope, curve = here
        damped = curve + damping[:, None, None] * curve * np.eye(6 + count)
        step = np.linalg.solve(damped, slope[..., None])[..., 0]
        least = np.repeat(cost.reshape(-1, 2).min(axis=1), 2)
        if np.all(((step * slope).sum(axis=1) < ENOUGH * (1 + cost)) | (cost > FAR_WORSE * (1 + least))):
            break
        other = (turned(step[:, 3:6]) @ rotation, translation + step[:, :3], own + step[:, 6:])
        there = _look(points, rays, weights, *other, spread)
        better = there[0] < cost
        damping *= np.where(better, LESSER, GREATER)
        rotation, translation, own = (_chosen(better, *pair)
                                      for pair in zip(other, (rotation, translation, own)))
        here = tuple(_chosen(better, *pair) for pair in zip(there, here))
    curve = here[3].copy()
    curve[:, np.arange(6), np.arange(6)] += UNKNOWN ** -2
    return rotation, translation, own, here[1], _inverted(curve)


def _inverted(curve: Floats) -> Floats:
    """(m, n, n): the inverses of positive matrices of numbers of very different sizes, positive too.

    Of what is hardly determined, rounded numbers do not say how little: not
    even that it is more than nothing.
    """
    size = np.sqrt(np.einsum('mii->mi', curve))
    known = curve / (size[:, :, None] * size[:, None]) + LEAST_KNOWN * np.eye(curve.shape[-1])
    root = np.linalg.inv(np.linalg.cholesky(known)) / size[:, None]
    return root.swapaxes(1, 2) @ root


def _chosen(first: Booleans, one: Floats, other: Floats) -> Floats:
    return np.where(first.reshape((-1,) + (1,) * (one.ndim - 1)), one, other)


def _look(points: Floats, rays: Floats, weights: Floats, rotation: Floats, translation: Floats, own: Floats,
          spread: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Costs (m,), squared deviations (m, k), and what Gauss and Newton need: slopes (m, 6 + q) and curves."""
    if own.shape[1]:
        points = points + (spread @ own[:, None, :, None])[..., 0]
    arms = points @ rotation.transpose(0, 2, 1)              # (m, k, 3)
    places = arms + translation[:, None]
    depth = np.maximum(places[..., 2], NEAR_M)
    seen = places[..., :2] / depth[..., None]
    off = (weights @ (rays - seen)[..., None])[..., 0]  # (m, k, 2) standard deviations
    toward = np.zeros(seen.shape + (3,))
    toward[..., 0, 0] = toward[..., 1, 1] = 1 / depth
    toward[..., 2] = -seen / depth[..., None]
    toward = weights @ toward                                # how they change with a point's place
    slopes = np.zeros(seen.shape + (6 + own.shape[1],))
    slopes[..., :3] = toward
    slopes[..., 3:6] = -toward @ crossed(arms)
    if own.shape[1]:
        slopes[..., 6:] = toward @ rotation[:, None] @ spread
    slopes = slopes.reshape(len(slopes), -1, slopes.shape[-1])
    flat = off.reshape(len(off), -1)
    back = slopes.transpose(0, 2, 1)
    slope, curve = (back @ flat[..., None])[..., 0], back @ slopes
    number = np.arange(6, 6 + own.shape[1])
    curve[:, number, number] += 1
    slope[:, 6:] -= own
    squares = (off * off).sum(axis=2)
    hidden = np.where(places[..., 2] < NEAR_M, 1e9, 0.0).sum(axis=1)
    return squares.sum(axis=1) + (own * own).sum(axis=1) + hidden, squares, slope, curve
