"""The lens of a camera, from views of a flat sheet."""
from __future__ import annotations

from typing import NamedTuple, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.lens import Lens
from aruco_ar.tags.corner_rays import found_corners

from .calibrated import SIDES, TRY_FISHEYE, Calibrated
from .sheet_layout import Layout, learn_layout
from .views import MIN_POINTS, View, cells_of, different_views, is_spread

MIN_VIEWS = 8
LEAST = 0.002               # between two views (see View.describe) that are both used
ROUNDS = 3, 16              # of lens and layout in turn, at least and at most
SMALL_GAIN = 0.995          # no further round if the error is not less than this share of the one before
HELD_OUT = 5                # every fifth view is held out, to see how well a lens fits a view that is new to it
OUTLIER = 3.0               # a view is left out if its error is more than OUTLIER times the usual one
BETTER = 0.998              # a lens with more coefficients must lower the error of held-out views to this share
MAX_FOCAL_DEVIATION = 0.02  # standard deviation of the focal length, as a share of it
MAX_BEND_PX = 3.0           # by which bent edges move a corner
MAX_FOCAL = 10              # of the frame's longer side; views without tilt fit any long focal length
SURE = ('Show the sheet larger and in all corners of the frame, from the left, the right, above and below, '
        'tilted by up to 45 degrees.')
NO_LENS = 'OpenCV finds no lens for these views. ' + SURE
TILTED = 0.26               # the sine of 15 degrees: the sheet is tilted by more
FISHEYE_GUESS = 0.6         # of the frame's longer side: the focal length to begin with

# What is fixed in OpenCV's models, simplest first. p1 and p2 of a pinhole are always free.
PINHOLE = cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3, cv2.CALIB_FIX_K3, 0
ALWAYS = (cv2.fisheye.CALIB_RECOMPUTE_EXTRINSIC | cv2.fisheye.CALIB_FIX_SKEW
          | cv2.fisheye.CALIB_USE_INTRINSIC_GUESS)
FISHEYE = (ALWAYS | cv2.fisheye.CALIB_FIX_K2 | cv2.fisheye.CALIB_FIX_K3 | cv2.fisheye.CALIB_FIX_K4,
           ALWAYS | cv2.fisheye.CALIB_FIX_K3 | cv2.fisheye.CALIB_FIX_K4, ALWAYS)


def calibrate(views: Sequence[View], size: tuple[int, int], fisheye: bool = False,
              board: Layout | None = None) -> Calibrated:
    """The lens of a camera. Raises InputError if the views do not tell it.

    ``views``: of the same flat sheet; at least MIN_VIEWS of them differ (see different_views). ``size``:
    (width, height) of the frames. ``fisheye``: OpenCV's fisheye model instead of a pinhole with distortion.
    ``board``: the layout in squares. Without it, the sheet has tags, and is learned from the views, too.
    """
    views = [view for view in views if is_spread(view, board)]
    different = len(different_views(views, size))
    few = '%d of the %d views of the sheet differ, but at least %d different ones are needed.' % (
        different, len(views), MIN_VIEWS)
    views = different_views(views, size, LEAST)
    if len(views) < MIN_VIEWS:
        raise InputError('%s %s' % (few, SURE))
    models = FISHEYE if fisheye else PINHOLE
    solver = _Solver(size, fisheye)
    kept, layout = _learned(solver, views, models, board)
    model, held_out = _best_model(solver, kept, layout, models)
    solved = solver.solve(kept, layout, model)
    lens, rms = solved.lens, _root_mean_square(solved.errors)
    if not np.isfinite(rms + held_out):
        raise solver.no_lens
    focal = lens.matrix[0, 0]
    fits = 'A lens fits them within %.2f px, and within %.2f px those that were held out, but other ' \
           'lenses do, too.' % (rms, held_out)
    if different < MIN_VIEWS:
        raise InputError('%s %s %s' % (few, fits, SURE))
    if solved.focal_deviation > MAX_FOCAL_DEVIATION * focal or focal > MAX_FOCAL * max(size):
        raise InputError('The views do not tell the focal length. %s %s' % (fits, SURE))
    seen = cells_of(kept, size)
    return Calibrated(lens, rms, held_out, len(kept), float(seen.mean()), _doubt(solver, kept, layout, model),
                      unseen_parts(seen), _untilted(solved.normals))


def unseen_parts(seen: Booleans) -> tuple[str, ...]:
    """The parts of a frame of which less than half was seen, such as top left. ``seen``: see cells_of."""
    across, down = (np.array_split(np.arange(count), 3) for count in seen.shape)
    return tuple(' '.join(part for part in (row, column) if part) or 'middle'
                 for row, rows in zip(('top', '', 'bottom'), down)
                 for column, columns in zip(('left', '', 'right'), across)
                 if seen[np.ix_(columns, rows)].mean() < 0.5)


def _untilted(normals: Floats) -> tuple[str, ...]:
    """Those of SIDES that are never nearer to the camera. ``normals``: (n, 3), of the sheet in each view."""
    towards = -normals * np.sign(normals[:, 2:])  # to the camera, which looks along z
    tilts = towards[:, 0], -towards[:, 0], towards[:, 1], -towards[:, 1]
    return tuple(side for side, tilt in zip(SIDES, tilts) if not np.any(tilt > TILTED))


def _learned(solver: _Solver, views: Sequence[View], models: Sequence[int],
             board: Layout | None) -> tuple[list[View], Layout]:
    """Those of the views that fit each other, straightened, and the layout. Raises InputError."""
    lens, kept, before = _without_distortion(views, solver.size), list(views), np.inf
    layout = board or {}
    for number in range(ROUNDS[1]):
        straight = kept
        if not board:
            straight = [_straightened(view, lens) for view in kept]
            layout = _layout(straight, lens)
            kept, straight = _with_sheet(kept, layout), _with_sheet(straight, layout)
            if len(kept) < MIN_VIEWS:
                raise InputError('Only %d views show the tags of one sheet, but at least %d are needed. %s'
                                 % (len(kept), MIN_VIEWS, SURE))
        solved = solver.solve(straight, layout, models[-1] if number else models[0])
        errors = solved.errors
        known = errors[np.isfinite(errors)]
        if not len(known):
            break
        lens, within = solved.lens, errors < OUTLIER * np.median(known)
        if np.count_nonzero(within) >= MIN_VIEWS:
            kept = [view for view, is_within in zip(kept, within) if is_within]
        error = np.mean(errors[within])
        if number >= ROUNDS[0] and error > SMALL_GAIN * before:
            break
        before = error
    return kept if board else [_straightened(view, lens) for view in kept], layout


def _best_model(solver: _Solver, views: Sequence[View], layout: Layout,
                models: Sequence[int]) -> tuple[int, float]:
    """The simplest model that fits views held out nearly best, and how far their points are off, pixels."""
    tested = views[::HELD_OUT]
    learned = [view for number, view in enumerate(views) if number % HELD_OUT]
    best, held_out = models[0], np.inf
    for model in models:
        error = _error_in_new(solver.solve(learned, layout, model).lens, tested, layout)
        if error < held_out * BETTER:
            best, held_out = model, error
    return best, held_out


def _error_in_new(lens: Lens, views: Sequence[View], layout: Layout) -> float:
    """How far points are off in views that the lens is not from, pixels."""
    placed = (_points(view, layout) for view in views)
    return _root_mean_square(np.array([pose_error(lens, sheet[:, :2], pixels) for sheet, pixels in placed]))


def _layout(views: Sequence[View], lens: Lens) -> Layout:
    """See learn_layout. A lens that is not known well yet may not see all tags where they are."""
    quads = [{key: lens.undistort(points) for key, points in view.points.items()} for view in views]
    seen = [{key: quad for key, quad in view.items() if np.all(np.isfinite(quad))} for view in quads]
    seen = [view for view in seen if view]
    return learn_layout(seen) if seen else {}


def _with_sheet(views: Sequence[View], layout: Layout) -> list[View]:
    """The views that show enough of the sheet, and not only other tags."""
    return [view for view in views
            if sum(len(points) for key, points in view.points.items() if key in layout) >= MIN_POINTS]


def _root_mean_square(errors: Floats) -> float:
    """Of those that are finite; inf if none is."""
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else np.inf


def _doubt(solver: _Solver, views: Sequence[View], layout: Layout, model: int) -> float:
    """By how many pixels the lens of some views may be off at the corners of the frame: see Calibrated."""
    try:
        one, other = (solver.solve(views[half::2], layout, model).lens for half in range(2))
    except InputError:
        return np.inf
    return float(corners_apart(one, other).max()) / 2


def corners_apart(lens: Lens, other: Lens) -> Floats:
    """(4,) by how many pixels two lenses differ at the corners of the frame; infinite where one sees no ray.

    A calibration may turn the whole camera a little: that changes no measurement, so it is taken away.
    """
    width, height = other.width - 1, other.height - 1
    grid = np.stack(np.meshgrid(np.linspace(0, width, 9), np.linspace(0, height, 7)), axis=-1).reshape(-1, 2)
    rays, other_rays = (np.column_stack([each.rays(grid), np.ones(len(grid))]) for each in (lens, other))
    seen = np.isfinite(rays[:, 0]) & np.isfinite(other_rays[:, 0])
    rays, other_rays = (each[seen] / np.linalg.norm(each[seen], axis=1, keepdims=True)
                        for each in (rays, other_rays))
    left, _, right = np.linalg.svd(rays.T @ other_rays)
    turned = rays @ (left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right)
    off = np.full(len(grid), np.inf)
    off[seen] = np.nan_to_num(np.linalg.norm(other.project(turned) - grid[seen], axis=1), nan=np.inf)
    return off[[0, 8, -9, -1]]


def _straightened(view: View, lens: Lens) -> View:
    """A view of tags as if the lens had not bent their edges: see found_corners."""
    if not lens.bends:
        return view
    quads = np.array(list(view.points.values()))
    with np.errstate(all='ignore'):  # where the lens sees no ray
        off = found_corners(lens, lens.rays(quads)) - quads
    return View(dict(zip(view.points, quads - np.clip(np.nan_to_num(off), -MAX_BEND_PX, MAX_BEND_PX))))


def _without_distortion(views: Sequence[View], size: tuple[int, int]) -> Lens:
    width, height = size
    matrix = np.array([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1.0]])
    return Lens(width, height, matrix, np.zeros(5))


class _Solved(NamedTuple):
    """A lens, and how it sees the views that it is from.

    ``errors``: (n,) pixels, how far the points of each view are off. ``normals``: (n, 3), of the sheet in each
    view. ``focal_deviation``: pixels, the standard deviation of the focal length; 0 for a fisheye, of which
    OpenCV does not tell it.
    """

    lens: Lens
    errors: Floats
    normals: Floats
    focal_deviation: float


class _Solver:
    """OpenCV's calibration."""

    def __init__(self, size: tuple[int, int], fisheye: bool) -> None:
        self.size, self._fisheye = size, fisheye
        # OpenCV begins with a shorter focal length, for which a corner of the frame may be behind the camera.
        focal, (x, y) = FISHEYE_GUESS * max(size), (np.array(size) - 1) / 2
        self._fisheye_guess = np.array([[focal, 0, x], [0, focal, y], [0, 0, 1]])

    @property
    def no_lens(self) -> InputError:
        return InputError(NO_LENS if self._fisheye else NO_LENS + TRY_FISHEYE)

    def solve(self, views: Sequence[View], layout: Layout, flags: int) -> _Solved:
        """The lens of views. ``flags``: what is fixed in it. Raises InputError."""
        sheets, pixels = zip(*(_points(view, layout) for view in views))
        focal_deviation = 0.0
        try:
            if self._fisheye:
                _, matrix, distortion, turns, shifts = cv2.fisheye.calibrate(
                    [sheet[:, None] for sheet in sheets], [points[:, None] for points in pixels], self.size,
                    self._fisheye_guess.copy(), np.zeros(4), flags=flags)
            else:
                _, matrix, distortion, turns, shifts, deviations, _, _ = cv2.calibrateCameraExtended(
                    [sheet.astype(np.float32) for sheet in sheets],
                    [points.astype(np.float32) for points in pixels], self.size, NO_ARRAY, NO_ARRAY,
                    flags=flags)
                focal_deviation = float(deviations[0, 0])
        except cv2.error:
            raise self.no_lens from None
        if not np.all(np.isfinite(matrix)) or not np.all(np.isfinite(distortion)):
            raise self.no_lens
        lens = Lens(*self.size, np.asarray(matrix, np.float64), np.asarray(distortion, np.float64).ravel()[:5],
                    self._fisheye)
        normals = np.array([cv2.Rodrigues(np.asarray(turn))[0][:, 2] for turn in turns])
        errors = np.array([_error(lens, *each) for each in zip(sheets, pixels, turns, shifts)])
        return _Solved(lens, errors, normals, focal_deviation)


def _points(view: View, layout: Layout) -> tuple[Floats, Floats]:
    """The points of a view: (n, 3) on the sheet and (n, 2) pixels."""
    keys = [key for key in view.points if key in layout]
    flat = np.concatenate([layout[key] for key in keys])
    return np.column_stack([flat, np.zeros(len(flat))]), np.concatenate([view.points[key] for key in keys])


def pose_error(lens: Lens, sheet: Floats, points: Floats) -> float:
    """How far points are off in the pose that fits them best, pixels; inf if there is none.

    ``sheet``: (n, 2), where they are on it. ``points``: (n, 2) pixels.
    """
    flat, rays = np.column_stack([sheet, np.zeros(len(sheet))]), lens.rays(points)
    if not np.all(np.isfinite(rays)):
        return np.inf
    found, turn, shift = cv2.solvePnP(flat, rays, np.eye(3), NO_ARRAY, flags=cv2.SOLVEPNP_IPPE)
    if not found:
        return np.inf
    turn, shift = cv2.solvePnPRefineLM(flat, rays, np.eye(3), NO_ARRAY, turn, shift)
    return _error(lens, flat, points, turn, shift)


def _error(lens: Lens, sheet: Floats, points: Floats, turn: Image, shift: Image) -> float:
    seen = sheet @ cv2.Rodrigues(np.asarray(turn))[0].T + np.ravel(shift)
    return float(np.sqrt(np.mean(np.sum((lens.project(seen) - points)**2, axis=1))))
