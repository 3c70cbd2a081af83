"""Settings as options of a command line: --light match is what light:=match is to a node."""
from __future__ import annotations

import argparse
import re
from typing import Any, Mapping, TypeVar

from aruco_ar.settings.declaration import Number, Settings, checked, parameters_of

Kind = TypeVar('Kind', bound=Settings)


def add_settings(parser: argparse.ArgumentParser, kind: type[Settings], usual: Mapping[str, str]) -> None:
    """Add an option for each parameter of a class of settings. ``usual``: what is done without some of them."""
    defaults = kind()
    group = parser.add_argument_group('how it is done, as for the nodes')
    for name, parameter in parameters_of(kind).items():
        default = usual.get(name, parameter.kind.to_plain(getattr(defaults, name)))
        group.add_argument('--' + name, metavar='VALUE', help='%s (default: %s)' % (
            parameter.sentence.replace('%', '%%'), default))


def settings_of(options: argparse.Namespace, kind: type[Kind]) -> Kind:
    """The settings by the options that add_settings has added.

    Raises InputError with the option, its value, and which values it takes.
    """
    given = {}
    for name, parameter in parameters_of(kind).items():
        text = getattr(options, name)
        if text is not None:
            given[name] = checked('--' + name, parameter, _plain(text) if isinstance(
                parameter.kind, Number) else text)
    return kind(**given)


def _plain(text: str) -> Any:
    """A text as a number, if it is one."""
    try:
        return float(text)
    except ValueError:
        return text


def with_options(sentence: str) -> str:
    """A sentence for users of the nodes, with arguments such as light:=match written as options."""
    return re.sub(r'\b([a-z_]+):=(?=\S)', r'--\1 ', sentence)
