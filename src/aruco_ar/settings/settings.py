"""The settings of what this package does: how tags are found, and what is painted between them.

After a change of a default or of words, run script/remake/launch_args: it writes them
into the launch files.
"""
from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from aruco_ar.base.errors import InputError
from aruco_ar.base.files import in_package
from aruco_ar.tags.detector import MIN_CONFIDENCE, SEARCHES
from aruco_ar.tags.tag import DICTIONARIES, DICTIONARY_NAMES, MAX_BORDER_CELLS, SIDE_M, tag_cells
from aruco_ar.walls.remembered import WALL_SUFFIX, RememberedWall, load_remembered

from .declaration import MAX_TEXT, Number, Settings, choice, number, parameters_of, parsed, text

CORRECT, IGNORE = LENSES = 'correct', 'ignore'
HOLD_S = 0.3
LEARN = 'learn'
UPRIGHT = 'tags', 'image'
FITS = 'stretch', 'contain', 'cover'
PAINT, KEEP = FOREGROUNDS = 'paint', 'keep'
FULL, MATCH = LIGHTS = 'full', 'match'
CLEAN, MATCH = GRAINS = 'clean', 'match'
SHOW, HIDE = TAGS = 'show', 'hide'


def _ids(value: Any) -> tuple[int, ...]:
    """The ids as a tuple, from a list or from text such as "1, 2, 3, 4" or "any", as launch files give it."""
    if value == 'any':
        return ()
    parts = value.strip('[] ').replace(',', ' ').split() if isinstance(value, str) else list(value)
    ids = tuple(map(read_id, parts))
    if parts and not len(ids) == len(set(ids)) == 4:
        raise ValueError
    return ids


def read_id(value: Any) -> int:
    """An id, from a number or from text. Raises ValueError for anything else."""
    if isinstance(value, str) and re.fullmatch(' *[0-9]{1,9} *', value):
        return int(value)
    if type(value) is not int or not 0 <= value < 10**9:
        raise ValueError
    return value


def ids_as_text(ids: tuple[int, ...]) -> str:
    """Ids as parameters have them, such as "1,2,3,4", or "any" for none."""
    return ','.join(map(str, ids)) or 'any'


@dataclass(frozen=True)
class DetectionSettings(Settings):
    """How tags are looked for. ``ids``: four, or empty for any."""

    dictionary: str = choice(
        'DICT_6X6_250', DICTIONARIES, 'dictionary of the tags, by its OpenCV name', listed=DICTIONARY_NAMES)
    ids: tuple[int, ...] = parsed(
        (), 'any, or the ids of four different tags, such as 1,2,3,4',
        'ids of the four tags that span the area; any: whichever tags are seen', _ids, ids_as_text)
    search: str = choice(
        'normal', SEARCHES,
        'how thoroughly tags are looked for. fast: enough for near tags. thorough: also finds small and '
        'slanted tags, but takes much longer')
    correction: float = number(
        1.0, 0, 1,
        'how many wrong cells a tag may have, as a share of those that its dictionary can correct; 0: none')
    confidence: float = number(
        MIN_CONFIDENCE, 0, 1,
        'how sure it must be that something is a tag: of those found at 0.9, nine of ten are true')
    min_side: float = number(
        0.0, 0, 10000, 'smallest side of a tag in the frame, in pixels; smaller tags are ignored')
    border: float = number(
        1.0, 1, MAX_BORDER_CELLS, "width of the tags' black border, in cells (see artag_generator --border)")

    def of_detector(self) -> dict[str, Any]:
        """The arguments of a Detector that finds tags so."""
        return {name: getattr(self, name) for name in parameters_of(DetectionSettings)}


@dataclass(frozen=True)
class LensSettings(DetectionSettings):
    """What is needed besides where the camera's calibration may be used."""

    lens: str = choice(
        CORRECT, LENSES,
        'whether the distortion of the lens is considered. correct: the picture is bent as the lens bends the '
        'wall, if the camera is calibrated. ignore: it is not bent')


@dataclass(frozen=True)
class AreaSettings(LensSettings):
    """What is needed besides where the area is tracked."""

    hold: float = number(
        HOLD_S, 0, 60,
        "seconds for which the area is kept while neither tags nor the wall's texture show where it is")
    upright: str = choice(
        'tags', UPRIGHT,
        "where the top of the picture is. tags: at the tags' own tops. image: at the top of the frame")
    wall: str = text(
        LEARN, 'learn, or the path of a file that ~save_wall wrote',
        'what is known of the wall at first. learn: nothing. A file: what had been learned when the service '
        '~save_wall wrote it')

    def remembered_wall(self) -> RememberedWall | None:
        """The RememberedWall that ``wall`` names, or None. Raises InputError if the file cannot be used."""
        if self.wall == LEARN:
            return None
        return load_remembered(in_package(self.wall), self.dictionary, self.border)


@dataclass(frozen=True)
class PictureSettings(AreaSettings):
    """What is needed besides where a picture is painted into the area."""

    picture: str = text(
        'images/earth.jpg', 'the path of a picture, GIF or video',
        'what is painted into the area; a path can be in full, or within the package as images/earth.jpg')
    fit: str = choice(
        'stretch', FITS,
        'how a picture fits an area of another shape. stretch: the picture is distorted. contain: all of it is '
        'shown, and a part of the area stays free. cover: it fills the area, and its edges are cut off')
    opacity: float = number(
        1.0, 0, 1, 'how opaque the picture is; with 0 only the frame is seen, with 1 only the picture')
    foreground: str = choice(
        PAINT, FOREGROUNDS,
        'what happens to things that stand in front of the wall. paint: they are painted over. keep: they stay '
        'in front of the picture')
    light: str = choice(
        FULL, LIGHTS,
        'light in which the picture is painted. full: it has its own colors. match: it has the light and the '
        'shadows that are on the wall')
    grain: str = choice(
        CLEAN, GRAINS,
        'sharpness and noise of the picture. clean: it is painted as it is. match: it gets those of the '
        "camera's image")
    tags: str = choice(
        SHOW, TAGS,
        'whether the tags are seen. show: they stay as they are. hide: each is covered with what the wall '
        'around it looks like')
    settle: float = number(
        30.0, 0.5, 3600,
        'seconds after which a thing that does not move becomes a part of the wall, '
        'unless the wall behind it is known')


def _sizes(value: Any) -> tuple[tuple[int, float], ...]:
    """((id, meters), ...), from a dict or from text such as "7: 0.1, 8: 0.25", as launch files give it."""
    if value in ('none', '', {}):
        return ()
    if isinstance(value, str):
        value = [part.split(':') for part in value.strip('{} ').split(',')]
    elif not isinstance(value, tuple):  # a tuple has been read before
        value = value.items()
    sizes = tuple((read_id(tag_id), Number(*SIDE_M).read(float(size) if isinstance(size, str) else size))
                  for tag_id, size in value)
    if len(dict(sizes)) < len(sizes) or len(_sizes_as_text(sizes)) > MAX_TEXT:
        raise ValueError
    return sizes


def _sizes_as_text(sizes: tuple[tuple[int, float], ...]) -> str:
    return ', '.join('%d: %s' % pair for pair in sizes) or 'none'


@dataclass(frozen=True)
class PoseSettings(AreaSettings):
    """What is needed besides where poses are estimated."""

    tag_size: float = number(0.18, *SIDE_M, "side of a tag's black square, in meters")
    tag_sizes: tuple[tuple[int, float], ...] = parsed(
        (), 'none, or ids and sides in meters, such as 7: 0.1, 8: 0.25',
        'sides of the tags that have another side than tag_size', _sizes, _sizes_as_text)
    wall: str = text(
        LEARN, 'learn, or the path of a file, which may be within the package',
        'what is known of the wall at first. learn: nothing. A YAML file: where the tags are, as in '
        'config/wall.yaml. A file that the service ~save_wall wrote: what had been learned of the area')

    @property
    def learns_places(self) -> bool:
        """Whether it is learned where the tags are: ``wall`` names no YAML file."""
        return self.wall == LEARN or self.wall.lower().endswith(WALL_SUFFIX)

    def remembered_wall(self) -> RememberedWall | None:
        return super().remembered_wall() if self.learns_places else None

    def __post_init__(self) -> None:
        """Raises InputError for a wrong value, and for a tag that has a size but is not in the dictionary."""
        super().__post_init__()
        try:
            for tag_id, _ in self.tag_sizes:
                tag_cells(self.dictionary, tag_id)
        except InputError as error:
            raise InputError('The parameter ~tag_sizes cannot be used: %s' % error) from None
