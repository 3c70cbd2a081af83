"""The parameters of the nodes that take frames, and the entries of areas files.

After a change of a parameter's default or words, run script/remake/launch_args: it
writes them into the launch files.
"""
from dataclasses import dataclass
from typing import Union

from aruco_ar.base.errors import InputError
from aruco_ar.base.files import yaml_entries
from aruco_ar.calibration.sheets import read_board
from aruco_ar.settings import settings
from aruco_ar.settings.declaration import (
    Settings,
    choice,
    number,
    parameters_of,
    parsed,
    path_or_name,
    text,
)
from aruco_ar.tags.tag import DICTIONARIES, DICTIONARY_NAMES

from aruco_node.messages.topics import IMAGE_TYPES

from .parameters import AUTO, read, switch

TOPIC = 'topic:'  # before the name of an image topic, in place of a picture's path
OLD_NAMES = {'image_transport': 'transport'}  # {parameter: its former name}, which launch files keep
AREA_ENTRIES = 'ids', 'picture', 'fit', 'opacity', 'hold', 'upright', 'wall'
ID = '{id}'  # stands for the id in the name of a tag's TF frame
PINHOLE, FISHEYE = 'pinhole', 'fisheye'
MAX_AREAS = 50  # a limit, since each area takes the memory of its picture


def _picture(value):
    if value == TOPIC:
        raise ValueError
    return path_or_name(value)


@dataclass(frozen=True)
class FrameSettings(Settings):
    """The parameters of every node that takes frames."""

    image_transport: str = choice(
        AUTO, (AUTO, *IMAGE_TYPES),
        "topic that the frames are read from. raw: the camera's own topic. compressed: its topic /compressed, "
        'as JPEG or PNG. auto: raw, unless only compressed is published', live=False)
    folder: str = text(
        '~/unit5-snapshots', 'the path of a folder', 'folder into which services of the node write files')


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
class TagSettings(settings.DetectionSettings, FrameSettings):
    """The parameters of every node that looks for tags."""

    scale: float = number(
        1.0, 0.01, 4.0, 'factor by which each frame is resized before tags are looked for')


@dataclass(frozen=True)
class LensSettings(settings.LensSettings, TagSettings):
    """The parameters of every node that takes the distortion of the lens into account."""

    camera_info: str = text(
        AUTO, 'auto, or the name of a topic',
        "topic of the camera's calibration; auto: camera_info beside the camera's images", live=False)
    rectified: Union[str, bool] = switch(
        AUTO,
        'whether the frames have no distortion any more. auto: they have none if the name of their topic '
        'begins with image_rect')


@dataclass(frozen=True)
class AreaSettings(settings.AreaSettings, LensSettings):
    """The parameters of every node that tracks the area."""


@dataclass(frozen=True)
class PictureSettings(settings.PictureSettings, AreaSettings):
    """The parameters of exercise5_6."""

    picture: str = text(
        settings.PictureSettings.picture,
        'the path of a picture, GIF or video, or an image topic such as topic:/other/camera',
        parameters_of(settings.PictureSettings)['picture'].what, _picture)
    areas: str = text(
        'none', 'none, or the full path of a YAML file',
        'file that describes several areas, as config/areas.yaml does. none: there is a single area',
        live=False)


def _tag_frame(value):
    if ID not in path_or_name(value):
        raise ValueError
    return value


@dataclass(frozen=True)
class PoseSettings(settings.PoseSettings, AreaSettings):
    """The parameters of tag_poses."""

    tag_frame: str = text(
        'tag_' + ID, 'a name with {id} in it', 'name of the TF frame of a tag; {id} stands for its id',
        _tag_frame, live=False)
    wall_frame: str = text(
        AUTO, 'auto, or the name of a TF frame',
        'TF frame in which the poses of the camera and the robot are given. auto: learned_wall if the wall is '
        'learned, otherwise wall', live=False)
    robot_frame: str = text(
        'base_link', 'the name of a TF frame', 'TF frame of the robot, for its pose', live=False)


@dataclass(frozen=True)
class BagSettings(PoseSettings, PictureSettings):
    """The parameters of annotate_bags."""

    wall: str = text(settings.AreaSettings.wall, 'learn, or the path of a file that ~save_wall wrote',
                     parameters_of(settings.AreaSettings)['wall'].what)

    def remembered_wall(self):
        return settings.AreaSettings.remembered_wall(self)


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
