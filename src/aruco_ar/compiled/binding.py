"""The functions of libunit5.so. What they get is checked here, and nowhere else is the library called.

Each raises InputError for an array of a wrong type or shape, or one that is read-only where it is changed.
Arrays that are only read need not be contiguous. What the functions do is explained where they are used.
"""
from __future__ import annotations

import ctypes
from typing import Any, Sequence

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Numbers
from aruco_ar.base.checks import GRAY_OR_COLOR, PICTURE, Shape, check_array
from aruco_ar.base.errors import InputError

from .library import load

MAX_PICTURE_SIDE_PX = 2**22  # positions in a picture, in parts of a pixel, are 32-bit integers
MAX_SAMPLES = 100
MAX_CELLS = 1000             # of a tag, along a side
MAX_DEVIATIONS = 4096        # of the points of an object; the square is an int in C

_C = load()


class _Frame(ctypes.Structure):
    """The C structure Frame of frame.h."""

    _fields_ = [('pixels', ctypes.c_void_p), ('row', ctypes.c_int64), ('width', ctypes.c_int),
                ('height', ctypes.c_int), ('channels', ctypes.c_int)]


_ARRAY, _INT, _LONG, _FLOAT = ctypes.c_void_p, ctypes.c_int, ctypes.c_int64, ctypes.c_float
_ARGUMENTS: dict[str, list[Any]] = {
    'fit_tags': [_ARRAY, _LONG, *[_INT] * 4, _ARRAY, _INT, *[_ARRAY] * 4, _INT, _ARRAY],
    'compare_tags': [_ARRAY, _LONG, *[_INT] * 4, _ARRAY, _INT, _ARRAY, _INT, _ARRAY],
    'sample_cells': [_ARRAY, _LONG, *[_INT] * 4, _ARRAY, _INT, _INT, _ARRAY],
    'guess_tags': [_ARRAY, _LONG, *[_INT] * 4, _ARRAY, _INT, _INT, _ARRAY, _FLOAT, _ARRAY],
    'draw_mask': [_ARRAY, *[_INT] * 3, _ARRAY, _ARRAY, _LONG],
    'warp': [_ARRAY, _ARRAY, *[_INT] * 3, _ARRAY, _INT, _ARRAY, _ARRAY, _LONG],
    'refine_pairs': [_LONG, _INT, _INT, *[_ARRAY] * 9],
    'compare': [*[_ARRAY] * 6, _INT, _INT, _FLOAT, _FLOAT, _ARRAY, _ARRAY],
    'learn': [*[_ARRAY] * 5, _LONG, *[_FLOAT] * 4, *[_ARRAY] * 4],
}
_MAY_FAIL = 'refine_pairs', 'compare'  # these return 0 if there is not enough memory


def _function(name: str) -> Any:
    function = _C['unit5_' + name]
    function.argtypes = _ARGUMENTS[name]
    function.restype = _INT if name in _MAY_FAIL else None
    return function


(_fit_tags, _compare_tags, _sample_cells, _guess_tags, _draw_mask, _warp, _refine_pairs, _compare,
 _learn) = map(_function, _ARGUMENTS)

NEAREST_M = ctypes.c_double.in_dll(_C, 'unit5_nearest').value
PLANES = _INT.in_dll(_C, 'unit5_plane_count').value
# The positions of the profiles along an edge: 0 is where the edge starts, 1 where it ends.
PROFILE_POSITIONS = np.ctypeslib.as_array(
    (_FLOAT * _INT.in_dll(_C, 'unit5_profile_count').value).in_dll(_C, 'unit5_profile_positions'))


def fit_tags(frame: Image, quads: Numbers, cells: Image) -> tuple[Floats, Booleans, Floats]:
    """See fit_tags in tags/edges.py. A frame may also have a fourth channel, which is ignored."""
    return _fit(*_tags(frame, quads, cells))


def compare_tags(frame: Image, quads: Numbers, cells: Image, samples: int) -> Floats:
    """See compare_tags in tags/edges.py."""
    frame, quads, cells = _tags(frame, quads, cells)
    _check_samples(samples)
    likeness = np.empty(len(quads), np.float32)
    _compare_tags(*_parts(frame), len(quads), quads.ctypes.data, cells.shape[1], cells.ctypes.data, samples,
                  likeness.ctypes.data)
    return likeness


def check_tags(frame: Image, quads: Numbers, cells: Image,
               samples: int) -> tuple[Floats, Booleans, Floats, Floats, Image]:
    """See check_tags in tags/edges.py."""
    frame, quads, cells = _tags(frame, quads, cells)
    _check_samples(samples)
    whole, cells = np.empty(len(quads), np.float32), cells.copy()
    return (*_fit(frame, quads, cells, whole, samples), whole, cells)


def sample_cells(frame: Image, quads: Numbers, count: int, margin: int) -> Floats:
    """See sample_cells in tags/edges.py."""
    frame, quads = _frame(frame), _quads('quadrilaterals', quads)
    _check_count(count)
    if not -MAX_CELLS <= margin < count / 2:
        raise InputError('A tag %d cells wide cannot be sampled without %s cells at its rim; choose less than '
                         'half of its width, and at least -%d.' % (count, margin, MAX_CELLS))
    gray = np.empty((len(quads), (count - 2 * margin)**2), np.float32)
    _sample_cells(*_parts(frame), len(quads), quads.ctypes.data, count, margin, gray.ctypes.data)
    return gray


def guess_tags(frame: Image, quads: Numbers, count: int, known: Numbers, contrast: float) -> Image:
    """See guess_tags in tags/edges.py."""
    frame, quads = _frame(frame), _quads('quadrilaterals', quads)
    known = _quads('quadrilaterals of known tags', known)
    _check_count(count)
    guesses = np.empty(len(quads), np.uint8)
    _guess_tags(*_parts(frame), len(quads), quads.ctypes.data, count, len(known), known.ctypes.data, contrast,
                guesses.ctypes.data)
    return guesses


def draw_mask(frame: Image, corners: Numbers, positions: Image | None = None) -> Image:
    """A mask of the frame's shape, uint8: white within the corners, (4, 2) undistorted pixels, gray on the rim.

    ``frame``: (h, w) or (h, w, k) uint8, which may be empty. ``positions``: see warp in painting/paint.py.
    """
    check_array('frame', frame, np.uint8, *_sized(frame, 'k'))
    corners = _numbers(corners, np.float64)
    check_array('corners', corners, np.float64, (4, 2))
    mask = np.zeros(frame.shape, np.uint8)
    positions = _positions(positions, mask)
    _draw_mask(mask.ctypes.data, mask.shape[1], mask.shape[0], 1 if mask.ndim == 2 else mask.shape[2],
               corners.ctypes.data, *_address_and_row(positions))
    return mask


def warp(levels: Sequence[Image], to_picture: Floats, mask: Image, positions: Image | None = None) -> Image:
    """See warp in painting/paint.py. ``levels``: see levels_of. ``to_picture``: (3, 3), the other direction."""
    check_array('picture', levels[0], np.uint8, *PICTURE)
    height, width, channels = levels[0].shape
    if max(height, width) > MAX_PICTURE_SIDE_PX:
        raise InputError('The picture is %d x %d pixels large; give one of at most %d each way.'
                         % (width, height, MAX_PICTURE_SIDE_PX))
    levels = [_rows('picture', level, np.uint8, (height >> number, width >> number, channels))
              for number, level in enumerate(levels)]
    mask = _packed('mask', mask, np.uint8, *_sized(mask, 3))
    to_picture = _numbers(to_picture, np.float64)
    check_array('homography', to_picture, np.float64, (3, 3))
    warped, positions = np.zeros((*mask.shape[:2], channels), np.uint8), _positions(positions, mask)
    pyramid = (_Frame * len(levels))(*[
        _Frame(level.ctypes.data, level.strides[0], level.shape[1], level.shape[0], channels)
        for level in levels])
    _warp(warped.ctypes.data, mask.ctypes.data, mask.shape[1], mask.shape[0], 1 if mask.ndim == 2 else 3,
          pyramid, len(levels), to_picture.ctypes.data, *_address_and_row(positions))
    return warped


def refine_pairs(points: Numbers, rays: Numbers, weights: Numbers, rotations: Numbers, translations: Numbers,
                 spread: Numbers | None = None) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """See refine in geometry/plane_pose.py."""
    points, rays, weights = (_numbers(each, np.float64) for each in (points, rays, weights))
    rotations, translations = (np.array(each, np.float64, order='C') for each in (rotations, translations))
    objects, count = points.shape[:2] if points.ndim == 3 else (0, 0)
    spread = _numbers(np.zeros((count, 3, 0)) if spread is None else spread, np.float64)
    deviations = min(spread.shape[-1] if spread.ndim else 0, MAX_DEVIATIONS)
    for name, array, shape in (('points', points, (objects, count, 3)), ('rays', rays, (objects, count, 2)),
                               ('weights', weights, (objects, count, 2, 2)),
                               ('rotations', rotations, (objects, 2, 3, 3)),
                               ('translations', translations, (objects, 2, 3)),
                               ('spread of the points', spread, (count, 3, deviations))):
        check_array(name, array, np.float64, shape)
    amounts, squares = np.zeros((objects, 2, deviations)), np.empty((objects, 2, count))
    covariances = np.empty((objects, 2, 6 + deviations, 6 + deviations))
    if not _refine_pairs(objects, count, deviations, *(each.ctypes.data for each in (
            points, rays, weights, spread, rotations, translations, amounts, squares, covariances))):
        raise MemoryError
    return rotations, translations, amounts, squares, covariances


def compare(seen: Image, look: Floats, whole: Floats, contrast: Image, variance: Floats, usable: Booleans,
            darkest: float, lightest: float) -> tuple[Booleans, Floats]:
    """(h, w), where something seems to stand in front of the wall, and the planes, (PLANES, h, w) float32.

    wall.c says what the arguments and the planes are.
    """
    usable = _packed('usable pixels', usable, np.bool_, *_sized(usable))
    height, width = size = usable.shape
    seen, look = _packed('frame', seen, np.uint8, (*size, 3)), _packed('look', look, np.float32, (*size, 3))
    whole, variance = _packed('light', whole, np.float32, (3,)), _packed('variance', variance, np.float32, size)
    contrast = _packed('contrast', contrast, np.uint8, (*size, 3))
    planes, front = np.empty((PLANES, *size), np.float32), np.empty(size, bool)
    if not _compare(seen.ctypes.data, look.ctypes.data, whole.ctypes.data, contrast.ctypes.data,
                    variance.ctypes.data, usable.ctypes.data, width, height, darkest, lightest,
                    planes.ctypes.data, front.ctypes.data):
        raise MemoryError
    return front, planes


def learn(seen: Image, whole: Floats, planes: Floats, wall: Booleans, certain: Booleans, passed: float,
          settle: float, rate: float, variance_rate: float, look: Floats, variance: Floats, known: Booleans,
          seconds: Floats) -> None:
    """Learn the wall, as explained in wall.c. Changes the last four arrays, which must be contiguous."""
    wall = _packed('wall', wall, np.bool_, *_sized(wall))
    size = wall.shape
    seen, whole = _packed('frame', seen, np.uint8, (*size, 3)), _packed('light', whole, np.float32, (3,))
    planes = _packed('planes', planes, np.float32, (PLANES, *size))
    certain = _packed('certain wall', certain, np.bool_, size)
    for name, array, dtype, shape in (
            ('look', look, np.float32, (*size, 3)), ('variance', variance, np.float32, size),
            ('known wall', known, np.bool_, size), ('seconds', seconds, np.float32, size)):
        check_array(name, array, dtype, shape, writes=True)
        if not _is_packed(array):
            raise InputError('The %s is not contiguous, but it would be changed; give a copy, by .copy().'
                             % name)
    _learn(seen.ctypes.data, whole.ctypes.data, planes.ctypes.data, wall.ctypes.data, certain.ctypes.data,
           wall.size, passed, settle, rate, variance_rate, look.ctypes.data, variance.ctypes.data,
           known.ctypes.data, seconds.ctypes.data)


def _tags(frame: Any, quads: Any, cells: Any) -> tuple[Any, Any, Any]:
    """A frame, quadrilaterals in it, and the cells of their tags, checked."""
    frame, quads = _frame(frame), _quads('quadrilaterals', quads)
    count = len(quads)
    cells = _numbers(cells, np.uint8) if count else np.zeros((0, 3, 3), np.uint8)
    side = cells.shape[-1] if cells.ndim else 0
    check_array('cells of the tags', cells, np.uint8, (count, max(side, 3), max(side, 3)))
    return frame, quads, cells


def _fit(frame: Any, quads: Any, cells: Any, whole: Any = None,
         samples: int = 0) -> tuple[Floats, Booleans, Floats]:
    """Call the function in C, which changes the cells and ``whole``, unless that is None."""
    count = len(quads)
    fitted, found = np.empty((count, 4, 2), np.float32), np.empty(count, bool)
    likeness = np.empty(count, np.float32)
    _fit_tags(*_parts(frame), count, quads.ctypes.data, cells.shape[1], cells.ctypes.data, fitted.ctypes.data,
              found.ctypes.data, likeness.ctypes.data, samples, None if whole is None else whole.ctypes.data)
    return fitted, found, likeness


def _frame(frame: Any) -> Any:
    return _rows('frame', frame, np.uint8, *GRAY_OR_COLOR, ('h', 'w', 1), ('h', 'w', 4))


def _parts(frame: Any) -> tuple[int, ...]:
    """What a C structure Frame consists of, for a frame that was checked; it must be kept until it was used."""
    return (frame.ctypes.data, frame.strides[0], frame.shape[1], frame.shape[0],
            1 if frame.ndim == 2 else frame.shape[2])


def _check_samples(samples: int) -> None:
    if not 1 <= samples <= MAX_SAMPLES:
        raise InputError('A cell cannot be sampled %s times; choose from 1 to %d.' % (samples, MAX_SAMPLES))


def _check_count(cells: int) -> None:
    if not 1 <= cells <= MAX_CELLS:
        raise InputError('A tag cannot be %s cells wide; choose from 1 to %d.' % (cells, MAX_CELLS))


def _quads(name: str, quads: Any) -> Any:
    """Quadrilaterals, (n, 4, 2), checked."""
    quads = _numbers(quads, np.float32)
    check_array(name, quads, np.float32, (len(quads) if quads.ndim else 0, 4, 2))
    return quads


def _sized(array: Any, *channels: int | str) -> list[Shape]:
    """(h, w) and, if given, (h, w, channels), with the array's own size, which may be 0."""
    has_size = isinstance(array, np.ndarray) and array.ndim >= 2
    size: tuple[Any, ...] = array.shape[:2] if has_size else ('h', 'w')
    return [size, (*size, *channels)] if channels else [size]


def _numbers(values: Any, dtype: Any) -> Any:
    """Numbers as an array of that dtype, contiguous in memory; the same array if it is so already."""
    array = np.asarray(values, dtype, 'C')
    return array if array.flags.aligned else array.copy()


def _is_packed(array: Any) -> bool:
    return bool(array.flags.c_contiguous and array.flags.aligned)


def _packed(name: str, array: Any, dtype: type, *shapes: Shape) -> Any:
    """The array, checked, or a copy of it that is contiguous."""
    check_array(name, array, dtype, *shapes)
    return array if _is_packed(array) else _numbers(array, array.dtype)


def _rows(name: str, array: Any, dtype: type, *shapes: Shape) -> Any:
    """The array, checked, or a copy of it; each row is contiguous, as in a part of a frame."""
    check_array(name, array, dtype, *shapes)
    size = array.itemsize
    packed = (size,) if array.ndim == 2 else (array.shape[2] * size, size)
    is_good = array.strides[1:] == packed and array.flags.aligned
    return array if is_good else _numbers(array, array.dtype)


def _positions(positions: Image | None, mask: Image) -> Image | None:
    """The undistorted positions of a mask's pixels, checked, or a copy of them as by _rows."""
    if positions is None:
        return None
    return _rows('array of undistorted positions', positions, np.float32, (*mask.shape[:2], 2))


def _address_and_row(positions: Image | None) -> tuple[int | None, int]:
    """The address of an array, which must be kept until it was used, and the bytes from one row to the next."""
    return (None, 0) if positions is None else (positions.ctypes.data, positions.strides[0])
