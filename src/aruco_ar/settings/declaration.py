"""What a class of settings is: a dataclass, each field of which is a parameter.

The field says the parameter's default, what it is for, and which values it
takes. All else is made from that: the checks, and all that aruco_node makes of
it (see aruco_node.parameters).
"""
from __future__ import annotations

import re
import reprlib
from dataclasses import dataclass, field, fields
from typing import Any, Callable, Iterable

from aruco_ar.base.errors import InputError, shorten

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
    def allowed(self) -> str:
        return 'a number from %s to %s' % (_digits(self.low), _digits(self.high))

    def read(self, value: Any) -> float:
        """The value as a float. Raises ValueError if it is not an allowed number."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not self.low <= value <= self.high:
            raise ValueError
        return float(value)

    def to_plain(self, value: Any) -> Any:
        """The value as YAML and a parameter server have it."""
        return value


def _digits(number: float) -> str:
    """A bound in full: 2147483648, not 2.14748e+09."""
    return '%d' % number if number == int(number) else '%g' % number


@dataclass(frozen=True)
class Choice:
    """The kind of a parameter that is one of several texts. ``listed``: those that users see."""

    choices: tuple[str, ...]
    listed: tuple[str, ...]

    @property
    def allowed(self) -> str:
        return 'one of ' + ', '.join(self.listed)

    def read(self, value: Any) -> str:
        """The value. Raises ValueError if it is not one of the choices."""
        if not isinstance(value, str) or value not in self.choices:
            raise ValueError
        return value

    def to_plain(self, value: Any) -> Any:
        """The value as YAML and a parameter server have it."""
        return value


@dataclass(frozen=True)
class Parsed:
    """The kind of a parameter with functions of its own.

    ``allowed``: which values it takes, in words. ``read`` turns what YAML or a
    parameter server has into the value, and leaves the value as it is; it may
    raise ValueError, TypeError or AttributeError. ``to_plain`` turns the value
    into what they have: a text, a number, true, false, or a list of these.
    """

    allowed: str
    read: Callable[[Any], Any]
    to_plain: Callable[[Any], Any]


@dataclass(frozen=True)
class Parameter:
    """What a class of settings says about one parameter, besides its name and its default.

    ``kind``: a Number, Choice or Parsed. ``what``: what it is for. ``live``:
    whether it can be changed while the node runs.
    """

    kind: Number | Choice | Parsed
    what: str
    live: bool

    @property
    def sentence(self) -> str:
        """What the parameter is for, and which values it takes."""
        return '%s (%s)' % (self.what, self.kind.allowed)


def number(default: float, low: float, high: float, what: str, live: bool = True) -> Any:
    """A dataclass's field for a parameter that is a number from ``low`` to ``high``."""
    return _field(default, Number(low, high), what, live)


def choice(default: str, choices: Iterable[str], what: str, live: bool = True,
           listed: Iterable[str] | None = None) -> Any:
    """A dataclass's field for a parameter that is one of several texts. ``listed``: see Choice; None: all."""
    return _field(default, Choice(tuple(choices), tuple(listed or choices)), what, live)


def path_or_name(value: Any) -> str:
    """The value, a text that can be a path or a name. Raises ValueError for any other."""
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_PATH or CONTROL.search(value):
        raise ValueError
    return value


def text(default: str, allowed: str, what: str, read: Callable[[Any], str] = path_or_name,
         live: bool = True) -> Any:
    """A dataclass's field for a parameter that is a text. ``allowed``, ``read``: see Parsed."""
    return parsed(default, allowed, what, read, str, live)


def parsed(default: Any, allowed: str, what: str, read: Callable[[Any], Any], to_plain: Callable[[Any], Any],
           live: bool = True) -> Any:
    """A dataclass's field for a parameter of any other kind: see Parsed."""
    return _field(default, Parsed(allowed, read, to_plain), what, live)


def _field(default: Any, kind: Number | Choice | Parsed, what: str, live: bool) -> Any:
    return field(default=default, metadata={'parameter': Parameter(kind, what, live)})


def parameters_of(settings: type[Settings] | Settings) -> dict[str, Parameter]:
    """{name: Parameter} of a class of settings, or of an instance."""
    return {item.name: item.metadata['parameter'] for item in fields(settings)}


def checked(name: str, parameter: Parameter, value: Any) -> Any:
    """The value of a Parameter, from one that may have another form, such as a text in place of a tuple.

    Raises InputError with the name, the value, and which values the parameter takes.
    """
    try:
        if isinstance(value, str) and len(value) > MAX_TEXT:
            raise ValueError
        return parameter.kind.read(value)
    except (TypeError, ValueError, AttributeError):
        raise InputError('The parameter %s is %s; it must be %s.'
                         % (name, quoted(value), parameter.kind.allowed)) from None


def quoted(value: Any) -> str:
    """A value as a sentence repeats it: shortened, and a text in quotes."""
    if isinstance(value, str):
        return '"%s"' % shorten(value, MAX_QUOTED)
    return shorten(reprlib.repr(value), MAX_QUOTED)


@dataclass(frozen=True)
class Settings:
    """The base of all classes of settings. An instance is made only of values that are allowed."""

    def __post_init__(self) -> None:
        """Raises InputError for a value that is not allowed."""
        for name, parameter in parameters_of(self).items():
            given = getattr(self, name)
            value = checked(name, parameter, given)
            if value != given:  # so a whole number, such as that of a port, stays one
                object.__setattr__(self, name, value)
