"""Where the tags are on a flat sheet, learned from views of it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Integers
from aruco_ar.geometry.homography import transform

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
MAX_VIEWS = 24
ROUNDS = 30
SMALL_STEP = 1e-6     # sides of a tag: the solution is found
FIRST_DAMPING = 1e-3

Quads = Mapping[int, Floats]  # {id: (4, 2) float64}: the corners of tags in one view, in undistorted pixels

Layout = Dict[int, Floats]    # {key: (n, 2) float64}: where points are on their sheet, such as a tag's corners


def learn_layout(views: Sequence[Quads]) -> Layout:
    """Where the corners of tags are on their sheet: {id: (4, 2) float64}. The side of a tag is 1.

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
    layout = np.array([poses[tag_id] for tag_id in ids])
    sheet = {tag_id: _corners(poses[tag_id]) for tag_id in ids}
    maps = np.array([_homography([sheet[tag_id] for tag_id in view], list(view.values())) for view in views])
    maps /= maps[:, 2:, 2:]
    sights = _Sights(np.array([number for number, view in enumerate(views) for _ in view]),
                     np.array([ids.index(tag_id) for view in views for tag_id in view]),
                     np.array([corners for view in views for corners in view.values()]))
    damping, (off, slopes) = FIRST_DAMPING, sights.off_and_slopes(layout, maps)
    for _ in range(ROUNDS):
        normal, right = slopes.T @ slopes, slopes.T @ off
        step = np.linalg.solve(normal + damping * np.diag(normal.diagonal() + 1e-9), right)
        tags, rest = step[:3 * len(ids) - 3].reshape(-1, 3), step[3 * len(ids) - 3:].reshape(-1, 8)
        new_layout = layout + np.concatenate([np.zeros((1, 3)), tags])
        new_maps = maps + np.concatenate([rest, np.zeros((len(views), 1))], axis=1).reshape(-1, 3, 3)
        new_off, new_slopes = sights.off_and_slopes(new_layout, new_maps)
        if not new_off @ new_off < off @ off:
            damping *= 10
            continue
        layout, maps, off, slopes, damping = new_layout, new_maps, new_off, new_slopes, damping / 5
        if np.abs(tags).max(initial=0) < SMALL_STEP:
            break
    return {tag_id: layout[number] for number, tag_id in enumerate(ids)}


@dataclass(frozen=True)
class _Sights:
    """All n sights of tags: the numbers of ``view`` and ``tag``, (n,) each, and ``corners``, (n, 4, 2)."""

    view: Integers
    tag: Integers
    corners: Floats

    def off_and_slopes(self, layout: Floats, maps: Floats) -> tuple[Floats, Floats]:
        """By what the corners are off, (8n,) in sides of tags, and the slopes by the unknowns, (8n, unknowns).

        ``layout``: (tags, 3), as x, y, angle. ``maps``: (views, 3, 3), from the sheet to the image; the last
        entry of each is 1.
        """
        count, x, y, angle = len(self.view), *layout[self.tag].T[:, :, None]
        turned = np.stack([SQUARE[:, 0] * np.cos(angle) - SQUARE[:, 1] * np.sin(angle),
                           SQUARE[:, 0] * np.sin(angle) + SQUARE[:, 1] * np.cos(angle)], axis=-1)  # (n, 4, 2)
        on_sheet = np.stack([turned[..., 0] + x, turned[..., 1] + y, np.ones((count, 4))], axis=-1)
        to_image = maps[self.view]
        mapped = on_sheet @ to_image.swapaxes(1, 2)
        by_depth = 1 / mapped[..., 2:]
        pixels, point = mapped[..., :2] * by_depth, on_sheet * by_depth
        by_place = (to_image[:, None, :2, :2] - pixels[..., None] * to_image[:, None, None, 2, :2]) \
            * by_depth[..., None]                                                     # (n, 4, 2, 2)
        by_angle = by_place @ np.stack([-turned[..., 1], turned[..., 0]], axis=-1)[..., None]
        by_map = np.zeros((count, 4, 2, 8))
        by_map[:, :, 0, :3] = by_map[:, :, 1, 3:6] = point
        by_map[..., 6:] = -pixels[..., None] * point[:, :, None, :2]
        # A tag's three unknowns change only its own corners, and a view's eight those in that view.
        slopes = np.zeros((count, 4, 2, 3 * len(layout) + 8 * len(maps)))
        for first, by_some in ((3 * self.tag, np.concatenate([by_place, by_angle], axis=3)),
                               (3 * len(layout) + 8 * self.view, by_map)):
            columns = first[:, None] + np.arange(by_some.shape[3])
            np.put_along_axis(slopes, columns[:, None, None], by_some, axis=3)
        of_unknowns = slopes.reshape(8 * count, -1)[:, 3:]  # the first tag is the origin
        scale = np.median(np.linalg.norm(self.corners[:, 1] - self.corners[:, 0], axis=1))
        return (self.corners - pixels).ravel() / scale, of_unknowns / scale
