"""Frames without tags: simulated walls, things with corners and cells, and real clips, their tags painted over.

Each frame is made from its number alone, so that any part of them can be looked at again, in any process.
"""
import os
from functools import lru_cache
from math import radians

import cv2
import numpy as np
from aruco_ar import load_picture
from aruco_ar.simulation.figures import VISITORS
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.simulation.textures import as_printed
from aruco_ar.tags.tag import draw_tag, get_dictionary
from aruco_ar.walls.wall import Poster, Wall
from rig import PACKAGE

from benchmark.real_clips.truth import tags_of

EARTH = os.path.join(PACKAGE, 'images', 'earth.jpg')
SIZE = 640, 480
VIEWS = 20         # of a simulated wall: to render one takes less than to make one
GROWN = 1.3        # a tag is painted over with a part of its margin: so many times its side
LONGER_PX = 960    # the longer side of a clip's frame, at most
TAGS, TAG_PX, TAG_SIDES_PX = 6, 160, (12, 150)  # in a frame with tags: how many at most, and of which size
VARIANTS = 16      # of each frame of a clip


def wall_frame(number):
    """(480, 640, 3) BGR uint8: a simulated wall with posters, and perhaps somebody, as a robot sees it.

    VIEWS frames in a row show the same wall, from elsewhere.
    """
    random, renderer = np.random.RandomState(number), _renderer(number // VIEWS)
    pose = Pose(random.uniform(-4, -0.8), random.uniform(-1, 1), radians(random.uniform(-30, 30)))
    visitor, seconds = random.choice(VISITORS), random.uniform(0, 20)
    return _as_filmed(renderer.render(*wall_to_camera(pose), visitor=visitor, seconds=seconds), random)


@lru_cache(maxsize=1)
def _renderer(number):
    random = np.random.RandomState(number)
    posters = tuple(Poster(EARTH, random.uniform(-1.5, 1.5), random.uniform(0.3, 1.4),
                           random.uniform(0.1, 1.2), random.uniform(0.1, 1.0))
                    for _ in range(random.randint(0, 7)))
    color = tuple(int(level) for level in random.randint(20, 256, 3))
    wall = Wall(random.uniform(2, 8), random.uniform(1.5, 3), color, 'DICT_6X6_250', 1, (), (),
                random.uniform(0, 8), posters)
    return WallRenderer(wall, Camera(), light=random.uniform(0, 0.8), seed=number)


def thing_frame(number):
    """(480, 640, 3) BGR uint8: framed pictures, chessboards, windows, keyboards, QR codes, text, and dots.

    They lie about at random, in perspective, on a texture or on a photo, in good and in bad pictures.
    """
    random = np.random.RandomState(number)
    return _as_filmed(_things(random), random)


def tag_frame(number, dictionary):
    """A frame as those of thing_frame with tags among the things, and its tags: {id: (4, 2) pixels}."""
    random = np.random.RandomState(number)
    frame, tags = _things(random), {}
    ids = random.choice(len(get_dictionary(dictionary).bytesList), TAGS, replace=False)
    for tag_id in ids.tolist():
        corners = _somewhere(random, *TAG_SIDES_PX)
        middle, reach = corners.mean(axis=0), np.ptp(corners, axis=0).max()
        if any(np.linalg.norm(middle - other.mean(axis=0)) < reach + np.ptp(other, axis=0).max()
               for other in tags.values()):
            continue
        quiet = random.uniform(0.5, 1.5)
        picture = draw_tag(dictionary, tag_id, TAG_PX, quiet=quiet)
        within = TAG_PX / len(picture)
        _put(frame, cv2.cvtColor(np.uint8(as_printed(picture)), cv2.COLOR_GRAY2BGR), corners)
        corners_of_tag = np.float64([[1 - within, 1 - within], [1 + within, 1 - within],
                                     [1 + within, 1 + within], [1 - within, 1 + within]]) / 2
        square = np.float32([[0, 0], [1, 0], [1, 1], [0, 1]])
        to_frame = cv2.getPerspectiveTransform(square, np.float32(corners))
        tags[tag_id] = cv2.perspectiveTransform(corners_of_tag[None], to_frame)[0]
    return _as_filmed(frame, random), tags


def _things(random):
    frame = _texture(random, *SIZE) if random.rand() < 0.6 else _part_of_photo(random, *SIZE)
    for _ in range(random.randint(4, 25)):
        _put(frame, random.choice(THINGS)(random), _somewhere(random, 15, 200))
    return frame


def _somewhere(random, shortest, longest):
    """(4, 2) pixels: the corners of something of about that size, turned and in perspective, in the frame."""
    side = np.exp(random.uniform(np.log(shortest), np.log(longest)))
    middle, turn = random.uniform(0, SIZE), random.uniform(0, 2 * np.pi)
    square = side / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * random.uniform(0.6, 1, 2)
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return middle + square @ spin.T + random.uniform(-0.12, 0.12, (4, 2)) * side


def _put(frame, thing, corners):
    """Draw an image, (h, w, 3), into a quadrilateral, (4, 2) pixels, of a frame."""
    first = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    last = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, SIZE)
    if (last <= first).any():
        return
    size = tuple((last - first).tolist())
    height, width = thing.shape[:2]
    to_frame = cv2.getPerspectiveTransform(np.float32([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5,
                                           np.float32(corners - first))
    shrinks = int(min(width, height) / np.ptp(corners, axis=0).max())
    if shrinks > 1:
        thing = cv2.blur(thing, (shrinks, shrinks))
    part = frame[first[1]:last[1], first[0]:last[0]]
    seen = cv2.warpPerspective(thing, to_frame, size)
    share = cv2.warpPerspective(np.ones(thing.shape[:2], np.float32), to_frame, size)[:, :, None]
    part[:] = np.uint8(share * seen + (1 - share) * part)


def _as_filmed(frame, random):
    """The frame with the faults of a camera: soft, smeared, noisy, dark or pale, and compressed."""
    if random.rand() < 0.5:
        frame = cv2.GaussianBlur(frame, (0, 0), random.uniform(0.4, 2.5))
    if random.rand() < 0.2:
        frame = cv2.blur(frame, (int(random.randint(2, 20)), 1))
    frame = cv2.convertScaleAbs(frame, alpha=random.uniform(0.15, 1.3), beta=random.uniform(0, 40))
    if random.rand() < 0.6:
        cv2.setRNGSeed(int(random.randint(1 << 30)))
        noise = cv2.randn(np.empty(frame.shape, np.int16), (0,) * 3, (random.uniform(1, 10),) * 3)
        frame = cv2.add(frame, noise, dtype=cv2.CV_8U)
    if random.rand() < 0.4:
        packed = cv2.imencode('.jpg', frame, [cv2.IMWRITE_JPEG_QUALITY, int(random.randint(15, 95))])[1]
        frame = cv2.imdecode(packed, cv2.IMREAD_COLOR)
    return frame


def _texture(random, width, height):
    """(height, width, 3): noise, coarse and fine, in one color."""
    gray = np.zeros((height, width))
    for grain in 2 ** random.uniform(0, 7, 3):
        coarse = random.normal(0, random.uniform(0, 40),
                               (int(height / grain) + 2, int(width / grain) + 2))
        sharp = random.choice([cv2.INTER_NEAREST, cv2.INTER_CUBIC])
        gray += cv2.resize(coarse, (width, height), interpolation=int(sharp))
    return np.uint8(np.clip(random.uniform(20, 236, 3) + gray[:, :, None], 0, 255))


@lru_cache(maxsize=1)
def _photo():
    return load_picture(EARTH)[:, :, :3]


def _part_of_photo(random, width, height):
    photo = _photo()
    part = int(random.uniform(0.1, 1) * min(photo.shape[:2]))
    top, left = random.randint(0, photo.shape[0] - part + 1), random.randint(0, photo.shape[1] - part + 1)
    return cv2.resize(photo[top:top + part, left:left + part], (width, height), interpolation=cv2.INTER_AREA)


def _framed(random):
    """A picture or a texture in a dark or a pale frame, with or without a mat."""
    inside = random.choice([_texture, _part_of_photo])(random, 80, 80)
    for _ in range(random.randint(1, 3)):
        width = int(random.randint(4, 25))
        inside = cv2.copyMakeBorder(inside, *[width] * 4, cv2.BORDER_CONSTANT,
                                    value=[float(random.choice([0, 15, 60, 200, 250]))] * 3)
    return inside


def _chessboard(random):
    rows, columns = random.randint(2, 12, 2)
    cells = np.add.outer(np.arange(rows), np.arange(columns)) % 2
    return _of_cells(cells * 200 + 30)


def _window(random):
    """Panes with bars between them."""
    pane = np.pad(_texture(random, 24, 30) // 3, [(3, 3), (3, 3), (0, 0)],
                  constant_values=int(random.randint(120, 255)))
    return np.tile(pane, (random.randint(1, 5), random.randint(1, 5), 1))


def _keyboard(random):
    """Dark keys with white letters, or the reverse."""
    keys = []
    for _ in range(20):
        key = np.full((40, 40, 3), 20, np.uint8)
        cv2.putText(key, chr(random.randint(48, 91)), (8, 32), random.randint(0, 5), random.uniform(0.8, 1.3),
                    (240,) * 3, int(random.randint(1, 5)), cv2.LINE_AA)
        keys.append(np.pad(key, [(4, 4), (4, 4), (0, 0)], constant_values=200))
    board = np.vstack([np.hstack(keys[first:first + 5]) for first in range(0, 20, 5)])
    return 255 - board if random.rand() < 0.3 else board


def _qr_code(random):
    text = ''.join(chr(code) for code in random.randint(65, 91, random.randint(3, 40)))
    return _of_cells(np.pad(cv2.QRCodeEncoder.create().encode(text), 2, constant_values=255))


def _text(random):
    page = np.full((120, 160, 3), 245, np.uint8)
    for row in range(10):
        text = ''.join(chr(code) for code in random.randint(33, 127, 14))
        cv2.putText(page, text, (5, 12 * row + 10), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (20,) * 3, 1, cv2.LINE_AA)
    return page


def _dots(random):
    """Random cells without a border, a dithered or a mosaic surface."""
    return _of_cells(random.choice([20, 235], (random.randint(3, 16), random.randint(3, 16))))


def _stripes(random):
    return _of_cells(np.tile(random.choice([20, 235], random.randint(4, 40)), (4, 1)))


def _of_cells(gray):
    return cv2.cvtColor(np.uint8(gray).repeat(12, 0).repeat(12, 1), cv2.COLOR_GRAY2BGR)


THINGS = (_framed, _framed, _framed, _chessboard, _window, _keyboard, _qr_code, _text, _dots, _stripes)


class PaintedOver:
    """The frames of a Clip of which it is known where all tags are, with these painted over, in VARIANTS."""

    def __init__(self, clip):
        frames, _ = clip.frames()
        frames = [cv2.resize(frame, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
                  for frame in frames for scale in [min(1, LONGER_PX / max(frame.shape[:2]))]]
        tags = tags_of(frames, clip.dictionary, clip.all_ids)
        self._known = [(frame, quads) for frame, quads in zip(frames, tags) if quads]

    def __len__(self):
        return VARIANTS * len(self._known)

    def frame(self, number):
        """(h, w, 3) BGR uint8: turned, mirrored, negated, and as filmed by another camera, by its number."""
        place, variant = divmod(number, VARIANTS)
        random = np.random.RandomState(number)
        frame, tags = self._known[place]
        frame = frame.copy()
        for look in _color_around, _part_of_frame:
            for quad in tags.values():
                _paint_over(frame, quad, look, random)
        frame = np.rot90(frame, variant % 4)
        if variant & 4:
            frame = frame[:, ::-1]
        frame = np.ascontiguousarray(255 - frame if variant & 8 else frame)
        return frame if variant == 0 else _as_filmed(frame, random)


def _paint_over(frame, quad, look, random):
    """Fill a tag, (4, 2) pixels, and a part of its margin. ``look``: a function of frame, part, and random."""
    grown = quad.mean(axis=0) + GROWN * (quad - quad.mean(axis=0))
    low = np.maximum(np.floor(grown.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(grown.max(axis=0)).astype(int) + 1, frame.shape[1::-1])
    if (high - low < 2).any():
        return
    part = frame[low[1]:high[1], low[0]:high[0]]
    is_tag = np.zeros(part.shape[:2], np.uint8)
    cv2.fillConvexPoly(is_tag, np.int32(np.round(grown - low)), 1)
    part[is_tag > 0] = look(frame, part, random)[is_tag > 0]


def _color_around(_frame, part, random):
    """A dark, a medium, or a light color of a part of a frame."""
    color = np.percentile(part.reshape(-1, 3), random.choice([15, 50, 85]), axis=0)
    return np.broadcast_to(np.uint8(color), part.shape)


def _part_of_frame(frame, part, random):
    """Now and then another part of the frame, else the same."""
    if random.rand() > 0.3:
        return part
    top, left = (random.randint(0, whole - length + 1) for whole, length in zip(frame.shape, part.shape[:2]))
    return frame[top:top + part.shape[0], left:left + part.shape[1]].copy()
