"""Parameters of nodes: each is a field of a dataclass, the settings of a kind of node.

The field says the parameter's default, what it is for, and which values it
takes. All else is made from that. reconfigure makes what dynamic_reconfigure
offers, and manual makes what ``--help`` prints. script/remake/launch_args makes the
arguments of the launch files. The checks at a node's start and the tables of
the documentation also come from it.
"""
import re
import reprlib
from dataclasses import dataclass, field, fields
from typing import Callable, Tuple, Union

from aruco_ar.base.errors import InputError, shorten

AUTO = 'auto'
MAX_TEXT = 64 * 1024  # longest text, in characters
MAX_PATH = 4096       # longest path or name, in characters; Linux takes no longer one
MAX_QUOTED = 100      # longest value that a sentence repeats, in characters
# A parameter server cannot keep these characters, since it writes XML. Some also garble a log.
CONTROL = re.compile('[\0-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]')


@dataclass(frozen=True)
class Number:
    """The kind of a parameter that is a number from ``low`` to ``high``."""

    low: float
    high: float

    @property
    def allowed(self):
        return 'a number from %s to %s' % (_digits(self.low), _digits(self.high))

    def read(self, value):
        """The value as a float. Raises ValueError if it is not an allowed number."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not self.low <= value <= self.high:
            raise ValueError
        return float(value)

    def to_ros(self, value):
        """The value as a parameter server keeps it."""
        return value


def _digits(number):
    """A bound in full: 2147483648, not 2.14748e+09."""
    return '%d' % number if number == int(number) else '%g' % number


@dataclass(frozen=True)
class Choice:
    """The kind of a parameter that is one of several texts. ``listed``: those that users see."""

    choices: Tuple[str, ...]
    listed: Tuple[str, ...]

    @property
    def allowed(self):
        return 'one of ' + ', '.join(self.listed)

    def read(self, value):
        """The value. Raises ValueError if it is not one of the choices."""
        if not isinstance(value, str) or value not in self.choices:
            raise ValueError
        return value

    def to_ros(self, value):
        """The value as a parameter server keeps it."""
        return value


@dataclass(frozen=True)
class Parsed:
    """The kind of a parameter with functions of its own.

    ``allowed``: which values it takes, in words. ``read`` turns what a
    parameter server has into the value, or raises ValueError, TypeError or
    AttributeError. ``to_ros`` turns the value into what a parameter server
    keeps.
    """

    allowed: str
    read: Callable
    to_ros: Callable


@dataclass(frozen=True)
class Parameter:
    """What a class of settings says about one parameter, besides its name and its default.

    ``kind``: a Number, Choice or Parsed. ``what``: what it is for. ``live``:
    whether it can be changed while the node runs.
    """

    kind: Union[Number, Choice, Parsed]
    what: str
    live: bool

    @property
    def sentence(self):
        """What the parameter is for, and which values it takes."""
        return '%s (%s)' % (self.what, self.kind.allowed)


def number(default, low, high, what, live=True):
    """A dataclass's field for a parameter that is a number from ``low`` to ``high``."""
    return _field(default, Number(low, high), what, live)


def choice(default, choices, what, live=True, listed=None):
    """A dataclass's field for a parameter that is one of several texts. ``listed``: see Choice; None: all."""
    return _field(default, Choice(tuple(choices), tuple(listed or choices)), what, live)


def switch(default, what):
    """A dataclass's field for a parameter that is True, False, or AUTO, with which the node decides."""
    return parsed(default, 'true, false or auto', what, _true_false_or_auto, lambda value: value, live=False)


def _true_false_or_auto(value):
    if value != AUTO and not isinstance(value, bool):
        raise ValueError
    return value


def path_or_name(value):
    """The value, a text that can be a path or a name. Raises ValueError for any other."""
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_PATH or CONTROL.search(value):
        raise ValueError
    return value


def text(default, allowed, what, read=path_or_name, live=True):
    """A dataclass's field for a parameter that is a text. ``allowed``, ``read``: see Parsed."""
    return parsed(default, allowed, what, read, str, live)


def parsed(default, allowed, what, read, to_ros, live=True):
    """A dataclass's field for a parameter of any other kind: see Parsed."""
    return _field(default, Parsed(allowed, read, to_ros), what, live)


def _field(default, kind, what, live):
    return field(default=default, metadata={'parameter': Parameter(kind, what, live)})


def parameters_of(settings):
    """{name: Parameter} of a class of settings, or of an instance."""
    return {item.name: item.metadata['parameter'] for item in fields(settings)}


def read(kind_of_settings, get):
    """An instance of a class of settings; ``get(name, default)`` looks up what a parameter server has.

    Raises InputError with the name of the parameter, its value, and which values it takes.
    """
    values = {}
    for item in fields(kind_of_settings):
        kind = item.metadata['parameter'].kind
        value = get(item.name, kind.to_ros(item.default))
        try:
            if isinstance(value, str) and len(value) > MAX_TEXT:
                raise ValueError
            values[item.name] = kind.read(value)
        except (TypeError, ValueError, AttributeError):
            raise InputError('The parameter ~%s is %s; it must be %s.'
                             % (item.name, quoted(value), kind.allowed)) from None
    return kind_of_settings(**values)


def quoted(value):
    """A value as a sentence repeats it: shortened, and a text in quotes."""
    if isinstance(value, str):
        return '"%s"' % shorten(value, MAX_QUOTED)
    return shorten(reprlib.repr(value), MAX_QUOTED)


def ros_values(settings):
    """{name: value} of an instance of settings, as a parameter server keeps them."""
    return {name: parameter.kind.to_ros(getattr(settings, name))
            for name, parameter in parameters_of(settings).items()}
