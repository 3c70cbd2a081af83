"""Rendering the wall as a camera sees it, and the true positions of its points in the frame."""
from __future__ import annotations

from typing import Collection

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Extrinsics, Floats, Image, Integers
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.homography import transform
from aruco_ar.painting.picture_file import load_picture
from aruco_ar.painting.pixels import blend
from aruco_ar.walls.wall import Wall

from .figures import NOBODY, draw_visitor
from .robot import Camera, view_between
from .textures import WALL_TEXELS_M, Textures, as_printed

NEAR_M = 0.05         # things nearer to the camera than this are not visible
SAMPLES = 3           # number of samples of a tag, per pixel and direction
POSTER_SAMPLES = 2    # number of samples of a poster, per pixel and direction
ROOM_COLOR = (205, 200, 196)
FLOOR_COLOR = (92, 104, 116)
FLOOR = np.array([[-20.0, 0, 0], [20, 0, 0], [20, 0, 20], [-20, 0, 20]])  # wall meters
CARD = [-0.75, 0.75, 0.75, -0.75], [-0.75, -0.75, 0.75, 0.75]  # corners of a card over a tag, in tag sides
CARD_COLOR = (120, 128, 134)
FAR_PX = 1e6          # positions farther out are clipped
# The row in which a point is seen depends on its position, which depends on the row. So both are iterated.
ROW_ITERATIONS = 5
MAX_BLIND = 0.1       # share of a frame's pixels that may see nothing through the lens
NOISE_FIELD_MARGIN = 192  # the noise of a frame is a random window of a larger field


def project(points: Floats, rotation: Floats, translation: Floats, camera: Camera) -> tuple[Floats, bool]:
    """The pixels, (n, 2) float64, of wall points, (n, 3), and whether all are in front of the camera."""
    seen = points @ rotation.T + translation
    in_front = bool(np.all(seen[:, 2] > NEAR_M))
    return camera.lens.project_rays(seen[:, :2] / np.maximum(seen[:, 2:], NEAR_M))[0], in_front


def project_rows(points: Floats, first: Extrinsics, last: Extrinsics, camera: Camera) -> tuple[Floats, bool]:
    """The same as ``project`` for a rolling shutter: the rows are read one after the other.

    ``first`` and ``last``: the views when the first and when the last row is read.
    """
    pixels, in_front = project(points, *first, camera)
    if not in_front or all(np.array_equal(*parts) for parts in zip(first, last)):
        return pixels, in_front
    for number, point in enumerate(points):
        for _ in range(ROW_ITERATIONS):
            part = pixels[number, 1] / (camera.height - 1)
            pixels[number] = project(point[None], *view_between(first, last, part), camera)[0][0]
    return pixels, in_front


class WallRenderer:
    """Renders frames of a Wall through a Camera.

    ``noise``: standard deviation, gray levels. ``blur``: standard deviation,
    pixels. ``smear``: pixels, the length of a horizontal motion blur.
    ``light``: how much darker the wall's right end is than its left, 0 to 1.
    ``quality``: that of the JPEG compression of each frame, 1 to 100; 0 for no
    compression. ``seed`` makes the noise repeatable. ``printed``: a picture,
    (h, w, 3) BGR, which is printed on the wall's area, over the tags, with their
    ink on their paper. Raises InputError for a poster that cannot be read.
    """

    def __init__(self, wall: Wall, camera: Camera, noise: float = 0.0, blur: float = 0.0, light: float = 0.0,
                 seed: int = 0, smear: int = 1, quality: int = 0, printed: Image | None = None) -> None:
        self._wall, self._camera = wall, camera
        self._blur, self._smear, self._quality = blur, smear, quality
        self._random = np.random.RandomState(seed)
        textures = Textures(wall, light)
        self._background = textures.plaster(self._random)
        self._posters = [(poster.corners, textures.poster(load_picture(poster.image), poster.corners))
                         for poster in wall.posters]
        self._printed = None if printed is None else textures.poster(as_printed(printed), wall.area_corners)
        papers = [wall.paper(tag) for tag in wall.tags]
        self._tags = [(tag, corners, textures.paper(cells, corners))
                      for tag, (cells, corners) in zip(wall.tags, papers)]
        self._noise = None
        if noise > 0:
            shape = (camera.height + NOISE_FIELD_MARGIN, camera.width + NOISE_FIELD_MARGIN, 3)
            self._noise = np.round(self._random.normal(0, noise, shape)).astype(np.int16)
        self._lens = _lens(camera)
        width, height = self._lens[1]
        self._room = np.full((height, width, 3), ROOM_COLOR, np.uint8)

    def render(self, rotation: Floats, translation: Floats, covered: Collection[int] = (),
               exposure: float = 1.0, last: Extrinsics | None = None, visitor: str = NOBODY,
               seconds: float = 0.0) -> Image:
        """The frame, (h, w, 3) BGR uint8, in the view (rotation, translation); see wall_to_camera.

        ``covered``: ids of tags that a gray card covers. ``exposure``: the
        factor for the brightness of the frame. ``last``: with a rolling
        shutter, the view when the last row is read. ``visitor``: who moves in
        front of the wall, one of VISITORS. ``seconds``: the time of that motion.
        """
        matrix, _, lens = self._lens
        to_image = matrix @ _wall_to_rays((rotation, translation))
        frame = self._room.copy()
        self._draw_wall(frame, to_image, rotation, translation)
        floor = self._outline(FLOOR, rotation, translation)
        if floor is not None:
            cv2.fillPoly(frame, [floor], FLOOR_COLOR, cv2.LINE_AA, 4)
        for corners, texture in self._posters:
            self._draw_flat(frame, corners, texture, POSTER_SAMPLES, to_image, rotation, translation)
        for tag, paper, texture in self._tags:
            self._draw_flat(frame, paper, texture, SAMPLES, to_image, rotation, translation)
            if tag.id in covered:
                card = self._outline(tag.on_wall(*CARD), rotation, translation)
                if card is not None:
                    cv2.fillPoly(frame, [card], CARD_COLOR, cv2.LINE_AA, 4)
        if self._printed is not None:
            self._draw_flat(frame, self._wall.area_corners, self._printed, POSTER_SAMPLES, to_image, rotation,
                            translation)
        if visitor != NOBODY:
            draw_visitor(frame, visitor, seconds, matrix, rotation, translation)
        sources = lens if last is None else self._sources_by_row((rotation, translation), last)
        if sources is not None:
            frame = cv2.remap(frame, sources, NO_ARRAY, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        if self._blur > 0:
            frame = cv2.GaussianBlur(frame, (0, 0), self._blur)
        if self._smear > 1:
            frame = cv2.blur(frame, (self._smear, 1))
        if exposure != 1:
            frame = cv2.convertScaleAbs(frame, alpha=exposure)
        if self._noise is not None:
            top, left = self._random.randint(0, NOISE_FIELD_MARGIN + 1, 2)
            window = self._noise[top:top + frame.shape[0], left:left + frame.shape[1]]
            frame = cv2.add(frame, window, dtype=cv2.CV_8U)
        if self._quality:
            packed = cv2.imencode('.jpg', frame, [cv2.IMWRITE_JPEG_QUALITY, self._quality])[1]
            frame = cv2.imdecode(packed, cv2.IMREAD_COLOR)
        return frame

    def _sources_by_row(self, first: Extrinsics, last: Extrinsics) -> Image:
        """(h, w, 2) float32: for each pixel of the frame, its position in the image of the first view."""
        matrix, _, sources = self._lens
        height, width = self._camera.height, self._camera.width
        if sources is None:
            sources = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.float32)
        seen = np.empty_like(sources)
        to_first = matrix @ _wall_to_rays(first)
        for row in range(height):
            back = to_first @ np.linalg.inv(
                matrix @ _wall_to_rays(view_between(first, last, row / (height - 1))))
            seen[row] = transform(back, np.asarray(sources[row], np.float64))
        return seen

    def _outline(self, points: Floats, rotation: Floats, translation: Floats) -> Integers | None:
        """A polygon of the scene in the frame, (n, 2) int32, in 16ths of a pixel; None if not visible."""
        seen = clip_near(points @ rotation.T + translation)
        if len(seen) < 3:
            return None
        pixels = (seen / seen[:, 2:]) @ self._lens[0].T
        return np.clip(np.round(pixels[:, :2] * 16), -2**24, 2**24).astype(np.int32)

    def _draw_wall(self, frame: Image, to_image: Floats, rotation: Floats, translation: Floats) -> None:
        half, height = self._wall.width / 2, self._wall.height
        outline = self._outline(np.array([[-half, height, 0], [half, height, 0], [half, 0, 0],
                                          [-half, 0, 0]]), rotation, translation)
        if outline is None:
            return
        to_wall = np.array([[1 / WALL_TEXELS_M, 0, 0.5 / WALL_TEXELS_M - half],
                            [0, -1 / WALL_TEXELS_M, height - 0.5 / WALL_TEXELS_M], [0, 0, 1]])
        # The wall's pattern is soft, so half the resolution is enough, at a quarter of the cost.
        half_size = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25], [0, 0, 1]])
        size = frame.shape[1::-1]
        seen = cv2.warpPerspective(self._background, half_size @ to_image @ to_wall,
                                   (size[0] // 2, size[1] // 2),
                                   flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        seen = cv2.resize(seen, size, interpolation=cv2.INTER_LINEAR)
        mask = np.zeros(frame.shape[:2], np.uint8)
        cv2.fillPoly(mask, [outline], (255,), cv2.LINE_8, 4)
        cv2.copyTo(seen, mask, frame)

    def _draw_flat(self, frame: Image, paper: Floats, pyramid: list[Image], samples: int, to_image: Floats,
                   rotation: Floats, translation: Floats) -> None:
        """Draw a tag's paper or a poster into a frame. ``paper``: (4, 3), its corners on the wall.

        Each pixel is the mean of ``samples`` x ``samples`` samples. The level of
        the pyramid is chosen so that no texels are skipped.
        """
        if np.min(paper @ rotation[2] + translation[2]) <= NEAR_M:
            return
        ends = np.column_stack([paper[:, :2], np.ones(4)]) @ to_image.T
        ends = ends[:, :2] / ends[:, 2:]
        low = np.maximum(np.floor(ends.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(ends.max(axis=0)).astype(int) + 1, frame.shape[1::-1])
        if np.any(high <= low):
            return
        width, height = (int(length) for length in high - low)
        across, down = np.linalg.norm(ends - np.roll(ends, -1, axis=0), axis=1).reshape(2, 2).min(axis=0)
        level = 0
        while level + 1 < len(pyramid) and (pyramid[level].shape[0] > down * samples
                                            or pyramid[level].shape[1] > across * samples):
            level += 1
        texture = pyramid[level]
        foot, side = texture.shape[:2]
        fine = np.asarray((ends + 0.5 - low) * samples - 0.5, np.float32)
        # The middle of a texel or pixel has whole coordinates, its rim is half a unit away.
        rim = np.array([[-.5, -.5], [side - .5, -.5], [side - .5, foot - .5], [-.5, foot - .5]], np.float32)
        to_fine = cv2.getPerspectiveTransform(rim, fine)
        seen = cv2.warpPerspective(texture, to_fine, (width * samples, height * samples),
                                   flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        cover = np.zeros(seen.shape[:2], np.uint8)
        cv2.fillConvexPoly(cover, np.round(np.clip(fine, -FAR_PX, FAR_PX) * 16).astype(np.int32), (255,),
                           cv2.LINE_8, 4)

        def mean(seen: Image) -> Image:
            pixels = cv2.resize(seen, (width, height), interpolation=cv2.INTER_AREA)
            return pixels if pixels.ndim == 3 else cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR)
        part = frame[low[1]:high[1], low[0]:high[0]]
        part[:] = blend(part, mean(seen), mean(cover))


def _wall_to_rays(view: Extrinsics) -> Floats:
    """(3, 3): the matrix that maps points of the wall, (x, y, 1), to rays of the camera."""
    rotation, translation = view
    return np.column_stack([rotation[:, 0], rotation[:, 1], translation])


def clip_near(points: Floats) -> Floats:
    """The polygon, (n, 3) in the optical frame, without the part that is nearer than NEAR_M."""
    kept = []
    for start, end in zip(points, np.roll(points, -1, axis=0)):
        if start[2] > NEAR_M:
            kept.append(start)
        if (start[2] > NEAR_M) != (end[2] > NEAR_M):
            kept.append(start + (NEAR_M - start[2]) / (end[2] - start[2]) * (end - start))
    return np.array(kept).reshape(-1, 3)


def _lens(camera: Camera) -> tuple[Floats, tuple[int, int], Floats | None]:
    """(K, (width, height), map): the pinhole image to render, and how the lens distorts it.

    Without distortion, the image is the frame, and the map is None. With it,
    the image contains all that the lens shows. Then the map, (h, w, 2) float32,
    is the position in it for each pixel of the frame.
    """
    if not camera.lens.bends:
        return camera.matrix, (camera.width, camera.height), None
    grid = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1)
    sources = camera.lens.undistort(grid).reshape(-1, 2)
    blind = np.isnan(sources).any(axis=1)  # pixels that see no ray, at the corners of the frame
    low, high = sources[~blind].min(axis=0, initial=0), sources[~blind].max(axis=0, initial=0)
    low, high = np.floor(low) - 1, np.ceil(high) + 1
    if blind.mean() > MAX_BLIND or not np.all(high - low < 4 * np.array([camera.width, camera.height])):
        raise InputError('The distortion %s is too strong to be simulated; give smaller coefficients.'
                         % (list(camera.distortion),))
    matrix = camera.matrix.copy()
    matrix[:2, 2] -= low
    width, height = (int(length) for length in high - low + 1)
    sources = np.asarray(np.nan_to_num(sources - low), np.float32).reshape(camera.height, camera.width, 2)
    return matrix, (width, height), sources
