"""The functions of the library in C. What they get is checked here, and nowhere else is the library called.

Each raises InputError for an array of a wrong type or shape, or one that is read-only where it is changed.
Arrays that are only read need not be contiguous. What the functions do is explained where they are used.
"""
from __future__ import annotations

import ctypes
from typing import Any, Callable

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image, Integers, Numbers, Pose
from aruco_ar.base.checks import GRAY_OR_COLOR, PICTURE, Shape, check_array
from aruco_ar.base.errors import InputError

from .library import load

MAX_PICTURE_SIDE_PX = 2**22  # positions in a picture, in parts of a pixel, are 32-bit integers
MAX_PICTURE_BYTES = 2**31 - 1
MAX_SAMPLES = 100
MAX_CELLS = 1000             # of a tag, along a side
MAX_SEARCHED_PX = 2**15      # width and height of an image that is searched for quadrilaterals
MAX_BORDER, MAX_WORD = 10, 8  # of a tag that is read: the width of its border and of what is within it, cells
USUAL_QUADS = 2000           # there is room for so many at first
MOTION = 8 + 8 + 16 * 16 + 8 * 8 + 2 + 1  # numbers of the C structure Motion of unit5.h
MAX_SOFTNESS_PX = 1000       # deviation of a blur
MAX_DEVIATIONS = 4096        # of the points of an object; the square is an int in C

_C = load()


class _Image(ctypes.Structure):
    """The C structure Image of image.h."""

    _fields_ = [('pixels', ctypes.c_void_p), ('row', ctypes.c_int64), ('width', ctypes.c_int),
                ('height', ctypes.c_int), ('channels', ctypes.c_int)]


def _image(image: Image) -> _Image:
    """For an Image that was checked; it must be kept until this was used."""
    height, width, channels = image.shape if image.ndim == 3 else (*image.shape, 1)
    return _Image(image.ctypes.data, image.strides[0], width, height, channels)


class _Array:
    """The type of an argument of a C function that is an array, which was checked, or None for NULL."""

    @staticmethod
    def from_param(array: Any) -> Any:
        if array is None:
            return None
        try:
            return ctypes.byref(ctypes.c_char.from_buffer(array))  # in a quarter of the time
        except (TypeError, ValueError):  # it is read-only, strided or empty
            return ctypes.c_void_p(array.ctypes.data)


def _function(name: str, *arguments: Any, result: Any = None) -> Any:
    """A function that unit5.h declares."""
    function = _C['unit5_' + name]
    function.argtypes, function.restype = arguments, result
    return function


_IMAGE, _INT, _LONG, _FLOAT = ctypes.POINTER(_Image), ctypes.c_int, ctypes.c_int64, ctypes.c_float
_DOUBLE = ctypes.c_double
_TAGS = _IMAGE, _INT, _Array, _INT
_fit_tags = _function('fit_tags', *_TAGS, *[_Array] * 4, _INT, _Array)
_compare_tags = _function('compare_tags', *_TAGS, _Array, _INT, _Array)
_sample_cells = _function('sample_cells', *_TAGS, _INT, _Array)
_guess_tags = _function('guess_tags', *_TAGS, _INT, _Array, _FLOAT, _Array)
_find_quads = _function('find_quads', _IMAGE, _INT, _FLOAT, _LONG, _Array, result=_LONG)
_read_tags = _function('read_tags', _IMAGE, _INT, _Array, _INT, _INT, _INT, _Array, _INT, _FLOAT, _Array,
                       result=_INT)
_find_sides = _function('find_sides', _LONG, _Array, _Array)
_find_room = _function('find_room', _LONG, _Array, _INT, _INT, _Array)
_find_box = _function('find_box', _Array, _LONG, _INT, _INT, _INT, _Array, _Array)
_find_convex = _function('find_convex', _LONG, _Array, _DOUBLE, _Array)
_draw_mask = _function('draw_mask', _IMAGE, _Array, _Array, _LONG)
_find_levels = _function('find_levels', _IMAGE, _INT, _INT, _Array, _Array, _LONG, _Array)
_warp_picture = _function('warp_picture', _IMAGE, _IMAGE, _INT, _INT, _IMAGE, *[_Array] * 3, _LONG)
_start_motion = _function('start_motion', _Array, _LONG, *[_Array] * 3)
_predict_motion = _function('predict_motion', _Array, _DOUBLE, _INT)
_jerk_motion = _function('jerk_motion', _Array)
_correct_motion = _function('correct_motion', _Array, _LONG, *[_Array] * 4, _DOUBLE, result=_INT)
_find_deviation = _function('find_deviation', _Array, _Array)
_unlikeliness = _function('unlikeliness', _Array, _LONG, *[_Array] * 3, result=_DOUBLE)
_project = _function('project', _Array, _LONG, *[_Array] * 2)
_learn_patches = _function('learn_patches', _Array, *[_INT] * 3, *[_Array] * 2, result=_INT)
_align_patches = _function('align_patches', _Array, *[_INT] * 3, *[_Array] * 3, *[_INT] * 2, *[_Array] * 3,
                           result=_INT)
_mix_picture = _function('mix_picture', _IMAGE, _IMAGE, _IMAGE, _INT, _Array, _Array)
_light_picture = _function('light_picture', *[_IMAGE] * 3, _INT, result=_INT)
_soften_picture = _function('soften_picture', _IMAGE, _IMAGE, _DOUBLE, _DOUBLE, _Array, _Array, result=_INT)
_find_ways = _function('find_ways', _INT, _Array, _Array)
_read_rings = _function('read_rings', _IMAGE, _INT, *[_Array] * 6)
_even_rings = _function('even_rings', _INT, *[_Array] * 5)
_draw_cover = _function('draw_cover', _IMAGE, _IMAGE, _Array, _LONG, *[_INT] * 4, _Array, _Array, _IMAGE, _INT,
                        *[_Array] * 3)
_choose_sources = _function('choose_sources', _IMAGE, _INT, _Array, _Array, _INT, _INT, _Array, _INT, _Array,
                            _DOUBLE, _Array, _Array, result=_INT)
_find_pose_pairs = _function('find_pose_pairs', _LONG, _INT, *[_Array] * 5)
_refine_pose_pairs = _function('refine_pose_pairs', _LONG, _INT, _INT, *[_Array] * 9, result=_INT)
_find_tag_poses = _function('find_tag_poses', _LONG, _Array, _DOUBLE, *[_Array] * 10, result=_INT)
_weigh_poses = _function('weigh_poses', _LONG, *[_Array] * 4, _DOUBLE, *[_Array] * 3)
_mix_poses = _function('mix_poses', _LONG, *[_Array] * 8)
_place_tags = _function('place_tags', _LONG, _INT, *[_Array] * 10, result=_INT)
_off_others = _function('off_others', _LONG, *[_Array] * 7, result=_INT)
_add_off = _function('add_off', _LONG, *[_Array] * 4)
_measure_light = _function('measure_light', *[_Array] * 4, _INT, _INT, _Array, ctypes.POINTER(_FLOAT),
                           result=_INT)
_light_wall = _function('light_wall', _Array, _Array, _LONG, _Array)
_compare_wall = _function('compare_wall', *[_Array] * 6, _INT, _INT, _FLOAT, _FLOAT, _Array, _Array,
                          result=_INT)
_learn_wall = _function('learn_wall', *[_Array] * 5, _LONG, *[_FLOAT] * 4, *[_Array] * 4)

NEAREST_M, SEAM, DARK = (_DOUBLE.in_dll(_C, 'unit5_' + name).value for name in ('nearest', 'seam', 'dark'))
BLOCK_WIDTH, BLOCK_HEIGHT, LEVELS = (
    _INT.in_dll(_C, 'unit5_' + name).value for name in ('block_width', 'block_height', 'levels'))
LIGHT_STEP_PX = _INT.in_dll(_C, 'unit5_light_step').value
MOST_SOURCES = _INT.in_dll(_C, 'unit5_most_sources').value
RING_PLACES = _INT.in_dll(_C, 'unit5_ring_places').value
WIDEST_WINDOW = _INT.in_dll(_C, 'unit5_widest_window').value
BELIEF_SIZE, FLATNESS_SIZE = (
    _INT.in_dll(_C, 'unit5_' + name).value for name in ('belief_size', 'flatness_size'))
WALL_LEVELS, PATCH_WIDTH, PATCH_SIZE = (
    _INT.in_dll(_C, 'unit5_' + name).value for name in ('wall_levels', 'patch_width', 'patch_size'))
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
    _compare_tags(_image(frame), len(quads), quads, cells.shape[1], cells, samples, likeness)
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
    _sample_cells(_image(frame), len(quads), quads, count, margin, gray)
    return gray


def guess_tags(frame: Image, quads: Numbers, count: int, known: Numbers, contrast: float) -> Image:
    """See guess_tags in tags/edges.py."""
    frame, quads = _frame(frame), _quads('quadrilaterals', quads)
    known = _quads('quadrilaterals of known tags', known)
    _check_count(count)
    guesses = np.empty(len(quads), np.uint8)
    _guess_tags(_image(frame), len(quads), quads, count, len(known), known, contrast, guesses)
    return guesses


def find_quads(image: Image, window: int, shortest: float) -> Floats:
    """See find_quads in tags/quads.py."""
    image = _rows('image', image, np.uint8, ('h', 'w'))
    if max(image.shape) > MAX_SEARCHED_PX:
        raise InputError('The image is %d x %d pixels large; give one of at most %d each way.'
                         % (*image.shape[::-1], MAX_SEARCHED_PX))
    if window not in range(3, WIDEST_WINDOW + 1, 2):
        raise InputError('A window cannot be %s pixels wide; give an odd number from 3 to %d.'
                         % (window, WIDEST_WINDOW))
    room = USUAL_QUADS
    while True:
        quads = np.empty((room, 4, 2), np.float32)
        found = _find_quads(_image(image), window, shortest, room, quads)
        if found < 0:
            raise MemoryError
        if found <= room:
            return quads[:found]
        room = found


def read_tags(frame: Image, quads: Numbers, words: Numbers, size: int, border: int,
              corrected: int, contrast: float) -> tuple[Integers, Floats]:
    """See read_tags in tags/quads.py."""
    frame, quads, words = _frame(frame), _quads('quadrilaterals', quads), _numbers(words, np.uint64)
    check_array('words of the dictionary', words, np.uint64, (len(words) if words.ndim else 0, 4))
    for name, value, least, most in (
            ('size of a tag', size, 1, MAX_WORD), ('border of a tag', border, 1, MAX_BORDER),
            ('number of corrected cells', corrected, 0, size * size)):
        if value not in range(least, most + 1):
            raise InputError('The %s cannot be %s; choose a whole number from %d to %d.'
                             % (name, value, least, most))
    ids, turned = np.empty(len(quads), np.int32), quads.copy()
    if not _read_tags(_image(frame), len(quads), turned, size + 2 * border, border, len(words), words,
                      corrected, contrast, ids):
        raise MemoryError
    return ids, turned


def find_sides(quads: Numbers) -> Floats:
    """See side_of in tags/edges.py."""
    quads = _quads('quadrilaterals', quads, np.float64)
    sides = np.empty(len(quads))
    _find_sides(len(quads), quads, sides)
    return sides


def find_room(quads: Numbers, width: int, height: int) -> Floats:
    """See room_of in tags/edges.py. ``width``, ``height``: of the frame."""
    quads = _quads('quadrilaterals', quads, np.float64)
    room = np.empty(len(quads))
    _find_room(len(quads), quads, width, height, room)
    return room


def find_box(positions: Image, step: int, to_area: Floats) -> Floats:
    """(4,) float64: the least x and y, and the greatest ones, of the pixels of a grid that are in an area.

    ``positions``: (h, w, 2) float32, the undistorted position of each pixel. ``step``: from one pixel of the
    grid to the next. ``to_area``: (3, 3), from undistorted pixels to the area, the unit square. The least are
    infinite if the area has none of these pixels.
    """
    positions = _rows('array of undistorted positions', positions, np.float32, *_sized(positions, 2)[1:])
    to_area = _numbers(to_area, np.float64)
    check_array('homography', to_area, np.float64, (3, 3))
    if step < 1:
        raise InputError('A grid cannot have a step of %s pixels; choose 1 or more.' % step)
    box = np.empty(4)
    _find_box(positions, positions.strides[0], positions.shape[1], positions.shape[0], step, to_area, box)
    return box


def find_convex(quads: Numbers, least: float) -> Booleans:
    """See is_quadrilateral in geometry/ordering.py. ``least``: the height of each corner, at least, pixels."""
    quads = _numbers(quads, np.float64)
    check_array('corners', quads, np.float64, (*quads.shape[:-2], 4, 2))
    convex = np.empty(quads.shape[:-2], bool)
    _find_convex(convex.size, quads, least, convex)
    return convex


def draw_mask(frame: Image, corners: Numbers, positions: Image | None = None) -> Image:
    """A mask of the frame's shape, uint8: white within the corners, (4, 2) undistorted pixels, gray on the rim.

    ``frame``: (h, w) or (h, w, k) uint8, which may be empty. ``positions``: see warp in painting/paint.py.
    """
    check_array('frame', frame, np.uint8, *_sized(frame, 'k'))
    corners = _numbers(corners, np.float64)
    check_array('corners', corners, np.float64, (4, 2))
    mask = np.zeros(frame.shape, np.uint8)
    _draw_mask(_image(mask), corners, *_positions_and_row(positions, mask))
    return mask


def warp_picture(picture: Image, level: Callable[[int, int], Image], to_picture: Floats, mask: Image,
                 positions: Image | None = None) -> Image:
    """See warp in painting/paint.py. ``level``: that of a Picture. ``to_picture``: (3, 3), the other way."""
    check_array('picture', picture, np.uint8, *PICTURE)
    height, width, channels = picture.shape
    if max(height, width) > MAX_PICTURE_SIDE_PX or picture.size > MAX_PICTURE_BYTES:
        raise InputError('The picture is %d x %d pixels large; give one of at most %d each way, and of at most '
                         '%d bytes.' % (width, height, MAX_PICTURE_SIDE_PX, MAX_PICTURE_BYTES))
    mask = _packed('mask', mask, np.uint8, *_sized(mask, 3))
    to_picture = _numbers(to_picture, np.float64)
    check_array('homography', to_picture, np.float64, (3, 3))
    way = to_picture, *_positions_and_row(positions, mask)
    warped = np.zeros((*mask.shape[:2], channels), np.uint8)
    blocks = np.empty((-(-mask.shape[0] // BLOCK_HEIGHT), -(-mask.shape[1] // BLOCK_WIDTH)), np.uint16)
    size = max(width, 2), max(height, 2)
    _find_levels(_image(mask), *size, *way, blocks)
    levels, kept = (_Image * LEVELS**2)(), []
    for number in np.flatnonzero(np.bincount(blocks.ravel(), minlength=LEVELS**2)[:LEVELS**2]).tolist():
        across, down = divmod(number, LEVELS)
        made = level(across, down)
        check_array('level of the picture', made, np.uint8, (size[1] >> down, size[0] >> across, channels))
        kept.append(made if _is_packed(made) else _numbers(made, np.uint8))
        levels[number] = _image(kept[-1])
    _warp_picture(_image(warped), _image(mask), *size, levels, blocks, *way)
    return warped


def start_motion(motion: Floats, points: Numbers, deviation: Numbers, bias: Numbers) -> None:
    """Start a motion whose place and middle are set: see AreaMotion in tracking/motion.py.

    ``motion``: (MOTION,) float64, the C structure Motion of unit5.h, which is changed.
    """
    points, _, deviation, bias = _measurement(points, points, deviation, bias)
    _start_motion(_motion(motion), len(points), points, deviation, bias)


def predict_motion(motion: Floats, seconds: float, calm: bool) -> None:
    """See AreaMotion.predict in tracking/motion.py; changes ``motion``."""
    _predict_motion(_motion(motion), seconds, bool(calm))


def jerk_motion(motion: Floats) -> None:
    """See AreaMotion.after_jerk in tracking/motion.py; changes ``motion``."""
    _jerk_motion(_motion(motion))


def correct_motion(motion: Floats, points: Numbers, pixels: Numbers, deviation: Numbers, bias: Numbers,
                   limit: float) -> bool:
    """See AreaMotion.correct in tracking/motion.py; changes ``motion``."""
    points, pixels, deviation, bias = _measurement(points, pixels, deviation, bias)
    return bool(_correct_motion(_motion(motion), len(points), points, pixels, deviation, bias, limit))


def find_deviation(motion: Floats) -> Floats:
    """See AreaMotion.deviation in tracking/motion.py."""
    deviation = np.empty(4)
    _find_deviation(_known_motion(motion), deviation)
    return deviation


def unlikeliness(motion: Floats, points: Numbers, pixels: Numbers, deviation: Numbers) -> float:
    """See AreaMotion.unlikeliness in tracking/motion.py."""
    points, pixels, deviation, _ = _measurement(points, pixels, deviation, deviation)
    return float(_unlikeliness(_known_motion(motion), len(points), points, pixels, deviation))


def project(motion: Floats, points: Numbers) -> Floats:
    """See AreaMotion.project in tracking/motion.py."""
    points = _numbers(points, np.float64)
    check_array('points', points, np.float64, (*points.shape[:-1], 2))
    pixels = np.empty(points.shape)
    _project(_known_motion(motion), points.size // 2, points, pixels)
    return pixels


def learn_patches(image: Floats, points: Numbers) -> Floats:
    """(WALL_LEVELS, n, PATCH_SIZE) float32: what align_patches needs of an image, around points, (n, 2).

    ``image``: (h, w) float32, gray. Points are relative to its middle, in halves of its width.
    """
    image, points = _wall_image(image), _points(points)
    patches = np.empty((WALL_LEVELS, len(points), PATCH_SIZE), np.float32)
    if not _learn_patches(image, *image.shape[::-1], len(points), points, patches):
        raise MemoryError
    return patches


def align_patches(image: Floats, patches: Floats, places: Numbers, usable: Booleans, coarsest: int,
                  only_compare: bool = False) -> tuple[Floats, Floats, Floats]:
    """See Texture in tracking/texture.py, and unit5.h: the warps, the likeness and what the patches are off.

    These are (WALL_LEVELS, 3, 3) float64, (WALL_LEVELS, n) float32 and (WALL_LEVELS, n, 2) float32.
    ``image``: (h, w) float32. ``places``: (n, 2). ``usable``: (n,) bool. ``coarsest``: the first level, 0 for
    the finest; all is 0 for those above. ``only_compare``: whether the patches stay where they are.
    """
    image, places = _wall_image(image), _points(places)
    count = len(places)
    patches = _packed('patches', patches, np.float32, (WALL_LEVELS, count, PATCH_SIZE))
    usable = _packed('usable patches', usable, bool, (count,))
    if not 0 <= coarsest < WALL_LEVELS:
        raise InputError('A wall has no level %s; choose from 0 to %d.' % (coarsest, WALL_LEVELS - 1))
    warps, likeness = np.zeros((WALL_LEVELS, 3, 3)), np.zeros((WALL_LEVELS, count), np.float32)
    off = np.zeros((WALL_LEVELS, count, 2), np.float32)
    if not _align_patches(image, *image.shape[::-1], count, patches, places, usable, coarsest, only_compare,
                          warps, likeness, off):
        raise MemoryError
    return warps, likeness, off


def mix_picture(window: Image, picture: Image, mask: Image, opacity: float) -> tuple[Image, Image]:
    """What to subtract from a window, and what to add then, (h, w, 3) uint8 each: a mixture with a picture.

    ``window``, ``mask``: (h, w, 3) uint8. ``picture``: (h, w, 3) BGR or (h, w, 4) BGRA. ``opacity``: 0 to 1.
    """
    size = _sized(window, 3)[1][:2]
    window = _rows('frame', window, np.uint8, (*size, 3))
    picture = _rows('picture', picture, np.uint8, (*size, 3), (*size, 4))
    mask = _rows('mask', mask, np.uint8, (*size, 3))
    if not 0 <= opacity <= 1:
        raise InputError('A picture cannot have the opacity %s; choose from 0 to 1.' % opacity)
    hidden, shown = np.empty(mask.shape, np.uint8), np.empty(mask.shape, np.uint8)
    _mix_picture(_image(window), _image(picture), _image(mask), round(255 * opacity), hidden, shown)
    return hidden, shown


def light_picture(picture: Image, mask: Image, white: Image, black: float) -> None:
    """Change a picture, (h, w, 3) or (h, w, 4) uint8, contiguous, as if it hung in a light: see unit5.h.

    ``mask``: (h, w, 3) uint8; where it is black, the picture may stay as it is. ``white``: (rows, columns, 3)
    uint8, h and w divided by LIGHT_STEP_PX and rounded up. ``black``: 0 to 1.
    """
    size = _sized(mask, 3)[1][:2]
    mask = _rows('mask', mask, np.uint8, (*size, 3))
    _check_changed('picture', picture, np.uint8, (*size, 3), (*size, 4))
    white = _rows('light', white, np.uint8, (*(-(-side // LIGHT_STEP_PX) for side in mask.shape[:2]), 3))
    if not 0 <= black <= 1:
        raise InputError('Black cannot be %s of white; choose from 0 to 1.' % black)
    if picture.size and not _light_picture(_image(picture), _image(mask), _image(white), round(255 * black)):
        raise MemoryError


def soften_picture(picture: Image, mask: Image, across: float, down: float) -> tuple[Image, Image]:
    """A picture and its mask, blurred by a normal distribution: two (h, w, 3) uint8. See unit5.h.

    ``picture``, ``mask``: (h, w, 3) uint8. ``across``, ``down``: the deviation, 0 to MAX_SOFTNESS_PX.
    """
    size = _sized(mask, 3)[1][:2]
    mask = _rows('mask', mask, np.uint8, (*size, 3))
    picture = _rows('picture', picture, np.uint8, (*size, 3))
    if not (0 <= across <= MAX_SOFTNESS_PX and 0 <= down <= MAX_SOFTNESS_PX):
        raise InputError('A picture cannot be blurred by %s and %s pixels; choose from 0 to %d.'
                         % (across, down, MAX_SOFTNESS_PX))
    softened, share = np.zeros(mask.shape, np.uint8), np.zeros(mask.shape, np.uint8)
    if mask.size and not _soften_picture(_image(picture), _image(mask), across, down, softened, share):
        raise MemoryError
    return softened, share


def find_ways(quads: Floats) -> Floats:
    """(n, 4, RING_PLACES, 2, 2): where read_rings looks beside quadrilaterals, (n, 4, 2), without a lens."""
    quads = _quads('quadrilaterals', quads, np.float64)
    ways = np.empty((len(quads), 4, RING_PLACES, 2, 2))
    _find_ways(len(quads), quads, ways)
    return ways


def read_rings(frame: Image, quads: Floats, ways: Floats) -> tuple[Floats, Booleans, Floats, Floats]:
    """What is beside n quadrilaterals: see unit5.h.

    ``frame``: (h, w, 3) uint8. ``quads``: (n, 4, 2). ``ways``: see find_ways; pixels of the frame. The results
    are (n, 4 * RING_PLACES, 3) float64, (n, 4 * RING_PLACES), (n, 4, 2) float64 and (n, 2) float64.
    """
    frame = _rows('frame', frame, np.uint8, ('h', 'w', 3))
    quads, ways = _quads('quadrilaterals', quads, np.float64), _numbers(ways, np.float64)
    count = len(quads)
    check_array('ways', ways, np.float64, (count, 4, RING_PLACES, 2, 2))
    colors, shown = np.empty((count, 4 * RING_PLACES, 3)), np.empty((count, 4 * RING_PLACES), bool)
    corners, reaches = np.empty((count, 4, 2)), np.empty((count, 2))
    _read_rings(_image(frame), count, quads, ways, colors, shown, corners, reaches)
    return colors, shown, corners, reaches


def even_rings(colors: Floats, shown: Booleans, seen: Booleans, before: Floats) -> tuple[Floats, Floats]:
    """The colors of n rings without those of other things, and the usual ones as they are now: see unit5.h.

    ``colors``, ``shown``: see read_rings. ``seen``: (n,) bool. ``before``: the usual colors so far, of the same
    shape, NaN if unknown.
    """
    colors, usual = _numbers(colors, np.float64), np.array(before, np.float64, order='C')
    count = len(colors) if colors.ndim else 0
    check_array('colors', colors, np.float64, (count, 4 * RING_PLACES, 3))
    shown = _packed('shown places', shown, np.bool_, colors.shape[:2])
    seen = _packed('seen tags', seen, np.bool_, (count,))
    check_array('usual colors', usual, np.float64, colors.shape)
    even = np.empty(colors.shape)
    _even_rings(count, colors, shown, seen, usual, even)
    return even, usual


def draw_cover(mask: Image, positions: Image | None, corner: tuple[int, int], cover: Floats, to_cover: Floats,
               channels: int, frame: Image, to_tiles: Floats, shifts: Integers, smooth: Floats) -> Image:
    """(h, w, channels) uint8: a cover of a tag; black where the mask is. See unit5.h.

    ``mask``: (h, w, 3) uint8. ``positions``: see warp in painting/paint.py. ``corner``: x and y in the frame,
    (H, W, 3) uint8, of the mask's first pixel. ``cover``: (m, k, 4), m and k at least 2. ``to_cover``,
    ``to_tiles``: (3, 3). ``channels``: 3 or 4. ``shifts``: (n, n, 2), pixels. ``smooth``: (n, n, 3, 4).
    """
    mask = _rows('mask', mask, np.uint8, *_sized(mask, 3)[1:])
    frame = _rows('frame', frame, np.uint8, *_sized(frame, 3)[1:])
    cover, to_cover, to_tiles, shifts, smooth = (_numbers(array, dtype) for array, dtype in (
        (cover, np.float32), (to_cover, np.float64), (to_tiles, np.float64), (shifts, np.int32),
        (smooth, np.float32)))
    rows, columns = cover.shape[:2] if cover.ndim == 3 else (2, 2)
    count = len(shifts) if shifts.ndim else 0
    check_array('cover', cover, np.float32, (max(rows, 2), max(columns, 2), 4))
    check_array('homography', to_cover, np.float64, (3, 3))
    check_array('homography', to_tiles, np.float64, (3, 3))
    check_array('shifts of the tiles', shifts, np.int32, (count, count, 2))
    check_array('smooth part of the tiles', smooth, np.float32, (count, count, 3, 4))
    if channels not in (3, 4):
        raise InputError('A cover cannot have %s channels; choose 3 or 4.' % channels)
    image = np.zeros((*mask.shape[:2], channels), np.uint8)
    _draw_cover(_image(image), _image(mask), *_positions_and_row(positions, mask), *corner, rows, columns,
                cover, to_cover, _image(frame), count, to_tiles, shifts, smooth)
    return image


def choose_sources(frame: Image, middles: Floats, at: Floats, frames: int, learns: bool, usual: Floats,
                   order: Floats, stays: float, to_sources: Integers) -> Floats | None:
    """The smooth parts of the sources of n tiles, (n, 3, 4) float32: see unit5.h; None if too few are usable.

    ``frame``: (h, w, 3) uint8. ``middles``: (n, 2). ``at``: (m, 3, 2). ``frames``: at least 1. ``order``:
    (n, m). ``usual``: (m, 4) float32, and ``to_sources``: (n, 2) int32, contiguous, which may change.
    """
    frame = _rows('frame', frame, np.uint8, *_sized(frame, 3)[1:])
    middles, at, order = _points(middles), _numbers(at, np.float64), _numbers(order, np.float32)
    count, tiles = len(at) if at.ndim else 0, len(middles)
    check_array('places of the sources', at, np.float64, (count, 3, 2))
    check_array('order', order, np.float32, (tiles, count))
    _check_changed('usual look of the sources', usual, np.float32, (count, 4))
    _check_changed('shifts of the tiles', to_sources, np.int32, (tiles, 2))
    if count > MOST_SOURCES or frames < 1:
        raise InputError('There are %d sources and %s frames; give at most %d, and at least 1.'
                         % (count, frames, MOST_SOURCES))
    smooth = np.empty((tiles, 3, 4), np.float32)
    found = _choose_sources(_image(frame), count, middles, at, frames, learns, usual, tiles, order, stays,
                            to_sources, smooth)
    return smooth if found else None


def find_pose_pairs(points: Numbers, rays: Numbers) -> tuple[Floats, Floats, Booleans]:
    """See approximate_poses in geometry/plane_pose.py."""
    points, rays = _numbers(points, np.float64), _numbers(rays, np.float64)
    objects, count = points.shape[:2] if points.ndim == 3 else (0, 0)
    check_array('points', points, np.float64, (objects, count, 3))
    check_array('rays', rays, np.float64, (objects, count, 2))
    rotations, translations = np.zeros((objects, 2, 3, 3)), np.zeros((objects, 2, 3))
    is_posed = np.zeros(objects, np.bool_)
    _find_pose_pairs(objects, count, points, rays, rotations, translations, is_posed)
    return rotations, translations, is_posed


def refine_pose_pairs(
        points: Numbers, rays: Numbers, weights: Numbers, rotations: Numbers, translations: Numbers,
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
    if not _refine_pose_pairs(objects, count, deviations, points, rays, weights, spread, rotations,
                              translations, amounts, squares, covariances):
        raise MemoryError
    return rotations, translations, amounts, squares, covariances


def find_tag_poses(quads: Numbers, least: float, rays: Numbers, slopes: Numbers, sizes: Numbers) -> \
        tuple[Booleans, Floats, Floats, Floats, Floats, Floats, Floats]:
    """Which tags can be there, (n,) bool, and of those: deviation, weights, the poses' three arrays, and costs.

    unit5.h says what the arguments are, and SeenTags what the results are.
    """
    quads = _quads('quadrilaterals', quads, np.float64)
    count = len(quads)
    rays, slopes, sizes = (_numbers(each, np.float64) for each in (rays, slopes, sizes))
    for name, array, shape in (('rays', rays, (count, 4, 2)), ('slopes', slopes, (count, 4, 2, 2)),
                               ('sizes', sizes, (count,))):
        check_array(name, array, np.float64, shape)
    is_seen, deviation, costs = np.zeros(count, np.bool_), np.zeros(count), np.zeros((count, 2))
    weights = np.zeros((count, 4, 2, 2))
    poses = np.zeros((count, 2, 3, 3)), np.zeros((count, 2, 3)), np.zeros((count, 2, 6, 6))
    found = (is_seen, deviation, weights, *poses, costs)
    if not _find_tag_poses(count, quads, least, rays, slopes, sizes, *found):
        raise MemoryError
    return found


def weigh_poses(rotations: Numbers, translations: Numbers, covariances: Numbers, costs: Numbers, now: float,
                memories: Floats) -> tuple[Integers, Floats]:
    """See Belief.weigh. ``memories``: (n, BELIEF_SIZE), of the objects; changed. It is NaN for a new one."""
    count = len(memories)
    poses = _poses('', (rotations, translations, covariances), (count, 2))
    costs = _numbers(costs, np.float64)
    check_array('costs', costs, np.float64, (count, 2))
    _check_memories(memories, BELIEF_SIZE)
    believed, weights = np.empty(count, np.int64), np.empty(count)
    _weigh_poses(count, *poses, costs, now, memories, believed, weights)
    return believed, weights


def mix_poses(one: Pose, other: Pose, weights: Floats) -> tuple[Floats, Floats]:
    """See mixture in poses/belief.py. ``weights``: (n,)."""
    weights, count = np.array(weights, np.float64), len(one[0])
    check_array('weights', weights, np.float64, (count,))
    mixed = np.empty((count, 6, 6))
    _mix_poses(count, *_poses('', one, (count,)), *_poses('other ', other, (count,)), weights, mixed)
    return mixed, weights


def place_tags(wall: Pose, amounts: Floats, rotations: Floats, centers: Floats, spread: Floats) -> Pose:
    """See poses_of_tags in poses/observations.py. ``wall``: both poses, as in WallFit."""
    amounts, spread = _numbers(amounts, np.float64), _numbers(spread, np.float64)
    count, deviations = len(spread), min(spread.shape[-1], MAX_DEVIATIONS)
    wall = _poses("wall's ", wall, (2,), 6 + deviations)
    rotations, centers = (_numbers(each, np.float64) for each in (rotations, centers))
    for name, array, shape in (('amounts', amounts, (2, deviations)), ('rotations', rotations, (count, 3, 3)),
                               ('centers', centers, (count, 3)), ('spread', spread, (count, 6, deviations))):
        check_array(name, array, np.float64, shape)
    found = np.empty((count, 2, 3, 3)), np.empty((count, 2, 3)), np.empty((count, 2, 6, 6))
    if not _place_tags(count, deviations, wall[0], wall[1], amounts, wall[2], rotations, centers, spread,
                       *found):
        raise MemoryError
    return found


def off_others(poses: Pose, axes: Numbers, bulge: Numbers) -> tuple[Floats, Floats]:
    """See off_others in poses/observations.py."""
    count = len(poses[0])
    poses = _poses('', poses, (count,))
    axes, bulge = _numbers(axes, np.float64), _numbers(bulge, np.float64)
    check_array('axes', axes, np.float64, (3, 3))
    check_array('bulge', bulge, np.float64, (3, 3))
    off, spread = np.empty((count, 3)), np.empty((count, 3, 3))
    if not _off_others(count, *poses, axes, bulge, off, spread):
        raise MemoryError
    return off, spread


def add_off(off: Numbers, spread: Numbers, memories: Floats) -> Floats:
    """See Flatness.update. ``memories``: (n, FLATNESS_SIZE), of the tags; changed. It is 0 for a new one."""
    off, spread = _numbers(off, np.float64), _numbers(spread, np.float64)
    count = len(memories)
    for name, array, shape in (('off', off, (count, 3)), ('spread', spread, (count, 3, 3))):
        check_array(name, array, np.float64, shape)
    _check_memories(memories, FLATNESS_SIZE)
    squared = np.empty(count)
    _add_off(count, off, spread, memories, squared)
    return squared


def measure_light(seen: Image, look: Floats, usable: Booleans, front: Booleans,
                  light: Floats) -> tuple[Floats, float]:
    """The light on the whole wall, (3,) float32, and that outside of shadows, or -1 if nothing shows it.

    unit5.h says what the arguments are. ``light``: (3,), that before.
    """
    usable = _packed('usable pixels', usable, np.bool_, *_sized(usable))
    size = usable.shape
    seen, look = _packed('frame', seen, np.uint8, (*size, 3)), _packed('look', look, np.float32, (*size, 3))
    front = _packed('pixels in front', front, np.bool_, size)
    light, unshaded = _packed('light', light, np.float32, (3,)).copy(), _FLOAT()
    if not _measure_light(seen, look, usable, front, size[1], size[0], light, ctypes.byref(unshaded)):
        raise MemoryError
    return light, unshaded.value


def light_wall(look: Floats, whole: Floats) -> Image:
    """(h, w, 3) uint8: a wall in a light. ``look``: (h, w, 3) float32. ``whole``: (3,) float32, its factors."""
    look = _packed('look', look, np.float32, _sized(look, 3)[1])
    whole = _packed('light', whole, np.float32, (3,))
    wall = np.empty(look.shape, np.uint8)
    _light_wall(look, whole, wall.size // 3, wall)
    return wall


def compare_wall(seen: Image, look: Floats, whole: Floats, contrast: Image, variance: Floats, usable: Booleans,
                 darkest: float, lightest: float) -> tuple[Booleans, Floats]:
    """(h, w), where something seems to stand in front of the wall, and the planes, (PLANES, h, w) float32.

    unit5.h says what the arguments are, and wall.c what the planes are.
    """
    usable = _packed('usable pixels', usable, np.bool_, *_sized(usable))
    height, width = size = usable.shape
    seen, look = _packed('frame', seen, np.uint8, (*size, 3)), _packed('look', look, np.float32, (*size, 3))
    whole, variance = _packed('light', whole, np.float32, (3,)), _packed('variance', variance, np.float32, size)
    contrast = _packed('contrast', contrast, np.uint8, (*size, 3))
    planes, front = np.empty((PLANES, *size), np.float32), np.empty(size, bool)
    if not _compare_wall(seen, look, whole, contrast, variance, usable, width, height, darkest, lightest,
                         planes, front):
        raise MemoryError
    return front, planes


def learn_wall(seen: Image, whole: Floats, planes: Floats, wall: Booleans, certain: Booleans, passed: float,
               settle: float, rate: float, variance_rate: float, look: Floats, variance: Floats,
               known: Booleans, seconds: Floats) -> None:
    """Learn the wall, as explained in unit5.h. Changes the last four arrays, which must be contiguous."""
    wall = _packed('wall', wall, np.bool_, *_sized(wall))
    size = wall.shape
    seen, whole = _packed('frame', seen, np.uint8, (*size, 3)), _packed('light', whole, np.float32, (3,))
    planes = _packed('planes', planes, np.float32, (PLANES, *size))
    certain = _packed('certain wall', certain, np.bool_, size)
    for name, array, dtype, shape in (
            ('look', look, np.float32, (*size, 3)), ('variance', variance, np.float32, size),
            ('known wall', known, np.bool_, size), ('seconds', seconds, np.float32, size)):
        _check_changed(name, array, dtype, shape)
    _learn_wall(seen, whole, planes, wall, certain, wall.size, passed, settle, rate, variance_rate, look,
                variance, known, seconds)


def _tags(frame: Any, quads: Any, cells: Any) -> tuple[Any, Any, Any]:
    """A frame, quadrilaterals in it, and the cells of their tags, checked."""
    frame, quads = _frame(frame), _quads('quadrilaterals', quads)
    count = len(quads)
    cells = _numbers(cells, np.uint8) if count else np.zeros((0, 3, 3), np.uint8)
    side = cells.shape[-1] if cells.ndim else 0
    check_array('cells of the tags', cells, np.uint8, (count, max(side, 3), max(side, 3)))
    _check_count(side)
    return frame, quads, cells


def _fit(frame: Any, quads: Any, cells: Any, whole: Any = None,
         samples: int = 0) -> tuple[Floats, Booleans, Floats]:
    """Call the function in C, which changes the cells and ``whole``, unless that is None."""
    count = len(quads)
    fitted, found = np.empty((count, 4, 2), np.float32), np.empty(count, bool)
    likeness = np.empty(count, np.float32)
    _fit_tags(_image(frame), count, quads, cells.shape[1], cells, fitted, found, likeness, samples, whole)
    return fitted, found, likeness


def _known_motion(motion: Floats) -> Any:
    """A motion, checked, which is not changed."""
    return _packed('motion', motion, np.float64, (MOTION,))


def _motion(motion: Floats) -> Floats:
    """A motion, checked: an array that a function in C may change."""
    _check_changed('motion', motion, np.float64, (MOTION,))
    return motion


def _poses(name: str, poses: Any, axes: tuple[int, ...], size: int = 6) -> Any:
    """Poses with those axes in front, checked. ``size``: that of their covariances."""
    poses = tuple(_numbers(part, np.float64) for part in poses)
    for part, array, shape in (('rotations', poses[0], (3, 3)), ('translations', poses[1], (3,)),
                               ('covariances', poses[2], (size, size))):
        check_array(name + part, array, np.float64, (*axes, *shape))
    return poses


def _check_memories(memories: Any, size: int) -> None:
    """Check numbers that are remembered of objects, (n, size), and changed."""
    _check_changed('memories', memories, np.float64, (len(memories), size))


def _measurement(*arrays: Any) -> Any:
    """A measurement for a motion, checked: points, pixels, deviation and bias."""
    points, pixels, deviation, bias = (_numbers(array, np.float64) for array in arrays)
    count = len(points) if points.ndim else 0
    for name, array, shape in (('points', points, (count, 2)), ('pixels', pixels, (count, 2)),
                               ('deviation', deviation, (count,)), ('bias', bias, (count,))):
        check_array(name, array, np.float64, shape)
    if not count or count % 4:
        raise InputError('A measurement has %d points; give four for each tag, of at least one tag.' % count)
    return points, pixels, deviation, bias


def _wall_image(image: Any) -> Any:
    """A gray image, (h, w) float32, checked."""
    image = _packed('image', image, np.float32, ('h', 'w'))
    if min(image.shape) < 2**(WALL_LEVELS - 1):
        raise InputError('The image is %d x %d pixels large; give one of at least %d each way.'
                         % (*image.shape[::-1], 2**(WALL_LEVELS - 1)))
    return image


def _points(points: Any) -> Any:
    """Points, (n, 2) float64, checked."""
    points = _numbers(points, np.float64)
    check_array('points', points, np.float64, (len(points) if points.ndim else 0, 2))
    return points


def _frame(frame: Any) -> Any:
    return _rows('frame', frame, np.uint8, *GRAY_OR_COLOR, ('h', 'w', 1), ('h', 'w', 4))


def _check_samples(samples: int) -> None:
    if not 1 <= samples <= MAX_SAMPLES:
        raise InputError('A cell cannot be sampled %s times; choose from 1 to %d.' % (samples, MAX_SAMPLES))


def _check_count(cells: int) -> None:
    if not 1 <= cells <= MAX_CELLS:
        raise InputError('A tag cannot be %s cells wide; choose from 1 to %d.' % (cells, MAX_CELLS))


def _quads(name: str, quads: Any, dtype: Any = np.float32) -> Any:
    """Quadrilaterals, (n, 4, 2), checked."""
    quads = _numbers(quads, dtype)
    check_array(name, quads, dtype, (len(quads) if quads.ndim else 0, 4, 2))
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


def _check_changed(name: str, array: Any, dtype: Any, *shapes: Shape) -> None:
    """Check an array that a function in C changes."""
    check_array(name, array, dtype, *shapes, writes=True)
    if not _is_packed(array):
        raise InputError('The %s is not contiguous, but it would be changed; give a copy, by .copy().' % name)


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


def _positions_and_row(positions: Image | None, mask: Image) -> tuple[Image | None, int]:
    """The undistorted positions of a mask's pixels, checked, and the bytes from one row to the next."""
    if positions is None:
        return None, 0
    positions = _rows('array of undistorted positions', positions, np.float32, (*mask.shape[:2], 2))
    return positions, positions.strides[0]
