"""Hostile pictures, with tags or without.

Each kind is a function that paints on a gray canvas, (h, w) uint8. It gets
a RandomState and the name of a tag dictionary.
"""
from functools import lru_cache

import cv2
import numpy as np
from aruco_ar import draw_tag, get_dictionary
from aruco_ar.tags.tag import tag_cells

DICTIONARIES = 'DICT_6X6_250', 'DICT_4X4_50', 'DICT_5X5_1000', 'DICT_ARUCO_ORIGINAL', 'DICT_APRILTAG_36h11'
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
# The focal length of the usual lens, in widths of the picture; the four tags' sides, in sides of the area.
FOCAL, FOUR_SIDE = 0.9, 0.25
MAX_CELL_PX = 8   # of the picture of a tag before it is warped


@lru_cache(maxsize=2000)
def _face(dictionary, tag_id, cell):
    """A picture of a tag with ``cell`` pixels per cell, and a white margin of one cell."""
    return draw_tag(dictionary, tag_id, cell * len(tag_cells(dictionary, tag_id)), quiet=1)


def _any_id(random, dictionary):
    return int(random.randint(len(get_dictionary(dictionary).bytesList)))


def turned_square(random, center, side, turn=None, slant=0.0, focal=None):
    """(4, 2): a square of that side, rotated, and slanted by an angle in radians about a random axis."""
    turn, axis = random.uniform(0, 2 * np.pi, 2) if turn is None else (turn, random.uniform(0, 2 * np.pi))
    corners = side * SQUARE @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    along = np.array([np.cos(axis), np.sin(axis)])
    depth = corners @ along
    flat = corners + np.outer(depth * (np.cos(slant) - 1), along)
    return flat / (1 + np.sin(slant) * depth / (focal or 2.5 * side))[:, None] + center


def put(canvas, dictionary, tag_id, quad):
    """Paint a tag with a white margin of one cell, so that its corners are at ``quad``, (4, 2) pixels."""
    quad = np.float32(quad)
    count = len(tag_cells(dictionary, tag_id))
    side = np.sqrt(max(cv2.contourArea(quad), 1.0))
    cell = int(np.clip(round(side / count), 1, MAX_CELL_PX))
    face = _face(dictionary, tag_id, cell)
    inner = cell * np.float32([[1, 1], [count + 1, 1], [count + 1, count + 1], [1, count + 1]]) - 0.5
    homography = cv2.getPerspectiveTransform(inner, quad)
    reach = 2 * (quad.max(axis=0) - quad.min(axis=0)) / count + 2
    low = np.maximum(np.floor(quad.min(axis=0) - reach), 0).astype(int)
    high = np.minimum(np.ceil(quad.max(axis=0) + reach), canvas.shape[::-1]).astype(int)
    if np.all(low < high):
        part = np.ascontiguousarray(canvas[low[1]:high[1], low[0]:high[0]])
        shift = np.array([[1, 0, -low[0]], [0, 1, -low[1]], [0, 0, 1.0]])
        cv2.warpPerspective(face, shift @ homography, part.shape[::-1], part, cv2.INTER_LINEAR,
                            cv2.BORDER_TRANSPARENT)
        canvas[low[1]:high[1], low[0]:high[0]] = part


def _side(canvas, random, least=0.1, most=0.35):
    return max(min(canvas.shape) * random.uniform(least, most), 1.0)


def any_place(canvas, random, beyond=0.0):
    size = np.array(canvas.shape[::-1])
    return random.uniform(-beyond * size, (1 + beyond) * size)


def _scatter(canvas, random, dictionary, count, tag_id=None, beyond=0.0, slant=0.0, sides=(0.1, 0.35)):
    for _ in range(count):
        quad = turned_square(random, any_place(canvas, random, beyond), _side(canvas, random, *sides), None,
                             random.uniform(-slant, slant))
        put(canvas, dictionary, _any_id(random, dictionary) if tag_id is None else tag_id, quad)


def four(canvas, random, dictionary):
    """Four good tags that span an area, from a random viewpoint, and sometimes more tags."""
    size = np.array(canvas.shape[::-1])
    slant, turn = random.uniform(-1.0, 1.0), random.choice([0.0, random.uniform(0, 2 * np.pi)])
    corners = turned_square(random, (size - 1) / 2, 0.7 * min(size), turn, slant, FOCAL * size[0])
    wall = cv2.getPerspectiveTransform(np.float32(SQUARE), np.float32(corners))
    side = random.choice([FOUR_SIDE, random.uniform(0.15, 0.4)])
    places = list(SQUARE * 0.9) + list(random.uniform(-0.6, 0.6, (random.choice([0, 0, 1, 4]), 2)))
    for number, place in enumerate(places):
        quad = (SQUARE * side + place)[None].astype(np.float32)
        put(canvas, dictionary, number % 50, cv2.perspectiveTransform(quad, wall)[0])


def overlapping(canvas, random, dictionary):
    _scatter(canvas, random, dictionary, random.randint(5, 16))


def mirrored(canvas, random, dictionary):
    four(canvas, random, dictionary)
    half = max(canvas.shape[1] // 2, 1)
    part = canvas if random.rand() < 0.5 else canvas[:, :half]
    part[:] = cv2.flip(part, int(random.randint(2)))


def cut(canvas, random, dictionary):
    _scatter(canvas, random, dictionary, random.randint(4, 9), beyond=0.1, sides=(0.2, 0.7))
    for _ in range(4):  # and exactly at the edge
        side = int(_side(canvas, random)) + 1
        x = random.choice([0, 1, canvas.shape[1] - side, canvas.shape[1] - side - 1])
        quad = side * (SQUARE + 0.5) + [x, random.randint(canvas.shape[0])]
        put(canvas, dictionary, _any_id(random, dictionary), quad)


def one_id(canvas, random, dictionary):
    _scatter(canvas, random, dictionary, random.randint(4, 12), tag_id=7, sides=(0.1, 0.2))


def hundreds(canvas, random, dictionary):
    """As many tags as there is room for, in rows, each slightly rotated."""
    step = random.uniform(2.0, 3.5) * len(tag_cells(dictionary, 0))
    tag_id = _any_id(random, dictionary)
    for y in np.arange(step / 2, canvas.shape[0], step):
        for x in np.arange(step / 2, canvas.shape[1], step):
            quad = turned_square(random, (x, y), 0.7 * step, random.uniform(-0.1, 0.1))
            put(canvas, dictionary, tag_id, quad)
            tag_id = (tag_id + 1) % len(get_dictionary(dictionary).bytesList)


def ring(canvas, random, dictionary):
    """Tags on a circle, so that all of them are on the convex hull."""
    radius, count = 0.42 * min(canvas.shape), random.randint(4, 40)
    for angle in np.linspace(0, 2 * np.pi, count, endpoint=False):
        center = np.array(canvas.shape[::-1]) / 2 + radius * np.array([np.cos(angle), np.sin(angle)])
        quad = turned_square(random, center, 4.0 * radius / count + 8)
        put(canvas, dictionary, _any_id(random, dictionary), quad)


def in_line(canvas, random, dictionary):
    """Tags whose centers are on one line, to within a few pixels."""
    start, end = any_place(canvas, random), any_place(canvas, random)
    for number, along in enumerate(np.linspace(0, 1, random.randint(4, 7))):
        center = start + along * (end - start) + random.normal(0, random.choice([0, 0.5, 3]), 2)
        put(canvas, dictionary, number, turned_square(random, center, _side(canvas, random, 0.1, 0.2)))


def nested(canvas, random, dictionary):
    """Four stacks of tags inside of tags."""
    for _ in range(4):
        side, center = _side(canvas, random, 0.3, 0.9), any_place(canvas, random)
        while side > 8:
            put(canvas, dictionary, _any_id(random, dictionary), turned_square(random, center, side))
            center, side = center + side * random.uniform(-0.2, 0.2, 2), side * random.uniform(0.2, 0.5)


def slanted(canvas, random, dictionary):
    _scatter(canvas, random, dictionary, random.randint(4, 9), slant=1.5, sides=(0.3, 0.7))


def tiny(canvas, random, dictionary):
    for _ in range(30):
        side, slant = random.uniform(3, 14), random.uniform(-0.5, 0.5)
        quad = turned_square(random, any_place(canvas, random), side, None, slant)
        put(canvas, dictionary, _any_id(random, dictionary), quad)


def huge(canvas, random, dictionary):
    """One tag up to 3000 px wide, of which the picture shows a part, or all and a little more."""
    side = random.uniform(0.7, 1.2) * min(canvas.shape) if random.rand() < 0.5 else random.uniform(300, 3000)
    put(canvas, dictionary, _any_id(random, dictionary),
        turned_square(random, any_place(canvas, random) if side > max(canvas.shape) else
                      np.array(canvas.shape[::-1]) / 2, side, None, random.uniform(-1, 1)))


def quads(canvas, random, dictionary):
    """Black quadrilaterals of any shape; into some a tag is stretched, perhaps mirrored."""
    for _ in range(12):
        corners = any_place(canvas, random) + random.uniform(-1, 1, (4, 2)) * _side(canvas, random, 0.1, 0.5)
        if random.rand() < 0.5:
            cv2.fillPoly(canvas, [np.int32(corners)], 0)
        else:
            put(canvas, dictionary, _any_id(random, dictionary), corners)


def noise(canvas, random, dictionary):
    grain = random.randint(1, 9)
    small = random.randint(0, 256, [-(-side // grain) for side in canvas.shape]).astype(np.uint8)
    between = int(random.choice([cv2.INTER_NEAREST, cv2.INTER_LINEAR]))
    canvas[:] = cv2.resize(small, canvas.shape[::-1], interpolation=between)


def false_tags(canvas, random, dictionary):
    """Black frames with random cells, some of which read as tags after error correction."""
    count = len(tag_cells(dictionary, 0))
    step = count * random.randint(3, 6)
    for y in range(2, canvas.shape[0] - step, step + 6):
        for x in range(2, canvas.shape[1] - step, step + 6):
            cells = np.pad(random.choice([0, 255], (count - 2, count - 2)), 1).astype(np.uint8)
            canvas[y:y + step, x:x + step] = cv2.resize(cells, (step, step), interpolation=cv2.INTER_NEAREST)


def text(canvas, random, dictionary):
    for _ in range(30):
        x, y = (int(part) for part in any_place(canvas, random, 0.1))
        cv2.putText(canvas, ''.join(map(chr, random.randint(33, 127, 8))), (x, y), int(random.randint(5)),
                    random.uniform(0.3, 1.5), int(random.randint(256)), int(random.randint(1, 4)))


def checkerboard(canvas, random, dictionary):
    side, turn = random.uniform(1, 40), random.uniform(0, 1.6)
    y, x = np.indices(canvas.shape)
    across, down = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    canvas[:] = np.uint8((across // side + down // side) % 2 * 255)


def gradient(canvas, random, dictionary):
    y, x = np.indices(canvas.shape)
    slope = random.uniform(-3, 3, 2)
    canvas[:] = np.uint8((x * slope[0] + y * slope[1]) % random.choice([256, 64, 1000]) % 256)


def plain(canvas, random, dictionary):
    canvas[:] = random.choice([0, 255, random.randint(256)])


def frames(canvas, random, dictionary):
    """Nested rectangles with lines of one pixel."""
    step = random.randint(1, 6)
    for inset in range(0, min(canvas.shape) // 2, step):
        cv2.rectangle(canvas, (inset, inset), (canvas.shape[1] - 1 - inset, canvas.shape[0] - 1 - inset),
                      int(inset // step % 2 * 255), 1)


KINDS = {kind.__name__: kind for kind in (
    four, overlapping, mirrored, cut, one_id, hundreds, ring, in_line, nested, slanted, tiny, huge, quads,
    noise, false_tags, text, checkerboard, gradient, plain, frames)}
MIXED = 'mixed'          # several kinds in one picture
ODD = 'odd'              # a picture with an odd size
NAMES = (*KINDS, MIXED, ODD)
SHARES = np.array([6.0 if name == 'four' else 0.4 if name == 'hundreds' else 1.0 for name in NAMES])


def canvas_of(kind, random, dictionary, size):
    """A canvas, (h, w) uint8, of a kind, and about this size, (width, height) pixels."""
    if kind == ODD:
        sides = 1, 2, 3, 7, 8, 9, 31, 97, 255, 501
        size = tuple(int(side) for side in random.choice(sides, 2))
    elif kind == 'hundreds':
        size = min(2 * size[0], 640), min(2 * size[1], 480)
    canvas = np.full(size[::-1], random.randint(120, 256), np.uint8)
    mixed = random.choice(list(KINDS), random.randint(2, 4)) if kind in (MIXED, ODD) else [kind]
    for name in mixed:
        some = canvas
        if kind == MIXED:  # in a random place
            x, y = (random.randint(side // 2) for side in size)
            some = canvas[y:y + size[1] // 2, x:x + size[0] // 2]
        own = np.ascontiguousarray(some)
        KINDS[name](own, random, dictionary)
        some[:] = own
    return canvas
