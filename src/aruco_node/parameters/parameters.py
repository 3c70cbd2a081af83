"""Parameters of nodes: each is a field of a dataclass, which says what it may be and what for.

From that one place come the checks when a node starts, what dynamic_reconfigure
shows and takes (see reconfigure), and what ``--help`` prints (see manual).
"""
import re
import reprlib
from dataclasses import dataclass, field, fields
from typing import Callable, Tuple

from aruco_ar.base.errors import InputError, shorten

AUTO = 'auto'
MAX_TEXT = 64 * 1024  # characters of any parameter
MAX_PATH = 4096       # and of a path or a name: what the system takes
MAX_SHOWN = 100       # and of what a sentence repeats
# What no parameter server can keep, for it writes XML, or what does to a log what it likes.
CONTROL = re.compile('[\0-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]')


@dataclass(frozen=True)
class Number:
    """A number from ``low`` to ``high``."""

    low: float
    high: float

    @property
    def allowed(self):
        return 'a number from %g to %g' % (self.low, self.high)

    def read(self, value):
        """The value as a float. Raises ValueError if it is none of those allowed."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not self.low <= value <= self.high:
            raise ValueError
        return float(value)

    def plain(self, value):
        """The value as a parameter server keeps it."""
        return value


@dataclass(frozen=True)
class Choice:
    """One of several texts. ``shown``: those that are told of, if not all."""

    choices: Tuple[str, ...]
    shown: Tuple[str, ...]

    @property
    def allowed(self):
        return 'one of ' + ', '.join(self.shown)

    def read(self, value):
        if not isinstance(value, str) or value not in self.choices:
            raise ValueError
        return value

    def plain(self, value):
        return value


@dataclass(frozen=True)
class Text:
    """Anything that a function makes a value of; where it cannot, it raises ValueError or TypeError."""

    allowed: str
    read: Callable
    plain: Callable = str


@dataclass(frozen=True)
class About:
    """What is known of a parameter: its kind, what it is for, and whether a running node takes another."""

    kind: object
    what: str
    live: bool


def number(default, low, high, what, live=True):
    """A dataclass's field for a number parameter within [low, high]."""
    return _field(default, Number(low, high), what, live)


def choice(default, choices, what, live=True, shown=None):
    """A dataclass's field for a parameter that is one of several texts, of which some are ``shown``."""
    return _field(default, Choice(tuple(choices), tuple(shown or choices)), what, live)


def wish(default, what):
    """A dataclass's field for a parameter that is True, False, or left to the node: AUTO."""
    return _field(default, Text('true, false or auto', _wish, lambda value: value), what, False)


def _wish(value):
    if value != AUTO and not isinstance(value, bool):
        raise ValueError
    return value


def some_text(value):
    """The value, a text that is not empty and can be a path or a name. Raises ValueError for any other."""
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_PATH or CONTROL.search(value):
        raise ValueError
    return value


def text(default, allowed, what, read=some_text, plain=str, live=True):
    """A dataclass's field for any other parameter: see Text."""
    return _field(default, Text(allowed, read, plain), what, live)


def _field(default, kind, what, live):
    return field(default=default, metadata={'about': About(kind, what, live)})


def abouts(settings):
    """{name: About} of all parameters of a class of settings, or of an instance."""
    return {item.name: item.metadata['about'] for item in fields(settings)}


def read(kind_of_settings, get):
    """Settings of that class from parameters; ``get(name, default)`` looks one up.

    Raises InputError naming the parameter, its value and what is allowed.
    """
    values = {}
    for item in fields(kind_of_settings):
        kind = item.metadata['about'].kind
        value = get(item.name, kind.plain(item.default))
        try:
            if isinstance(value, str) and len(value) > MAX_TEXT:
                raise ValueError
            values[item.name] = kind.read(value)
        except (TypeError, ValueError, AttributeError):
            raise InputError('The parameter ~%s is %s; it must be %s.'
                             % (item.name, shown(value), kind.allowed)) from None
    return kind_of_settings(**values)


def shown(value):
    """A value as a sentence repeats it."""
    if isinstance(value, str):
        return '"%s"' % shorten(value, MAX_SHOWN)
    return shorten(reprlib.repr(value), MAX_SHOWN)


def plain(settings):
    """{name: value}: the parameters as a parameter server keeps them."""
    return {name: about.kind.plain(getattr(settings, name)) for name, about in abouts(settings).items()}
