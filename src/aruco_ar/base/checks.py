"""Checking arrays that come from outside."""
from __future__ import annotations

from typing import Any, Sequence

import numpy as np

from .errors import InputError

# The lengths of an array's axes: a number, or a name for any number from 1 on.
Shape = Sequence['int | str']

GRAY_OR_COLOR: tuple[Shape, ...] = ('h', 'w'), ('h', 'w', 3)
COLOR: tuple[Shape, ...] = (('h', 'w', 3),)
PICTURE: tuple[Shape, ...] = ('h', 'w', 3), ('h', 'w', 4)

LARGEST = 2**31 - 1  # the sides are ints in C and in OpenCV


def check_array(name: str, array: Any, dtype: type, *shapes: Shape, writes: bool = False) -> None:
    """Raise InputError unless this is an array of that dtype and one of those shapes.

    ``name``: what it is, for the message. ``writes``: it must not be read-only.
    """
    is_array = isinstance(array, np.ndarray)
    if not is_array or array.dtype != dtype or not any(_fits(array.shape, shape) for shape in shapes):
        found = '%s %s' % (_text(array.shape), array.dtype) if is_array else \
            'no array but a %s' % type(array).__name__
        sentence = 'The %s is %s; give %s %s.' % (
            name, found, ' or '.join(_text(shape) for shape in shapes), np.dtype(dtype).name)
        if is_array and array.ndim == 2 and all(len(shape) == 3 for shape in shapes):
            sentence += ' Gray becomes BGR by cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR).'
        raise InputError(sentence)
    if max(array.shape, default=0) > LARGEST:
        raise InputError('The %s is too large, %s; no side may be longer than %d.' % (
            name, _text(array.shape), LARGEST))
    if writes and not array.flags.writeable:
        raise InputError('The %s is read-only, but it would be changed; give a copy, by .copy().' % name)


def _fits(found: tuple[int, ...], wanted: Shape) -> bool:
    if len(found) != len(wanted):
        return False
    for one, other in zip(found, wanted):  # this takes half as long as a generator for all(...)
        if one != other and (one == 0 or not isinstance(other, str)):
            return False
    return True


def _text(shape: Shape) -> str:
    """A shape as in Python: (h, w, 3)."""
    return '(%s%s)' % (', '.join(map(str, shape)), ',' if len(shape) == 1 else '')
