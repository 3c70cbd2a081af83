"""A wall that is remembered: what was learned of it, in a file.

The file is a ZIP archive of NumPy arrays, as numpy.savez_compressed writes it.
"""
from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import read_whole, write_whole
from aruco_ar.tags.tag import DICTIONARIES, MAX_BORDER_CELLS, tag_cells

WALL_SUFFIX = '.npz'             # of the file's name
FORMAT = 1                       # to be increased when older versions cannot read the file any more
MAX_BYTES = 2 * 1024 * 1024      # of the file
MAX_UNPACKED_BYTES = 4 * MAX_BYTES
MAX_TAGS, MAX_POINTS, MAX_FEATURES = 1000, 1000, 2000
MAX_SIDE_PX = 1024               # of the look's image
LARGEST = 1e4                    # of all numbers: pixels, and places, which are in sides of the area
DESCRIPTOR = 128                 # numbers that describe a feature: see cv2.SIFT


@dataclass(frozen=True, eq=False)
class Look:
    """What a wall looks like, tags included, and which points of it stay in their places.

    ``image``: (h, w) uint8, the area with a margin, from straight ahead: see Template. ``inner``: (2,) pixels,
    the area's size in it. ``points``: (n, 2), pixels of the image. ``places``: (n, 2), in the plane of the
    area. ``on_tags``: (n,), which points are on a tag. ``bias``: pixels, how well the corners were known.
    """

    image: Image
    inner: Floats
    points: Floats
    places: Floats
    on_tags: Booleans
    bias: float


@dataclass(frozen=True, eq=False)
class Features:
    """The SIFT features of a wall.

    ``places``: (n, 2) float32, in the plane of the area. ``descriptors``: (n, DESCRIPTOR) uint8.
    """

    places: Floats
    descriptors: Image


@dataclass(frozen=True, eq=False)
class RememberedWall:
    """What was learned of a wall.

    ``dictionary``, ``border``: of its tags, see Detector. ``ids``: those of the area's tags, in the order of
    its corners. ``places``: {id: (4, 2) float64}, the corners of all its tags in the plane of the area.
    ``look``: None if it could not be learned. ``features``: may be none.
    """

    dictionary: str
    border: float
    ids: tuple[int, ...]
    places: Mapping[int, Floats]
    look: Look | None
    features: Features

    def save(self, path: str) -> None:
        """Write it to a file, whose name must end with WALL_SUFFIX. Raises InputError if that is impossible."""
        if not path.lower().endswith(WALL_SUFFIX):
            raise InputError('The name "%s" does not end with %s. Give one that does.' % (path, WALL_SUFFIX))
        arrays: dict[str, Any] = {
            'format': FORMAT, 'dictionary': self.dictionary, 'border': float(self.border), 'ids': self.ids,
            'tags': list(self.places), 'tag_places': np.array(list(self.places.values())),
            'feature_places': self.features.places, 'feature_descriptors': self.features.descriptors}
        if self.look is not None:
            arrays.update(image=self.look.image, inner=self.look.inner, points=self.look.points,
                          point_places=self.look.places, on_tags=self.look.on_tags, bias=self.look.bias)
        file = io.BytesIO()
        np.savez_compressed(file, **arrays)
        write_whole(path, file.getvalue())


NO_FEATURES = Features(np.empty((0, 2), np.float32), np.empty((0, DESCRIPTOR), np.uint8))


def load_remembered(path: str, dictionary: str, border: float) -> RememberedWall:
    """Read a RememberedWall from its file.

    ``dictionary``, ``border``: of the tags that are looked for. Raises InputError, which names the file, if it
    cannot be read, is not what ``save`` writes, or has other tags.
    """
    wall = _read(path)
    own = wall.dictionary, wall.border
    if (DICTIONARIES[wall.dictionary], wall.border) != (DICTIONARIES.get(dictionary), border):
        raise InputError('The wall in "%s" has tags of %s with a border of %g cells, but tags of %s with a '
                         'border of %g are looked for. Give its own: dictionary:=%s border:=%g.'
                         % (path, *own, dictionary, border, *own))
    return wall


def _read(path: str) -> RememberedWall:
    data = read_whole(path, MAX_BYTES)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > MAX_UNPACKED_BYTES:
                raise ValueError
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            is_other_format = int(arrays['format']) != FORMAT
            wall = None if is_other_format else _wall_of({name: arrays[name] for name in arrays.files})
    except Exception:  # what ZipFile and NumPy raise for damaged files is not documented
        raise InputError('The file "%s" is damaged, or is none that the service ~save_wall wrote. Give one of '
                         'these.' % path) from None
    if wall is None:
        raise InputError('The file "%s" was written by another version of unit5. Save the wall again, by the '
                         'service ~save_wall.' % path)
    return wall


def _wall_of(arrays: Mapping[str, Any]) -> RememberedWall:
    """The wall that these arrays are. Raises any exception if they do not fit together."""
    dictionary, border = str(arrays['dictionary']), float(arrays['border'])
    ids = tuple(arrays['ids'].tolist())
    tags = _checked(arrays['tags'], np.integer, (-1,), MAX_TAGS).tolist()
    places = _checked(arrays['tag_places'], np.floating, (len(tags), 4, 2), MAX_TAGS)
    for tag_id in tags:
        tag_cells(dictionary, tag_id)
    features = Features(_checked(arrays['feature_places'], np.floating, (-1, 2), MAX_FEATURES),
                        _checked(arrays['feature_descriptors'], np.uint8, (-1, DESCRIPTOR), MAX_FEATURES))
    if not (dictionary in DICTIONARIES and 1 <= border <= MAX_BORDER_CELLS and len(set(tags)) == len(tags)
            and len(ids) == len(set(ids)) == 4 and set(ids) <= set(tags)
            and len(features.places) == len(features.descriptors)):
        raise ValueError
    return RememberedWall(dictionary, border, ids, dict(zip(tags, places)),
                          _look_of(arrays) if 'image' in arrays else None, features)


def _look_of(arrays: Mapping[str, Any]) -> Look:
    image = _checked(arrays['image'], np.uint8, (-1, -1), MAX_SIDE_PX)
    points = _checked(arrays['points'], np.floating, (-1, 2), MAX_POINTS)
    look = Look(image, _checked(arrays['inner'], np.floating, (2,), 2), points,
                _checked(arrays['point_places'], np.floating, points.shape, MAX_POINTS),
                _checked(arrays['on_tags'], np.bool_, points.shape[:1], MAX_POINTS), float(arrays['bias']))
    width, height = image.shape[::-1]
    for numbers, low, high in ((look.points, 0, (width - 1, height - 1)), (look.inner, 1, (width, height)),
                               (look.bias, 0, LARGEST)):
        if not ((low <= numbers) & (numbers <= np.array(high))).all():
            raise ValueError
    return look


def _checked(array: Any, kind: Any, shape: tuple[int, ...], longest: int) -> Any:
    """The array, if its dtype is of that kind, and it has that shape, in which -1 stands for any length.

    No side may be longer than ``longest`` or than the shape says. Raises ValueError.
    """
    fits = len(array.shape) == len(shape) and all(
        length == wanted or (wanted == -1 and length <= longest) for length, wanted in zip(array.shape, shape))
    if not fits or not np.issubdtype(array.dtype, kind):
        raise ValueError
    if np.issubdtype(array.dtype, np.floating) and not (np.abs(array) <= LARGEST).all():
        raise ValueError
    return array
