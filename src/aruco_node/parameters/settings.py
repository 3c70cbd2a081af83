"""The parameters of the nodes that look at a camera's frames, and of areas files."""
import re
from dataclasses import dataclass
from typing import Tuple, Union

from aruco_ar.base.errors import InputError
from aruco_ar.base.files import yaml_entries
from aruco_ar.painting.fit import FITS
from aruco_ar.tags.detector import MIN_LIKENESS, SEARCHES
from aruco_ar.tags.tag import DICTIONARIES, DICTIONARY_NAMES, SIDE_M
from aruco_ar.tracking.tracker import HOLD_S, UPRIGHT

from aruco_node.messages.topics import IMAGE_TYPES

from .parameters import AUTO, MAX_TEXT, Number, choice, number, read, some_text, text, wish

TOPIC = 'topic:'  # before the name of an image topic, in place of a picture's path
AREA_ENTRIES = 'ids', 'picture', 'fit', 'opacity', 'hold', 'upright'
ID = '{id}'  # in the name of a tag's frame
LEARN = 'learn'
MAX_AREAS = 50  # each takes the memory of its picture
SIZE = Number(*SIDE_M)


def _ids(value):
    """A list, or text such as "1, 2, 3, 4" or "any", as launch files give it."""
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
    return some_text(value)


@dataclass(frozen=True)
class FrameSettings:
    """What every node that takes frames takes."""

    transport: str = choice('raw', IMAGE_TYPES, 'compressed reads TOPIC/compressed', live=False)
    folder: str = text('~/unit5-snapshots', 'the path of a folder', 'where ~snapshot saves pictures')


@dataclass(frozen=True)
class RelaySettings(FrameSettings):
    """What camera_relay takes."""

    rate: float = number(0.0, 0, 1000, 'frames a second, at most; 0: all')
    quality: float = number(80.0, 1, 100, 'of the JPEGs')


@dataclass(frozen=True)
class Settings(FrameSettings):
    """What every node that looks at frames takes. ``ids``: the four that count, or empty for any."""

    dictionary: str = choice('DICT_6X6_250', DICTIONARIES, 'dictionary of the tags, by its OpenCV name',
                             shown=DICTIONARY_NAMES)
    ids: Tuple[int, ...] = text((), '"any", or the ids of four different tags, such as 1,2,3,4',
                                'the four tags that count', _ids, _ids_as_text)
    scale: float = number(1.0, 0.01, 4.0, 'each frame is resized by this factor first')
    search: str = choice('normal', SEARCHES, 'how hard to look for tags: fast for near ones, thorough for '
                                             'small and slanted ones')
    correction: float = number(1.0, 0, 1, 'how many of the wrong cells that the dictionary could correct are '
                                          'corrected')
    likeness: float = number(MIN_LIKENESS, 0, 1, 'how much what is seen must look like the tag that it is '
                                                 'taken for')
    min_side: float = number(0.0, 0, 10000, 'tags narrower than this are passed over, pixels')


@dataclass(frozen=True)
class AreaSettings(Settings):
    """With the area. ``hold``, ``upright``: see Tracker."""

    hold: float = number(HOLD_S, 0, 60, 'seconds for which the area stays at most without a tag in sight')
    upright: str = choice('tags', UPRIGHT, "whose top is the picture's: that of the tags or of the image")


@dataclass(frozen=True)
class PictureSettings(AreaSettings):
    """With the picture: a file, which may be within the package, or topic: and the name of an image topic."""

    picture: str = text('images/earth.jpg',
                        'the path of a picture or video, such as images/earth.jpg, or topic: and the name of '
                        'an image topic, such as topic:/other/camera', 'what is painted', _picture)
    fit: str = choice('stretch', FITS, 'how a picture of another shape goes into the area')
    opacity: float = number(1.0, 0, 1, 'how much of the picture is in the mixture with the frame')
    areas: str = text('none', 'none, or the path of a YAML file', 'several areas: see config/areas.yaml',
                      live=False)


def _sizes(value):
    """Pairs of id and meters, of a dict, or of text such as "7: 0.1, 8: 0.25", as launch files give it."""
    if value in ('none', '', {}):
        return ()
    pairs = value.items() if not isinstance(value, str) else \
        [part.split(':') for part in value.strip('{} ').split(',')]
    sizes = tuple((_id(tag_id), SIZE.read(float(size) if isinstance(size, str) else size))
                  for tag_id, size in pairs)
    if len(dict(sizes)) < len(sizes) or len(_sizes_as_text(sizes)) > MAX_TEXT:
        raise ValueError
    return sizes


def _sizes_as_text(sizes):
    return ', '.join('%d: %s' % pair for pair in sizes) or 'none'


def _tag_frame(value):
    if ID not in some_text(value):
        raise ValueError
    return value


@dataclass(frozen=True)
class PoseSettings(AreaSettings):
    """What tag_poses takes."""

    tag_size: float = number(0.18, *SIDE_M, "side of the tags' black square, meters")
    tag_sizes: Tuple[Tuple[int, float], ...] = text(
        (), 'none, or ids and sides in meters, such as 7: 0.1, 8: 0.25', 'tags of another size', _sizes,
        _sizes_as_text)
    wall: str = text(LEARN, 'learn, or the path of a YAML file, which may be within the package',
                     'where the tags are on the wall: see config/wall.yaml')
    camera_info: str = text(AUTO, 'auto, or the name of a topic',
                            "auto: camera_info beside the camera's images", live=False)
    rectified: Union[str, bool] = wish(AUTO, 'whether the lens is corrected in the frames already; auto: if '
                                             'their topic is called image_rect...')
    tag_frame: str = text('tag_' + ID, 'a name with {id} in it', 'TF frame of a tag', _tag_frame, live=False)
    wall_frame: str = text(AUTO, 'auto, or the name of a TF frame',
                           "frame in which the camera's and the robot's poses are given; auto: wall, or "
                           'learned_wall where it is learned', live=False)
    robot_frame: str = text('base_link', 'the name of a TF frame', 'frame of the robot, for its pose',
                            live=False)


@dataclass(frozen=True)
class BagSettings(PoseSettings, PictureSettings):
    """What annotate_bags takes."""


def load_areas(path):
    """What a YAML file says of several areas: a list of {name of a parameter: value}.

    config/areas.yaml shows all there is. Raises InputError naming the file and
    the entry that is wrong.
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
