"""Every function in C, and what calls it, with arrays of all kinds: a right result or a clear error.

The last test runs all others once more, with a library in which the compiler checks each access to memory.
"""
import os
import shutil
import subprocess
import sys

import cv2
import numpy as np
import pytest
from aruco_ar import Area, Detector, InputError, Lens, area_mask, draw_tag, overlay, subtract
from aruco_ar.compiled import binding
from aruco_ar.compiled.compiler import compile_to
from aruco_ar.geometry.homography import homography_from
from aruco_ar.painting.paint import put_in, warp
from aruco_ar.painting.picture import Picture
from aruco_ar.tags.quads import tag_words

WIDTH, HEIGHT = 61, 47
CORNERS = np.float32([[9, 8], [50, 5], [55, 40], [12, 36]])


def frame_with_tag():
    """A frame, its tag's quadrilateral and its cells: (h, w, 3), (1, 4, 2), (1, 8, 8)."""
    cells = draw_tag('DICT_6X6_250', 3, 8)[None]
    frame = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    frame[5:37, 8:40] = cv2.resize(cells[0], (32, 32), interpolation=cv2.INTER_NEAREST)[..., None]
    return cv2.GaussianBlur(frame, (0, 0), 1), np.float32([[[8, 5], [39, 5], [39, 36], [8, 36]]]), cells


def positions():
    """(h, w, 2) float32, the undistorted positions of pixels: here, they are not distorted."""
    return np.dstack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))).astype(np.float32)


def of_fit_tags():
    frame, quads, cells = frame_with_tag()
    return binding.fit_tags, {'frame': frame, 'quads': quads, 'cells': cells}


def of_compare_tags():
    _, arrays = of_fit_tags()
    return lambda **arrays: binding.compare_tags(**arrays, samples=3), arrays


def of_check_tags():
    _, arrays = of_fit_tags()
    return lambda **arrays: binding.check_tags(**arrays, samples=3), arrays


def of_sample_cells():
    frame, quads, _ = frame_with_tag()
    return lambda **arrays: binding.sample_cells(**arrays, count=8, margin=-1), {'frame': frame, 'quads': quads}


def of_guess_tags():
    frame, quads, _ = frame_with_tag()
    return lambda frame, quads, others: binding.guess_tags(frame, quads, 8, others, 12), {
        'frame': 255 - frame, 'quads': quads, 'others': quads + 30}


def of_find_quads():
    return lambda gray: binding.find_quads(gray, 7, 40), {
        'gray': cv2.cvtColor(frame_with_tag()[0], cv2.COLOR_BGR2GRAY)}


def of_read_tags():
    frame, quads, _ = frame_with_tag()
    return lambda frame, quads, words: binding.read_tags(frame, quads, words, 6, 1, 5, 12), {
        'frame': frame, 'quads': np.concatenate([quads, quads + 20]), 'words': tag_words('DICT_6X6_250')}


def of_draw_mask():
    return binding.draw_mask, {'frame': frame_with_tag()[0], 'corners': CORNERS, 'positions': positions()}


def of_warp_picture():
    picture = np.random.RandomState(0).randint(0, 256, (90, 130, 4)).astype(np.uint8)
    area = Area(CORNERS)
    mask = area_mask(frame_with_tag()[0], area)

    def call(picture, to_picture, mask, positions):
        return binding.warp_picture(picture, Picture(picture).level, to_picture, mask, positions)
    return call, {'picture': picture, 'to_picture': np.linalg.inv(area.homography(130, 90)), 'mask': mask,
                  'positions': positions()}


def of_find_sides():
    return binding.find_sides, {'quads': np.float64([CORNERS, CORNERS + 3])}


def of_find_room():
    return lambda quads: binding.find_room(quads, 640, 480), {'quads': np.float64([CORNERS, CORNERS + 3])}


def of_find_box():
    return (lambda positions, to_area: binding.find_box(positions, 16, to_area),
            {'positions': positions(), 'to_area': homography_from(CORNERS)})


def of_find_convex():
    return lambda quads: binding.find_convex(quads, 2), {'quads': np.float64([CORNERS, CORNERS[[1, 0, 2, 3]]])}


POINTS = np.float64([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1],
                     [0.9, 0.9], [1.1, 0.9], [1.1, 1.1], [0.9, 1.1]])


def of_start_motion():
    motion = np.zeros(binding.MOTION)
    motion[:8], motion[336:338] = CORNERS.ravel(), (30, 23)
    return binding.start_motion, {'motion': motion, 'points': POINTS, 'deviation': np.full(8, 0.3),
                                  'bias': np.full(8, 0.1)}


def started():
    """A motion, and a measurement of it: its points, pixels and their deviation."""
    start, arrays = of_start_motion()
    start(**arrays)
    motion = arrays.pop('motion')
    return {'motion': motion, 'points': POINTS, 'pixels': binding.project(motion, POINTS) + 0.2,
            'deviation': arrays['deviation']}


def of_predict_motion():
    return lambda motion: binding.predict_motion(motion, 0.03, True), {'motion': started()['motion']}


def of_jerk_motion():
    return binding.jerk_motion, {'motion': started()['motion']}


def of_correct_motion():
    return lambda **arrays: binding.correct_motion(**arrays, limit=9), {**started(), 'bias': np.full(8, 0.1)}


def of_unlikeliness():
    return binding.unlikeliness, started()


def of_find_deviation():
    return binding.find_deviation, {'motion': started()['motion']}


def of_project():
    return binding.project, {key: array for key, array in started().items() if key in ('motion', 'points')}


def of_learn_patches():
    image = cv2.cvtColor(frame_with_tag()[0], cv2.COLOR_BGR2GRAY).astype(np.float32)
    return binding.learn_patches, {'image': image, 'points': np.float64([[-0.7, -0.5], [0.1, 0.0], [0.9, 0.7]])}


def of_align_patches():
    learn, arrays = of_learn_patches()
    return lambda **arrays: binding.align_patches(**arrays, coarsest=binding.WALL_LEVELS - 1), {
        'image': arrays['image'], 'patches': learn(**arrays), 'places': arrays['points'] + 0.02,
        'usable': np.array([True, True, False])}


def of_mix_picture():
    random = np.random.RandomState(3)
    window, mask = (random.randint(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8) for _ in range(2))
    picture = random.randint(0, 256, (HEIGHT, WIDTH, 4)).astype(np.uint8)
    return lambda **arrays: binding.mix_picture(**arrays, opacity=0.7), {
        'window': window, 'picture': picture, 'mask': mask}


def of_light_picture():
    _, arrays = of_mix_picture()
    height, width = (-(-side // binding.LIGHT_STEP_PX) for side in (HEIGHT, WIDTH))
    return lambda **arrays: binding.light_picture(**arrays, black=0.1), {
        'picture': arrays['picture'], 'mask': arrays['mask'],
        'white': np.random.RandomState(4).randint(0, 256, (height, width, 3)).astype(np.uint8)}


def of_soften_picture():
    _, arrays = of_mix_picture()
    return lambda **arrays: binding.soften_picture(**arrays, across=1.3, down=0.7), {
        'picture': arrays['window'], 'mask': arrays['mask']}


def of_read_rings():
    random = np.random.RandomState(6)
    quads = np.float64([CORNERS, CORNERS + 3])
    return binding.read_rings, {
        'frame': random.randint(60, 90, (HEIGHT, WIDTH, 3)).astype(np.uint8), 'quads': quads,
        'ways': binding.find_ways(quads)}


def of_find_ways():
    return binding.find_ways, {'quads': np.float64([CORNERS, CORNERS + 3])}


def of_even_rings():
    random = np.random.RandomState(7)
    colors, before = (random.uniform(60, 90, (3, 4 * binding.RING_PLACES, 3)) for _ in range(2))
    return binding.even_rings, {
        'colors': colors, 'shown': random.uniform(size=colors.shape[:2]) < 0.8,
        'seen': np.array([True, False, True]), 'before': before}


def of_draw_cover():
    random = np.random.RandomState(4)
    return lambda **arrays: binding.draw_cover(corner=(10, 10), channels=4, **arrays), {
        'mask': np.full((HEIGHT, WIDTH, 3), 255, np.uint8), 'positions': positions(),
        'cover': random.uniform(80, 120, (5, 6, 4)).astype(np.float32), 'to_cover': np.diag([0.025, 0.035, 1]),
        'frame': random.randint(0, 256, (90, 80, 3)).astype(np.uint8), 'to_tiles': np.diag([0.05, 0.07, 1]),
        'shifts': np.int32([[[-8, 3], [7, 1]], [[4, -9], [-9, 8]]]),
        'smooth': random.normal(0, 9, (2, 2, 3, 4)).astype(np.float32)}


def of_choose_sources():
    random = np.random.RandomState(5)
    at = random.uniform(10, 30, (6, 1, 2)) + [[0, 0], [9, 1], [-1, 8]]
    return lambda **arrays: binding.choose_sources(frames=1, learns=True, stays=0.8, **arrays), {
        'frame': random.randint(60, 90, (HEIGHT, WIDTH, 3)).astype(np.uint8), 'at': at,
        'middles': at[:4, 0] + 9,
        'usual': np.zeros((6, 4), np.float32), 'order': random.uniform(0, 1, (4, 6)).astype(np.float32),
        'to_sources': np.zeros((4, 2), np.int32)}


def of_refine_pose_pairs():
    points = np.float64([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]] * 2)
    turned = np.float64([cv2.Rodrigues(np.float64([0.3 * sign, 0.2, 0.1]))[0] for sign in (1, -1)])
    shift = np.tile([0.1, 0.2, 5.0], (2, 2, 1))
    seen = points @ turned[0].T + shift[:, :1]
    spread = np.random.RandomState(1).normal(0, 0.01, (4, 3, 40))
    return binding.refine_pose_pairs, {
        'points': points, 'rays': seen[..., :2] / seen[..., 2:],
        'weights': np.tile(1e3 * np.eye(2), (2, 4, 1, 1)),
        'rotations': np.tile(turned, (2, 1, 1, 1)), 'translations': shift + 0.01, 'spread': spread}


def of_find_pose_pairs():
    _, arrays = of_refine_pose_pairs()
    return binding.find_pose_pairs, {name: arrays[name] for name in ('points', 'rays')}


def of_find_tag_poses():
    quads = np.float64([CORNERS, CORNERS + 3, CORNERS[::-1]])  # the last one is seen from behind
    return lambda quads, **arrays: binding.find_tag_poses(quads, 2, **arrays), {
        'quads': quads, 'rays': quads / 500, 'slopes': np.tile(500 * np.eye(2), (3, 4, 1, 1)),
        'sizes': np.ones(3)}


def poses(*axes, size=6):
    """Rotations, translations and covariances with those axes in front."""
    random = np.random.RandomState(4)
    turns = [cv2.Rodrigues(turn)[0] for turn in random.normal(0, 1, (int(np.prod(axes)), 3))]
    return {'rotations': np.reshape(turns, (*axes, 3, 3)), 'translations': random.normal(0, 1, (*axes, 3)),
            'covariances': np.tile(np.diag(random.uniform(0.1, 1, size)), (*axes, 1, 1))}


def of_weigh_poses():
    memories = np.full((3, binding.BELIEF_SIZE), np.nan)
    arrays = {**poses(3, 2), 'costs': np.float64([[1, 2], [3, 1], [0, 4]])}
    binding.weigh_poses(**arrays, now=1.0, memories=memories)
    return lambda **arrays: binding.weigh_poses(**arrays, now=1.1), {**arrays, 'memories': memories}


def of_mix_poses():
    others = {name: array[1:] for name, array in poses(4).items()}

    def call(weights, **parts):
        one, other = (tuple(parts[of + name] for name in others) for of in ('', 'other_'))
        return binding.mix_poses(one, other, weights)
    return call, {**poses(3), **{'other_' + name: array for name, array in others.items()},
                  'weights': np.float64([0.1, 0.2, 0.5])}


def of_place_tags():
    wall, tags, random = poses(2, size=10), poses(3), np.random.RandomState(5)

    def call(amounts, own_rotations, centers, spread, **wall):
        return binding.place_tags(tuple(wall.values()), amounts, own_rotations, centers, spread)
    return call, {**wall, 'amounts': random.normal(0, 1, (2, 4)), 'own_rotations': tags['rotations'],
                  'centers': tags['translations'], 'spread': random.normal(0, 0.1, (3, 6, 4))}


def of_off_others():
    return lambda axes, bulge, **parts: binding.off_others(tuple(parts.values()), axes, bulge), {
        **poses(3), 'axes': np.eye(3), 'bulge': 0.1 * np.eye(3)}


def of_add_off():
    random = np.random.RandomState(6)
    return binding.add_off, {'off': random.normal(0, 1, (3, 3)), 'spread': np.tile(np.eye(3), (3, 1, 1)),
                             'memories': np.zeros((3, binding.FLATNESS_SIZE))}


def of_light_wall():
    _, arrays = of_compare_wall()
    return binding.light_wall, {'look': arrays['look'], 'whole': arrays['whole']}


def of_compare_wall():
    random = np.random.RandomState(2)
    look = random.uniform(20, 200, (HEIGHT, WIDTH, 3)).astype(np.float32)

    def call(**arrays):
        return binding.compare_wall(**arrays, darkest=0.3, lightest=2.5)
    return call, {
        'seen': np.clip(look * 1.1, 0, 255).astype(np.uint8), 'look': look, 'whole': np.float32([1, 1.1, 0.9]),
        'contrast': random.randint(0, 50, look.shape).astype(np.uint8),
        'variance': np.full((HEIGHT, WIDTH), 4, np.float32),
        'usable': random.uniform(size=(HEIGHT, WIDTH)) < 0.9}


def of_measure_light():
    _, arrays = of_compare_wall()
    return binding.measure_light, {
        **{key: arrays[key] for key in ('seen', 'look', 'usable')}, 'front': ~arrays['usable'],
        'light': arrays['whole']}


def of_learn_wall():
    call, arrays = of_compare_wall()
    _, planes = call(**arrays)
    wall, size = arrays['usable'], (HEIGHT, WIDTH)

    def learn(**arrays):
        binding.learn_wall(**arrays, passed=0.1, settle=30, rate=0.5, variance_rate=0.1)
    return learn, {
        'seen': arrays['seen'], 'whole': arrays['whole'], 'planes': planes, 'wall': wall, 'certain': wall,
        'look': arrays['look'], 'variance': arrays['variance'], 'known': ~wall,
        'seconds': np.ones(size, np.float32)}


MADE = {made.__name__[3:]: made for made in
        (of_fit_tags, of_compare_tags, of_check_tags, of_sample_cells, of_guess_tags, of_find_quads,
         of_read_tags, of_draw_mask, of_warp_picture, of_find_sides, of_find_room, of_find_box, of_find_convex,
         of_start_motion, of_predict_motion, of_jerk_motion, of_correct_motion, of_find_deviation,
         of_unlikeliness, of_project, of_learn_patches, of_align_patches, of_mix_picture, of_light_picture,
         of_soften_picture, of_find_ways, of_read_rings, of_even_rings, of_draw_cover, of_choose_sources,
         of_find_pose_pairs, of_refine_pose_pairs,
         of_refine_pose_pairs,
         of_find_tag_poses, of_weigh_poses, of_mix_poses, of_place_tags, of_off_others, of_add_off,
         of_measure_light, of_light_wall, of_compare_wall, of_learn_wall)}
OF_TAGS = [name for name in MADE if name.endswith(('_tags', '_cells'))]
# Numbers of any type.
CONVERTED = {'quads', 'others', 'cells', 'words', 'corners', 'to_picture', 'to_area', 'to_tiles', 'shifts',
             'smooth', 'cover', 'to_cover', 'at', 'middles', 'order', 'ways', 'colors', 'before',
             'points', 'places', 'pixels', 'deviation', 'bias', *(
                 argument for made in (of_refine_pose_pairs, of_find_tag_poses, of_weigh_poses, of_mix_poses,
                                       of_place_tags, of_off_others, of_add_off)
                 for argument in made()[1] if argument != 'memories')}
WRITTEN = {('light_picture', 'picture'), ('choose_sources', 'usual'), ('choose_sources', 'to_sources'),
           ('weigh_poses', 'memories'), ('add_off', 'memories'),
           *(('learn_wall', name) for name in ('look', 'variance', 'known', 'seconds')),
           *((name, 'motion') for name in ('start_motion', 'predict_motion', 'jerk_motion', 'correct_motion'))}
GRAY_TOO = {('draw_mask', 'frame'), ('warp_picture', 'mask'), *((name, 'frame') for name in OF_TAGS)}
ARGUMENTS = [(name, argument) for name in MADE for argument in MADE[name]()[1]]


def result_of(name, **changed):
    """What a function returns, and what it has then changed, for its usual arguments but these."""
    call, arrays = MADE[name]()
    arrays = {key: array.copy() for key, array in arrays.items()}
    arrays.update(changed)
    returned = call(**arrays)
    returned = returned if isinstance(returned, tuple) else (returned,)
    return [*returned, *(arrays[key] for of, key in sorted(WRITTEN) if of == name)]


def assert_same(one, other):
    for got, wanted in zip(one, other):
        if wanted is not None:
            np.testing.assert_array_equal(got, wanted)


def strided(array):
    """The same numbers, of which no two are neighbors in memory."""
    wide = np.zeros([2 * side for side in array.shape], array.dtype)
    part = wide[tuple(slice(None, None, 2) for _ in array.shape)]
    part[...] = array
    return part


def unaligned(array):
    memory = np.zeros(array.nbytes + 1, np.uint8)[1:]
    memory[...] = np.frombuffer(array.tobytes(), np.uint8)
    return memory.view(array.dtype).reshape(array.shape)


def upside_down(array):
    """The same numbers, with the last row first in memory."""
    return np.ascontiguousarray(array[::-1])[::-1]


@pytest.mark.parametrize('laid', [strided, unaligned, upside_down, np.asfortranarray])
@pytest.mark.parametrize('name, argument', ARGUMENTS)
def test_an_array_may_lie_in_memory_in_any_way(name, argument, laid):
    array = laid(MADE[name]()[1][argument])
    if (name, argument) in WRITTEN and not (array.flags.c_contiguous and array.flags.aligned):
        with pytest.raises(InputError, match='not contiguous, but it would be changed'):
            result_of(name, **{argument: array})
    else:
        assert_same(result_of(name, **{argument: array}), result_of(name))


@pytest.mark.parametrize('name, argument', ARGUMENTS)
def test_only_what_is_changed_must_not_be_read_only(name, argument):
    array = MADE[name]()[1][argument].copy()
    array.setflags(write=False)
    if (name, argument) in WRITTEN:
        with pytest.raises(InputError, match='is read-only, but it would be changed; give a copy'):
            result_of(name, **{argument: array})
    else:
        assert_same(result_of(name, **{argument: array}), result_of(name))


@pytest.mark.parametrize('name, argument', ARGUMENTS)
def test_an_array_of_another_type_is_refused_or_converted(name, argument):
    array = MADE[name]()[1][argument]
    others = [array.astype(dtype) for dtype in (np.float64, np.uint16, np.int8) if dtype != array.dtype]
    if array.itemsize > 1:
        others.append(array.astype(array.dtype.newbyteorder()))
    for other in others:
        if argument not in CONVERTED:
            message = r'is \(.*\) .*%s; give \(.*\) %s' % (other.dtype, array.dtype)
            with pytest.raises(InputError, match=message):
                result_of(name, **{argument: other})
        elif np.array_equal(other, array):
            assert_same(result_of(name, **{argument: other}), result_of(name))
        else:
            result_of(name, **{argument: other})  # other numbers, but it is the caller who says so


@pytest.mark.parametrize('name, argument', ARGUMENTS)
def test_an_array_of_another_shape_is_refused(name, argument):
    array = MADE[name]()[1][argument]
    others = [array[None], array.ravel() if array.ndim > 1 else array[:2], array[..., :2] if array.ndim > 1 and
              array.shape[-1] > 2 else array[..., :1]]
    if (name, argument) != ('draw_mask', 'frame'):
        others.append(array[..., 0])
    if name not in (*OF_TAGS, 'draw_mask') or argument != 'frame':
        others += [array[:-1], array[:0]]
    if array.ndim > 1 and argument not in ('frame', 'picture', 'spread'):
        others += [array[:, :-1], array[:, :0]]
    for other in others:
        fits = {('draw_mask', 'frame'): other.ndim in (2, 3) and other.shape[:2] == array.shape[:2],
                ('warp_picture', 'picture'): other.ndim == 3 and other.shape[2] == 4 and other.size,
                ('warp_picture', 'mask'): other.shape == array.shape[:2],
                **{(of, 'frame'): other.ndim == 3 and other.shape[2] == 3
                   for of in ('draw_cover', 'choose_sources')},
                ('read_rings', 'frame'): other.ndim == 3 and other.shape[2] == 3 and other.size,
                ('draw_cover', 'cover'): other.ndim == 3 and other.shape[2] == 4 and min(other.shape) > 1,
                ('light_wall', 'look'): other.ndim == 3 and other.shape[2] == 3,
                ('refine_pose_pairs', 'spread'): other.ndim == 3 and other.shape[:2] == array.shape[:2],
                **{(tags, 'frame'): other.ndim == 2 and other.size for tags in OF_TAGS},
                **{(tags, 'quads'): other.shape == (0, 4, 2) for tags in OF_TAGS},
                ('read_tags', 'quads'): other.shape[1:] == (4, 2),
                ('read_tags', 'words'): other.shape[1:] == (4,),
                ('find_sides', 'quads'): other.shape[1:] == (4, 2),
                ('find_box', 'positions'): other.ndim == 3 and other.shape[2] == 2,
                ('find_room', 'quads'): other.shape[1:] == (4, 2),
                ('find_ways', 'quads'): other.shape[1:] == (4, 2),
                ('find_convex', 'quads'): other.shape[-2:] == (4, 2),
                ('project', 'points'): other.shape[-1:] == (2,),
                ('learn_patches', 'points'): other.shape[1:] == (2,),
                **{(name, 'image'): other.ndim == 2 and min(other.shape) >= 8
                   for name in ('learn_patches', 'align_patches')},
                ('find_quads', 'gray'): other.ndim == 2 and other.size,
                ('guess_tags', 'others'): other.shape == (0, 4, 2)}.get((name, argument))
        if fits:
            result_of(name, **{argument: other})
        else:
            with pytest.raises(InputError, match='give '):
                result_of(name, **{argument: other})


@pytest.mark.parametrize('empty', [(0, WIDTH, 3), (HEIGHT, 0, 3), (0, 0, 3), (0, 0)])
def test_a_frame_that_is_empty(empty):
    frame = np.zeros(empty, np.uint8)
    with pytest.raises(InputError, match='frame is'):
        result_of('fit_tags', frame=frame)
    assert binding.draw_mask(frame, CORNERS).shape == empty
    assert warp(np.zeros((5, 5, 3), np.uint8), np.eye(3), frame).shape == (*empty[:2], 3)


@pytest.mark.parametrize('count', [0, -1, 1001])
def test_a_tag_cannot_have_any_number_of_cells(count):
    frame, quads, _ = frame_with_tag()
    for call in (lambda: binding.sample_cells(frame, quads, count, 0),
                 lambda: binding.guess_tags(frame, quads, count, quads, 12)):
        with pytest.raises(InputError, match='cannot be %d cells wide; choose from 1 to 1000' % count):
            call()
    if count > 0:
        with pytest.raises(InputError, match='cannot be %d cells wide' % count):
            binding.fit_tags(frame, quads, np.zeros((1, count, count), np.uint8))


@pytest.mark.parametrize('margin', [4, 9, -1001])
def test_cells_are_sampled_with_a_possible_margin_only(margin):
    frame, quads, _ = frame_with_tag()
    with pytest.raises(InputError, match='without %d cells at its rim; choose less than half' % margin):
        binding.sample_cells(frame, quads, 8, margin)


@pytest.mark.parametrize('samples', [0, 101])
def test_a_cell_is_sampled_at_least_once_and_not_too_often(samples):
    frame, quads, cells = frame_with_tag()
    for call in binding.compare_tags, binding.check_tags:
        with pytest.raises(InputError, match='cannot be sampled %d times; choose from 1 to 100' % samples):
            call(frame, quads, cells, samples)


@pytest.mark.parametrize('window', [1, 4, 17, 5.5])
def test_a_window_is_an_odd_number_of_pixels(window):
    with pytest.raises(InputError, match='cannot be %s pixels wide; give an odd number from 3 to 15' % window):
        binding.find_quads(of_find_quads()[1]['gray'], window, 40)


def test_an_image_that_is_searched_has_an_end():
    with pytest.raises(InputError, match='is 40000 x 1 pixels large; give one of at most 32768 each way'):
        binding.find_quads(np.zeros((1, 40000), np.uint8), 7, 40)


@pytest.mark.parametrize('size', [(1, 1), (1, 300), (300, 1), (2, 3), (9, 8)])
def test_an_image_may_be_tiny(size):
    for gray in np.zeros(size, np.uint8), np.random.RandomState(1).randint(0, 256, size).astype(np.uint8):
        assert len(binding.find_quads(gray, 15, 0)) <= gray.size


def test_there_is_room_for_any_number_of_quadrilaterals():
    """A dark square of 5 pixels in each tile of 8."""
    gray = np.full((480, 640), 200, np.uint8)
    gray.reshape(60, 8, 80, 8)[:, 1:6, :, 1:6] = 30
    assert len(binding.find_quads(gray, 15, 10)) == 60 * 80 > binding.USUAL_QUADS


@pytest.mark.parametrize('size', [(7, 30), (30, 7), (1, 1)])
def test_a_wall_that_is_aligned_is_not_tiny(size):
    with pytest.raises(InputError, match='is %d x %d pixels large; give one of at least 8' % size[::-1]):
        binding.learn_patches(np.zeros(size, np.float32), np.zeros((1, 2)))
    assert not binding.learn_patches(np.zeros((8, 8), np.float32), np.zeros((1, 2))).any()


@pytest.mark.parametrize('level', [-1, 4])
def test_a_wall_is_aligned_in_a_level_that_there_is(level):
    _, arrays = of_align_patches()
    with pytest.raises(InputError, match='has no level %d; choose from 0 to 3' % level):
        binding.align_patches(**arrays, coarsest=level)


@pytest.mark.parametrize('place', [np.nan, np.inf, 1e30, -5])
def test_a_wall_may_be_aligned_anywhere(place):
    _, arrays = of_align_patches()
    result_of('align_patches', places=np.full_like(arrays['places'], place))
    result_of('align_patches', image=np.full_like(arrays['image'], place))
    binding.learn_patches(arrays['image'], np.full((3, 2), place))


@pytest.mark.parametrize('tag, words', [
    ((0, 1, 5), 'size of a tag cannot be 0; choose a whole number from 1 to 8'), ((9, 1, 5), 'size of a tag'),
    ((6, 0, 5), 'border of a tag cannot be 0; choose a whole number from 1 to 10'), ((6, 11, 5), 'border'),
    ((6, 1, -1), 'number of corrected cells cannot be -1; choose a whole number from 0 to 36'),
    ((6, 1, 37), 'number of corrected cells')])
def test_a_tag_that_is_read_has_a_possible_size(tag, words):
    _, arrays = of_read_tags()
    with pytest.raises(InputError, match=words):
        binding.read_tags(*arrays.values(), *tag, 12)


def test_of_no_words_none_is_read():
    frame, quads, _ = frame_with_tag()
    assert binding.read_tags(frame, quads, np.zeros((0, 4)), 6, 1, 5, 12)[0].tolist() == [-1]
    assert binding.read_tags(frame, quads, tag_words('DICT_6X6_250'), 6, 1, 5, 12)[0].tolist() == [3]
    for border in range(1, 11):  # with any border
        binding.read_tags(frame, quads, tag_words('DICT_6X6_250'), 6, border, 5, 12)


@pytest.mark.parametrize('count', [0, 1, 5])
def test_a_measurement_has_four_points_for_each_tag(count):
    arrays = started()
    arrays.update({key: array[:count] for key, array in arrays.items() if key != 'motion'})
    with pytest.raises(InputError, match='has %d points; give four for each tag, of at least one tag' % count):
        binding.unlikeliness(**arrays)


def test_a_measurement_of_any_numbers_is_compared():
    for place, deviation in (np.nan, 0.3), (1e300, 0.3), (0, 0), (0, 1e-300):
        arrays = {**started(), 'bias': np.zeros(8)}
        arrays['pixels'], arrays['deviation'] = np.full((8, 2), place), np.full(8, deviation)
        binding.correct_motion(**arrays, limit=9)
        arrays['motion'][:8] = 0  # an area without a size
        binding.project(arrays['motion'], POINTS)
        binding.correct_motion(**arrays, limit=9)
        binding.predict_motion(arrays['motion'], 0.1, False)


def test_no_tags_are_fitted():
    fitted, found, likeness = binding.fit_tags(frame_with_tag()[0], np.zeros((0, 4, 2)), np.zeros((0, 8, 8)))
    assert fitted.shape == (0, 4, 2) and found.shape == likeness.shape == (0,)


@pytest.mark.parametrize('quad', [np.nan, np.inf, -1e30, 1e30, 0])
def test_a_quadrilateral_may_be_anywhere(quad):
    frame, quads, cells = frame_with_tag()
    assert not binding.fit_tags(frame, np.full_like(quads, quad), cells)[1].any()
    binding.fit_tags(frame, np.where(np.arange(8).reshape(1, 4, 2) == 3, quad, quads), cells)
    binding.read_tags(frame, np.full_like(quads, quad), tag_words('DICT_6X6_250'), 6, 1, 5, 12)
    for name in OF_TAGS:
        result_of(name, quads=np.full_like(quads, quad))
    result_of('guess_tags', others=np.full_like(quads, quad))
    mask = binding.draw_mask(frame, np.full((4, 2), quad, np.float64))
    assert mask.shape == frame.shape
    binding.draw_mask(frame, np.full((4, 2), quad, np.float64), positions())
    binding.draw_mask(frame, CORNERS, np.full_like(positions(), quad))
    result_of('warp_picture', to_picture=np.full((3, 3), quad, np.float64))
    result_of('warp_picture', positions=np.full_like(positions(), quad))


def test_many_points_and_deviations_need_no_large_stack():
    """Four states of a thousand deviations would fill the stack four times over."""
    points, deviations = 8, 600
    found = binding.refine_pose_pairs(np.zeros((1, points, 3)), np.zeros((1, points, 2)),
                                      np.ones((1, points, 2, 2)), np.tile(np.eye(3), (1, 2, 1, 1)),
                                      np.ones((1, 2, 3)), np.zeros((points, 3, deviations)))
    assert found[4].shape == (1, 2, 6 + deviations, 6 + deviations)
    wide = 2_000_000  # a row of it would fill the stack as well
    rows = np.ones((1, wide), np.float32)
    colors, bytes_ = np.ones((1, wide, 3), np.float32), np.ones((1, wide, 3), np.uint8)
    front, _ = binding.compare_wall(bytes_, colors, np.ones(3, np.float32), bytes_, rows, rows > 0, 0.3, 2.5)
    assert not front.any()


def mask_of(frame):
    return area_mask(frame, Area(CORNERS))


def test_the_mask_of_a_gray_frame_is_one_channel_of_that_of_a_color_frame():
    frame = frame_with_tag()[0]
    mask, gray_mask = mask_of(frame), mask_of(np.ascontiguousarray(frame[..., 0]))
    assert gray_mask.shape == (HEIGHT, WIDTH) and gray_mask.dtype == np.uint8
    assert {0, 255} < set(gray_mask.ravel())
    for channel in range(3):
        np.testing.assert_array_equal(mask[..., channel], gray_mask)
    # The same through a lens, which bends here by nothing that can be seen.
    lens = Lens(WIDTH, HEIGHT, np.float64([[60, 0, 30], [0, 60, 23], [0, 0, 1]]), np.full(4, 1e-9))
    bent = area_mask(frame[..., 0], Area(CORNERS, lens=lens))
    assert bent.shape == (HEIGHT, WIDTH) and np.abs(bent.astype(int) - gray_mask).max() <= 40
    np.testing.assert_array_equal(area_mask(frame, Area(CORNERS, lens=lens))[..., 1], bent)


def test_a_gray_mask_warps_as_one_in_color_does():
    picture = np.random.RandomState(0).randint(0, 256, (90, 130, 3)).astype(np.uint8)
    frame, homography = frame_with_tag()[0], Area(CORNERS).homography(130, 90)
    np.testing.assert_array_equal(warp(picture, homography, mask_of(frame[..., 0])),
                                  warp(picture, homography, mask_of(frame)))


@pytest.mark.parametrize('channels', [3, 4])
@pytest.mark.parametrize('width, height', [(1, 1), (1, 5), (5, 1), (2, 2), (3, 2), (17, 9)])
def test_a_picture_is_read_to_its_last_pixel_and_not_further(width, height, channels):
    """That nothing behind it is read, is noticed by the sanitizer."""
    picture = np.random.RandomState(0).randint(0, 256, (height, width, channels)).astype(np.uint8)
    if channels == 4:
        picture[..., 3] = 255
    np.testing.assert_array_equal(warp(picture, np.eye(3), np.full((height, width), 255, np.uint8)), picture)
    beyond = warp(picture, np.eye(3), np.full((height + 9, width + 20), 255, np.uint8))
    np.testing.assert_array_equal(beyond[height:, width:], np.broadcast_to(picture[-1, -1], (9, 20, channels)))


def test_a_mask_has_bytes_only():
    for dtype in np.float32, np.float64, np.uint16:
        with pytest.raises(InputError, match=r'The frame is \(47, 61, 3\) %s; give' % np.dtype(dtype)):
            mask_of(frame_with_tag()[0].astype(dtype))


@pytest.mark.parametrize('frame, message', [
    (np.zeros((HEIGHT, WIDTH), np.uint8), r'frame is \(47, 61\) uint8; give \(h, w, 3\) uint8.*COLOR_GRAY2BGR'),
    (np.zeros((HEIGHT, WIDTH, 4), np.uint8), r'frame is \(47, 61, 4\) uint8'),
    (np.zeros((HEIGHT, WIDTH, 3)), r'frame is \(47, 61, 3\) float64'),
    (np.zeros((0, WIDTH, 3), np.uint8), r'frame is \(0, 61, 3\) uint8'),
    ([[1, 2], [3, 4]], 'frame is no array but a list'),
])
def test_painting_into_what_is_no_color_frame_says_so(frame, message):
    with pytest.raises(InputError, match=message):
        overlay(frame, np.zeros((9, 9, 3), np.uint8), Area(CORNERS))


@pytest.mark.parametrize('picture', [np.zeros((9, 9), np.uint8), np.zeros((9, 9, 3)),
                                     np.zeros((9, 9, 2), np.uint8), np.zeros((0, 9, 3), np.uint8)])
def test_painting_what_is_no_color_picture_says_so(picture):
    with pytest.raises(InputError, match=r'The picture is .*; give \(h, w, 3\) or \(h, w, 4\) uint8'):
        overlay(frame_with_tag()[0], picture, Area(CORNERS))
    with pytest.raises(InputError, match='The picture is '):
        warp(picture, np.eye(3), frame_with_tag()[0])


def test_an_area_is_cut_out_of_gray_frames_too():
    frame = frame_with_tag()[0]
    gray = frame[..., 0]
    np.testing.assert_array_equal(subtract(gray, mask_of(gray)), subtract(frame, mask_of(frame))[..., 0])
    assert subtract(gray, mask_of(gray))[20, 30] == 0 and subtract(gray, mask_of(gray))[45, 55] == gray[45, 55]
    for wrong in mask_of(frame), mask_of(gray)[1:], mask_of(gray).astype(float):
        with pytest.raises(InputError, match='The mask is '):
            subtract(gray, wrong)


def test_put_in_takes_three_images_of_one_size_and_a_frame_that_can_be_changed():
    frame = frame_with_tag()[0]
    good = frame.copy(), frame.copy(), frame.copy()
    put_in(*good)
    for which, name in enumerate(('frame', 'picture', 'mask')):
        for wrong in frame[..., 0], frame[:-1], frame.astype(np.float32):
            images = list(good)
            images[which] = wrong
            with pytest.raises(InputError, match='The (%s|picture) is' % name):
                put_in(*images)
    frame.setflags(write=False)
    with pytest.raises(InputError, match='The frame is read-only'):
        put_in(frame, *good[1:])
    with pytest.raises(InputError, match='The array for the result is read-only'):
        overlay(frame, good[1], Area(CORNERS), out=frame)


@pytest.mark.parametrize('size', [(WIDTH - 5, HEIGHT), (WIDTH, HEIGHT - 1), (WIDTH + 1, HEIGHT)])
def test_a_lens_of_another_size_is_named(size):
    frame = frame_with_tag()[0]
    area = Area(CORNERS, lens=Lens(*size, np.float64([[60, 0, 30], [0, 60, 23], [0, 0, 1]]), np.full(4, 1e-3)))
    message = 'The frame has 61 x 47 pixels, but the lens is that of %d x %d. Calibrate' % size
    for call in (lambda: area_mask(frame, area), lambda: area_mask(frame[..., 0], area),
                 lambda: overlay(frame, np.zeros((9, 9, 3), np.uint8), area), lambda: area.window(frame),
                 lambda: area.rectified(frame, (20, 20))):
        with pytest.raises(InputError, match=message):
            call()


def test_tags_are_searched_in_gray_and_color_alike():
    gray = cv2.copyMakeBorder(draw_tag('DICT_6X6_250', 7, 80), 30, 30, 30, 30, 0, value=255)
    for frame in gray, np.dstack([gray] * 3), strided(np.dstack([gray] * 3)), upside_down(gray):
        tag, = Detector().detect(frame)
        assert tag.id == 7 and np.abs(tag.corners - [[29.5, 29.5], [109.5, 29.5], [109.5, 109.5],
                                                     [29.5, 109.5]]).max() < 0.2
    for frame in gray.astype(np.float32), gray[:0], gray[None, None], gray[..., None]:
        with pytest.raises(InputError, match=r'The frame is .*; give \(h, w\) or \(h, w, 3\) uint8'):
            Detector().detect(frame)


def sanitizer():
    """The path of the library that the compiler's address sanitizer needs, or None."""
    if shutil.which('cc') is None:
        return None
    asked = subprocess.run(['cc', '-print-file-name=libasan.so'], stdout=subprocess.PIPE, text=True)
    return asked.stdout.strip() if os.path.isabs(asked.stdout) else None  # else it only repeats the name


CHECKED = 'CHECKED_BY_SANITIZER'
# It is really that library, and it notices a mask that is one row too short, past our checks.
TOO_SHORT = '''
import numpy
from aruco_ar.compiled import binding
mask, corners = numpy.zeros((46, 61), numpy.uint8), numpy.float64([[0, 0], [60, 0], [60, 60], [0, 60]])
image = binding._image(mask)
image.height = 47
binding._draw_mask(image, corners, None, 0)
'''


@pytest.mark.long
@pytest.mark.skipif(CHECKED in os.environ, reason='this is that run')
def test_no_function_reads_or_writes_beyond_its_arrays(tmp_path):
    if sanitizer() is None:
        pytest.skip('the compiler has no address sanitizer')
    compile_to(str(tmp_path / 'libunit5.so'), '-fsanitize=address', '-g', '-O1')
    environment = {**os.environ, CHECKED: '1', 'LD_PRELOAD': sanitizer(),
                   'LD_LIBRARY_PATH': '%s:%s' % (tmp_path, os.environ.get('LD_LIBRARY_PATH', '')),
                   'ASAN_OPTIONS': 'detect_leaks=0'}

    def run(*arguments):
        done = subprocess.run([sys.executable, *arguments], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout
    if run('-c', 'import cv2, numpy')[0]:
        pytest.skip('NumPy and OpenCV cannot be imported beside the address sanitizer')
    code, output = run('-c', TOO_SHORT)
    assert code and 'AddressSanitizer: heap-buffer-overflow' in output, output
    code, output = run('-m', 'pytest', '-q', '-s', '-p', 'no:cacheprovider', '--basetemp',
                       str(tmp_path / 'tests'), __file__)
    assert code == 0 and ' passed' in output, output[-5000:]


def weights_of_neighbors(length, count):
    """(length, count): how much each of ``count`` values counts at ``length`` places, four to a value."""
    places = np.clip((np.arange(length) + 0.5) / 4 - 0.5, 0, count - 1)
    return np.maximum(1 - np.abs(places[:, None] - np.arange(count)), 0)


@pytest.mark.parametrize('channels', [3, 4])
@pytest.mark.parametrize('width, height', [(1, 1), (2, 9), (9, 2), (4, 4), (50, 39)])
def test_light_is_interpolated_and_alpha_and_what_is_not_shown_stay_as_they_are(width, height, channels):
    random = np.random.RandomState(2)
    before = random.randint(0, 256, (height, width, channels)).astype(np.uint8)
    coarse = random.randint(0, 256, (-(-height // 4), -(-width // 4), 3)).astype(np.float32)
    mask = np.zeros((height, width, 3), np.uint8)
    mask[height // 4:max(height // 2, 1), width // 3:] = 90
    picture, shown = before.copy(), mask[..., 0] > 0
    binding.light_picture(picture, mask, coarse.astype(np.uint8), 0.2)
    down, across = (weights_of_neighbors(*lengths) for lengths in zip((height, width), coarse.shape))
    light = np.einsum('yj,xi,jic->yxc', down, across, coarse)
    expected = (0.2 * 255 + 0.8 * before[..., :3]) * light / 255
    assert shown.any() and np.abs(picture[..., :3] - expected)[shown].max() < 1.6  # three numbers are rounded
    np.testing.assert_array_equal(picture[..., 3:], before[..., 3:])
    np.testing.assert_array_equal(picture[~shown], before[~shown])


@pytest.mark.parametrize('across, down', [(0, 0), (1.1, 0.8), (0, 4), (5, 0)])
@pytest.mark.parametrize('width, height', [(1, 1), (1, 9), (9, 2), (140, 90)])
def test_a_picture_is_softened_as_by_a_normal_distribution(width, height, across, down):
    picture = np.random.RandomState(2).randint(0, 256, (height, width, 3)).astype(np.uint8)
    mask = np.zeros_like(picture)
    mask[height // 4:max(height // 2, 1), width // 3:] = 255
    mask[0, -1] = 90
    softened, share = binding.soften_picture(picture, mask, across, down)
    size = tuple(2 * int(3 * deviation + 0.5) + 1 for deviation in (across, down))
    wanted_share, inside = (cv2.GaussianBlur(image, size, max(across, 0.01), sigmaY=max(down, 0.01))
                            for image in (mask / 255.0, picture * (mask / 255.0)))
    assert np.abs(share / 255.0 - wanted_share).max() < 1 / 255
    assert np.abs(softened * (share / 255.0) - inside).max() < 1.6  # four numbers are rounded


@pytest.mark.parametrize('deviation', [-1, np.nan, np.inf, 1001])
def test_a_picture_is_softened_by_a_possible_deviation(deviation):
    _, arrays = of_soften_picture()
    for both in (deviation, 1), (1, deviation):
        with pytest.raises(InputError, match='cannot be blurred by .* pixels; choose from 0 to 1000'):
            binding.soften_picture(*arrays.values(), *both)
