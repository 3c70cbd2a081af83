"""Where the tags are on a flat sheet, learned from views of it."""
from __future__ import annotations

from typing import Mapping, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.geometry.homography import transform

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
MAX_VIEWS = 24
ROUNDS = 30
SMALL_STEP = 1e-6     # sides of a tag: the solution is found
FIRST_DAMPING = 1e-3

Quads = Mapping[int, Floats]  # {id: (4, 2) float64}: the corners of tags in one view, in undistorted pixels


def learn_layout(views: Sequence[Quads]) -> dict[int, Floats]:
    """{id: (4, 2) float64}: the corners of the tags on their sheet. The side of a tag is 1.

    ``views``: at least two. All tags are squares of the same size. This alone tells how the sheet is tilted in
    each view, without any knowledge of the camera but that straight lines are straight. Tags that are never
    seen together with others are left out.
    """
    poses = _first_layout(views)
    fullest = sorted(views, key=lambda view: -len(set(view) & set(poses)))[:MAX_VIEWS]
    views = [{tag_id: view[tag_id] for tag_id in view if tag_id in poses} for view in fullest]
    views = [view for view in views if view]
    return {tag_id: _corners(pose) for tag_id, pose in _refine(views, poses).items()}


def _corners(pose: Floats) -> Floats:
    """(4, 2): the corners of a tag at (x, y, angle)."""
    x, y, angle = pose
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return SQUARE @ turn + (x, y)


def _first_layout(views: Sequence[Quads]) -> dict[int, Floats]:
    """{id: (x, y, angle)}, from one tag to the next."""
    counts: dict[int, int] = {}
    for view in views:
        for tag_id in view:
            counts[tag_id] = counts.get(tag_id, 0) + len(view)
    root = max(counts, key=lambda tag_id: counts[tag_id])
    poses = {root: np.zeros(3)}
    while True:
        found: dict[int, list[Floats]] = {}
        for view in views:
            known = [tag_id for tag_id in view if tag_id in poses]
            if known and len(known) < len(view):
                to_sheet = _homography([view[tag_id] for tag_id in known],
                                       [_corners(poses[tag_id]) for tag_id in known])
                for tag_id in set(view) - set(known):
                    found.setdefault(tag_id, []).append(_pose_of(transform(to_sheet, view[tag_id])))
        if not found:
            return poses
        for tag_id, those in found.items():
            poses[tag_id] = np.median(those, axis=0)


def _homography(from_points: Sequence[Floats], to_points: Sequence[Floats]) -> Floats:
    found, _ = cv2.findHomography(np.concatenate(from_points), np.concatenate(to_points))
    return np.asarray(found, np.float64)


def _pose_of(corners: Floats) -> Floats:
    """(x, y, angle) of the square that is nearest to four corners."""
    x, y = corners.mean(axis=0)
    off = corners - (x, y)
    cross, dot = (SQUARE[:, 0] * off[:, 1] - SQUARE[:, 1] * off[:, 0]).sum(), (SQUARE * off).sum()
    return np.array([x, y, np.arctan2(cross, dot)])


def _refine(views: Sequence[Quads], poses: dict[int, Floats]) -> dict[int, Floats]:
    """The poses for which the corners fit best: Levenberg and Marquardt's method.

    The unknowns are the pose of each tag but the first, which is the origin, and a homography for each view.
    """
    ids = sorted(poses, key=lambda tag_id: bool(np.any(poses[tag_id])))
    places = {tag_id: number for number, tag_id in enumerate(ids)}
    layout = np.array([poses[tag_id] for tag_id in ids])
    maps = np.array([_homography([_corners(layout[places[tag_id]]) for tag_id in view], list(view.values()))
                     for view in views])
    scale = np.median([np.linalg.norm(corners[1] - corners[0]) for view in views for corners in view.values()])
    damping, (off, slopes) = FIRST_DAMPING, _system(views, places, layout, maps, scale)
    for _ in range(ROUNDS):
        normal, right = slopes.T @ slopes, slopes.T @ off
        step = np.linalg.solve(normal + damping * np.diag(normal.diagonal() + 1e-9), right)
        tags, rest = step[:3 * len(ids) - 3].reshape(-1, 3), step[3 * len(ids) - 3:].reshape(-1, 8)
        new_layout = layout + np.concatenate([np.zeros((1, 3)), tags])
        new_maps = maps + np.concatenate([rest, np.zeros((len(views), 1))], axis=1).reshape(-1, 3, 3)
        new_off, new_slopes = _system(views, places, new_layout, new_maps, scale)
        if not new_off @ new_off < off @ off:
            damping *= 10
            continue
        layout, maps, off, slopes, damping = new_layout, new_maps, new_off, new_slopes, damping / 5
        if np.abs(tags).max(initial=0) < SMALL_STEP:
            break
    return {tag_id: layout[places[tag_id]] for tag_id in ids}


def _system(views: Sequence[Quads], places: dict[int, int], layout: Floats, maps: Floats,
            scale: float) -> tuple[Floats, Floats]:
    """(n,) by what the corners are off, in tags' sides, and (n, unknowns), the slopes of what is computed."""
    first_map = 3 * len(places) - 3
    off, slopes = [], []
    for number, view in enumerate(views):
        to_image = maps[number] / maps[number, 2, 2]
        maps[number] = to_image
        for tag_id, seen in view.items():
            place = places[tag_id]
            on_sheet = _corners(layout[place])
            mapped = on_sheet @ to_image[:, :2].T + to_image[:, 2]
            pixels = mapped[:, :2] / mapped[:, 2:]
            off.append(((seen - pixels) / scale).ravel())
            rows = np.zeros((4, 2, first_map + 8 * len(views)))
            by_depth = 1 / mapped[:, 2:]
            point = np.column_stack([on_sheet, np.ones(4)]) * by_depth
            at = first_map + 8 * number
            rows[:, 0, at:at + 3] = rows[:, 1, at + 3:at + 6] = point
            rows[:, :, at + 6:at + 8] = -pixels[:, :, None] * point[:, None, :2]
            if place:
                by_place = (to_image[None, :2, :2] - pixels[:, :, None] * to_image[2, :2]) * by_depth[:, None]
                x, y = (on_sheet - layout[place, :2]).T
                turned = np.stack([-y, x], axis=1)
                rows[:, :, 3 * place - 3:3 * place - 1] = by_place
                rows[:, :, 3 * place - 1] = (by_place @ turned[:, :, None])[:, :, 0]
            slopes.append(rows.reshape(8, -1) / scale)
    return np.concatenate(off), np.concatenate(slopes)
