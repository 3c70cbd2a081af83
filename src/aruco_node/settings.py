"""The parameters that all exercises share, checked."""
from dataclasses import dataclass
from typing import Tuple

from aruco_ar.errors import InputError
from aruco_ar.files import yaml_entries
from aruco_ar.fitting import FITS
from aruco_ar.tags import DICTIONARIES
from aruco_ar.tracker import HOLD_S, UPRIGHT

from .waiting import IMAGE_TYPES

MIN_SCALE, MAX_SCALE = 0.01, 4.0
MAX_HOLD_S = 60.0
TOPIC = 'topic:'  # before the name of an image topic, in place of a picture's path
AREA_ENTRIES = 'ids', 'picture', 'fit', 'opacity', 'hold', 'upright'


@dataclass(frozen=True)
class Settings:
    """What the private parameters of an exercise's node say.

    ``ids``: the four tags that count, or empty for any. ``scale``: what each
    frame's size is multiplied by before anything else. ``transport``: raw or
    compressed. ``hold``, ``upright``: see Tracker. ``picture``: the path of a
    file, which may be within the package, or topic: and the name of an image
    topic. ``fit``, ``opacity``: see overlay.
    """

    dictionary: str = 'DICT_6X6_250'
    ids: Tuple[int, ...] = ()
    scale: float = 1.0
    transport: str = 'raw'
    hold: float = HOLD_S
    upright: str = 'tags'
    picture: str = 'images/earth.jpg'
    fit: str = 'stretch'
    opacity: float = 1.0


def read_settings(get):
    """Settings from parameters; ``get(name, default)`` looks one up.

    Raises InputError naming the parameter, its value and what is allowed.
    """
    defaults = Settings()
    return Settings(
        dictionary=_one_of(get, 'dictionary', DICTIONARIES, defaults.dictionary),
        ids=_ids(get),
        scale=number(get, 'scale', defaults.scale, MIN_SCALE, MAX_SCALE),
        transport=_one_of(get, 'transport', IMAGE_TYPES, defaults.transport),
        hold=number(get, 'hold', defaults.hold, 0, MAX_HOLD_S),
        upright=_one_of(get, 'upright', UPRIGHT, defaults.upright),
        picture=_picture(get('picture', defaults.picture)),
        fit=_one_of(get, 'fit', FITS, defaults.fit),
        opacity=number(get, 'opacity', defaults.opacity, 0, 1))


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
            if not entry['ids'] or not read_settings(entry.get).ids:
                raise ValueError('an area needs the ids of its four tags')
    if not entries:
        raise InputError('The file "%s" has no areas; give at least one.' % path)
    return entries


def _picture(value):
    if not isinstance(value, str) or value in ('', TOPIC):
        raise _wrong('picture', value, 'the path of a picture or video, such as images/earth.jpg, or '
                                       'topic: and the name of an image topic, such as topic:/other/camera')
    return value


def number(get, name, default, low, high):
    """A number parameter within [low, high]. Raises InputError if it is none."""
    value = get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise _wrong(name, value, 'a number from %g to %g' % (low, high))
    return float(value)


def _wrong(name, value, allowed):
    return InputError('The parameter ~%s is %s; it must be %s.'
                      % (name, '"%s"' % value if isinstance(value, str) else value, allowed))


def _one_of(get, name, choices, default):
    value = get(name, default)
    if not isinstance(value, str) or value not in choices:
        raise _wrong(name, value, 'one of ' + ', '.join(choices))
    return value


def _ids(get):
    """The parameter ~ids: a list, or text such as "1, 2, 3, 4" or "any", as launch files give it."""
    value = get('ids', '')
    try:
        if value == 'any':
            return ()
        parts = value.strip('[] ').replace(',', ' ').split() if isinstance(value, str) else list(value)
        ids = tuple(int(part) for part in parts if not isinstance(part, (bool, float)))
    except (TypeError, ValueError):
        parts, ids = [value], ()
    if parts and not (len(ids) == len(parts) == len(set(ids)) == 4):
        raise _wrong('ids', value, '"any", or the ids of four different tags, such as 1,2,3,4')
    return ids
