"""Reads a library of macOS. The format is that of Apple's <mach-o/loader.h>."""
import struct
from typing import NamedTuple

MAGIC = 0xfeedfacf
LOADED, OWN_NAME, SIGNATURE, INFO = 0xc, 0xd, 0x1d, 0x80000022


class Library(NamedTuple):
    """``own_name``; the names that it shows, without their underscore; what it loads; whether it is signed."""

    own_name: str
    shown: set
    loaded: list
    is_signed: bool


def read_library(data):
    """The Library in these bytes."""
    magic, _, _, _, count, _, _, _ = struct.unpack_from('<8I', data)
    assert magic == MAGIC
    own_name, shown, loaded, is_signed, at = '', set(), [], False, 32
    for _ in range(count):
        kind, size = struct.unpack_from('<2I', data, at)
        if kind in (LOADED, OWN_NAME):
            start = at + struct.unpack_from('<I', data, at + 8)[0]
            name = text_at(data, start)
            own_name = name if kind == OWN_NAME else own_name
            loaded += [name] * (kind == LOADED)
        elif kind == INFO:
            start, length = struct.unpack_from('<2I', data, at + 40)
            shown = {name[1:] for name in names_in(data[start:start + length])}
        is_signed = is_signed or kind == SIGNATURE
        at += size
    return Library(own_name, shown, loaded, is_signed)


def text_at(data, start):
    return data[start:data.index(b'\0', start)].decode()


def number_at(data, start):
    """(number, where it ends): each byte has seven bits of it, and whether there are more."""
    number = shift = 0
    while True:
        number |= (data[start] & 0x7f) << shift
        shift += 7
        start += 1
        if data[start - 1] < 0x80:
            return number, start


def names_in(tree, at=0, before=''):
    """The names that a library shows, in a tree of their beginnings."""
    length, at = number_at(tree, at)
    if length:
        yield before
    at += length
    for _ in range(tree[at]):
        part = text_at(tree, at + 1)
        below, after = number_at(tree, at + 2 + len(part))
        yield from names_in(tree, below, before + part)
        at = after - 1
