"""The parameters of the nodes that take frames, and the entries of areas files.

After a change of a parameter's default or words, run script/remake/launch_args: it
writes them into the launch files.
"""
import re
from dataclasses import dataclass
from typing import Tuple, Union

from aruco_ar.base.errors import InputError
from aruco_ar.base.files import yaml_entries
from aruco_ar.calibration.sheets import read_board
from aruco_ar.exercise import CORRECT, LENSES
from aruco_ar.looks.look import CLEAN, FOREGROUNDS, FULL, GRAINS, LIGHTS, PAINT, SHOW, TAGS
from aruco_ar.painting.fit import FITS
from aruco_ar.tags.detector import MIN_LIKENESS, SEARCHES
from aruco_ar.tags.tag import DICTIONARIES, DICTIONARY_NAMES, MAX_BORDER_CELLS, SIDE_M, tag_cells
from aruco_ar.tracking.tracker import HOLD_S, UPRIGHT

from aruco_node.messages.topics import IMAGE_TYPES

from .parameters import (
    AUTO,
    MAX_TEXT,
    Number,
    choice,
    number,
    parsed,
    path_or_name,
    read,
    switch,
    text,
)

TOPIC = 'topic:'  # before the name of an image topic, in place of a picture's path
AREA_ENTRIES = 'ids', 'picture', 'fit', 'opacity', 'hold', 'upright'
ID = '{id}'  # stands for the id in the name of a tag's TF frame
LEARN = 'learn'
PINHOLE, FISHEYE = 'pinhole', 'fisheye'
MAX_AREAS = 50  # a limit, since each area takes the memory of its picture
SIDE = Number(*SIDE_M)


def _ids(value):
    """The ids as a tuple, from a list or from text such as "1, 2, 3, 4" or "any", as launch files give it."""
    if value == 'any':
        return ()
    parts = value.strip('[] ').replace(',', ' ').split() if isinstance(value, str) else list(value)
    ids = tuple(map(_id, parts))
    if parts and not len(ids) == len(set(ids)) == 4:
        raise ValueError
    return ids


def _id(value):
    """An id, from a number or from text."""
    if isinstance(value, str) and re.fullmatch(' *[0-9]{1,9} *', value):
        return int(value)
    if type(value) is not int or not 0 <= value < 10**9:
        raise ValueError
    return value


def _ids_as_text(ids):
    return ','.join(map(str, ids)) or 'any'


def _picture(value):
    if value == TOPIC:
        raise ValueError
    return path_or_name(value)


@dataclass(frozen=True)
class FrameSettings:
    """The parameters of every node that takes frames."""

    transport: str = choice(
        AUTO, (AUTO, *IMAGE_TYPES),
        "topic that the frames are read from. raw: the camera's own topic. compressed: its topic /compressed, "
        'as JPEG or PNG. auto: raw, unless only compressed is published', live=False)
    folder: str = text(
        '~/unit5-snapshots', 'the path of a folder', 'folder into which the service ~snapshot saves images')


@dataclass(frozen=True)
class RelaySettings(FrameSettings):
    """The parameters of camera_relay."""

    rate: float = number(0.0, 0, 1000, 'how many frames per second are published at most; 0: all')
    quality: float = number(80.0, 1, 100, 'quality of the JPEG images that are published')


def _board(value):
    if value in ('none', ''):
        return ''
    read_board(value)
    return value


@dataclass(frozen=True)
class CalibrationSettings(FrameSettings):
    """The parameters of calibrate_live. ``charuco``: see read_board; empty for a sheet of tags."""

    dictionary: str = choice(
        'DICT_6X6_250', DICTIONARIES, 'dictionary of the tags, by its OpenCV name', live=False,
        listed=DICTIONARY_NAMES)
    charuco: str = parsed(
        '', 'none, or squares and share such as 5x7:0.75',
        "squares of a ChArUco board, and the side of a marker as a share of a square's. none: a sheet with "
        'tags of one size, wherever they are', _board, lambda value: value or 'none', live=False)
    model: str = choice(PINHOLE, (PINHOLE, FISHEYE), 'kind of lens', live=False)
    camera_name: str = text('camera', 'a name', 'name of the camera in the file')
    file: str = text(
        '~/.ros/camera_info/camera.yaml', 'the path of a file',
        "file that the service ~save writes; a camera driver looks there for a file with the camera's name")


@dataclass(frozen=True)
class TagSettings(FrameSettings):
    """The parameters of every node that looks for tags. ``ids``: four, or empty for any."""

    dictionary: str = choice(
        'DICT_6X6_250', DICTIONARIES, 'dictionary of the tags, by its OpenCV name', listed=DICTIONARY_NAMES)
    ids: Tuple[int, ...] = parsed(
        (), 'any, or the ids of four different tags, such as 1,2,3,4',
        'ids of the four tags that span the area; any: whichever tags are seen', _ids, _ids_as_text)
    scale: float = number(
        1.0, 0.01, 4.0, 'factor by which each frame is resized before tags are looked for')
    search: str = choice(
        'normal', SEARCHES,
        'how thoroughly tags are looked for. fast: enough for near tags. thorough: also finds small and '
        'slanted tags, but takes much longer')
    correction: float = number(
        1.0, 0, 1,
        'how many wrong cells a tag may have, as a share of those that its dictionary can correct; 0: none')
    likeness: float = number(
        MIN_LIKENESS, 0, 1,
        "how closely an image must match a tag's pattern to be taken for that tag; 1 is a perfect match")
    min_side: float = number(
        0.0, 0, 10000, 'smallest side of a tag in the frame, in pixels; smaller tags are ignored')
    border: float = number(
        1.0, 1, MAX_BORDER_CELLS, "width of the tags' black border, in cells (see artag_generator --border)")


@dataclass(frozen=True)
class LensSettings(TagSettings):
    """The parameters of every node that takes the distortion of the lens into account."""

    lens: str = choice(
        CORRECT, LENSES,
        'whether the distortion of the lens is considered. correct: the picture is bent as the lens bends the '
        'wall, if the camera is calibrated. ignore: it is not bent')
    camera_info: str = text(
        AUTO, 'auto, or the name of a topic',
        "topic of the camera's calibration; auto: camera_info beside the camera's images", live=False)
    rectified: Union[str, bool] = switch(
        AUTO,
        'whether the frames have no distortion any more. auto: so if the name of their topic begins with '
        'image_rect')


@dataclass(frozen=True)
class AreaSettings(LensSettings):
    """The parameters of every node that tracks the area."""

    hold: float = number(
        HOLD_S, 0, 60,
        "seconds for which the area is kept while neither tags nor the wall's texture show where it is")
    upright: str = choice(
        'tags', UPRIGHT,
        "where the top of the picture is. tags: at the tags' own tops. image: at the top of the frame")


@dataclass(frozen=True)
class PictureSettings(AreaSettings):
    """The parameters of exercise5_6."""

    picture: str = text(
        'images/earth.jpg',
        'the path of a picture, GIF or video, or an image topic such as topic:/other/camera',
        'what is painted into the area; a path can be in full, or within the package as images/earth.jpg',
        _picture)
    fit: str = choice(
        'stretch', FITS,
        'how a picture fits an area of another shape. stretch: the picture is distorted. contain: all of it is '
        'shown, and a part of the area stays free. cover: it fills the area, and its edges are cut off')
    opacity: float = number(
        1.0, 0, 1, 'how opaque the picture is; with 0 only the frame is seen, with 1 only the picture')
    foreground: str = choice(
        PAINT, FOREGROUNDS,
        'what happens to things that stand before the wall. paint: they are painted over. keep: they stay in '
        'front of the picture')
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
        30.0, 0.5, 3600, 'seconds after which a thing that does not move becomes a part of the wall')
    areas: str = text(
        'none', 'none, or the full path of a YAML file',
        'file that describes several areas, as config/areas.yaml does. none: there is a single area',
        live=False)


def _sizes(value):
    """((id, meters), ...), from a dict or from text such as "7: 0.1, 8: 0.25", as launch files give it."""
    if value in ('none', '', {}):
        return ()
    pairs = value.items() if not isinstance(value, str) else \
        [part.split(':') for part in value.strip('{} ').split(',')]
    sizes = tuple((_id(tag_id), SIDE.read(float(size) if isinstance(size, str) else size))
                  for tag_id, size in pairs)
    if len(dict(sizes)) < len(sizes) or len(_sizes_as_text(sizes)) > MAX_TEXT:
        raise ValueError
    return sizes


def _sizes_as_text(sizes):
    return ', '.join('%d: %s' % pair for pair in sizes) or 'none'


def _tag_frame(value):
    if ID not in path_or_name(value):
        raise ValueError
    return value


@dataclass(frozen=True)
class PoseSettings(AreaSettings):
    """The parameters of tag_poses."""

    tag_size: float = number(0.18, *SIDE_M, "side of a tag's black square, in meters")
    tag_sizes: Tuple[Tuple[int, float], ...] = parsed(
        (), 'none, or ids and sides in meters, such as 7: 0.1, 8: 0.25',
        'sides of the tags that have another side than tag_size', _sizes, _sizes_as_text)
    wall: str = text(
        LEARN, 'learn, or the path of a YAML file, which may be within the package',
        'file that says where the tags are on the wall, as config/wall.yaml does. learn: this is learned from '
        'the frames')
    tag_frame: str = text(
        'tag_' + ID, 'a name with {id} in it', 'name of the TF frame of a tag; {id} stands for its id',
        _tag_frame, live=False)
    wall_frame: str = text(
        AUTO, 'auto, or the name of a TF frame',
        'TF frame in which the poses of the camera and the robot are given. auto: learned_wall if the wall is '
        'learned, otherwise wall', live=False)
    robot_frame: str = text(
        'base_link', 'the name of a TF frame', 'TF frame of the robot, for its pose', live=False)

    def __post_init__(self):
        """Raises InputError if a tag with a size of its own is not in the dictionary."""
        try:
            for tag_id, _ in self.tag_sizes:
                tag_cells(self.dictionary, tag_id)
        except InputError as error:
            raise InputError('The parameter ~tag_sizes cannot be used: %s' % error) from None


@dataclass(frozen=True)
class BagSettings(PoseSettings, PictureSettings):
    """The parameters of annotate_bags."""


def load_areas(path):
    """The areas that a YAML file describes: a list of {name of a parameter: value}.

    config/areas.yaml shows all entries that there are. Raises InputError with
    the file and the wrong entry.
    """
    with yaml_entries(path) as data:
        entries = [dict(entry) for entry in data['areas']]
        for entry in entries:
            unknown = set(entry) - set(AREA_ENTRIES)
            if unknown:
                raise ValueError('"%s" is none of %s' % (unknown.pop(), ', '.join(AREA_ENTRIES)))
            if not entry['ids'] or not read(PictureSettings, entry.get).ids:
                raise ValueError('an area needs the ids of its four tags')
    if not 0 < len(entries) <= MAX_AREAS:
        raise InputError('The file "%s" has %d areas; give at least one, at most %d.'
                         % (path, len(entries), MAX_AREAS))
    return entries
