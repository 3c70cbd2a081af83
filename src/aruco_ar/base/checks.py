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

LARGEST = 2**31 - 1  # numbers in an array; so its sides are ints in C


def check_array(name: str, array: Any, dtype: type, *shapes: Shape, writes: bool = False) -> None:
    """Raise InputError unless this is an array of that dtype and one of those shapes.

    ``name``: what it is, for the message. ``writes``: it must not be read-only.
    """
    if not isinstance(array, np.ndarray) or array.dtype != dtype or not _fits_one(array.shape, shapes):
        raise _error(name, array, dtype, shapes)
    if array.size > LARGEST:
        raise InputError('The %s is too large, %s; give one of at most %d numbers.' % (
            name, _text(array.shape), LARGEST))
    if writes and not array.flags.writeable:
        raise InputError('The %s is read-only, but it would be changed; give a copy, by .copy().' % name)


def _error(name: str, array: Any, dtype: type, shapes: Sequence[Shape]) -> InputError:
    """The InputError that says what the array is, and what it should be."""
    is_array = isinstance(array, np.ndarray)
    found = '%s %s' % (_text(array.shape), array.dtype) if is_array else \
        'no array but a %s' % type(array).__name__
    wanted = '%s %s' % (' or '.join(map(_text, shapes)), np.dtype(dtype).name)
    sentence = 'The %s is %s; give %s.' % (name, found, wanted)
    if is_array and array.ndim == 2 and all(len(shape) == 3 for shape in shapes):
        sentence += ' Gray becomes BGR by cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR).'
    return InputError(sentence)


def _fits_one(found: tuple[int, ...], shapes: Sequence[Shape]) -> bool:
    if found in shapes:
        return True
    for wanted in shapes:
        if len(found) == len(wanted):
            for one, other in zip(found, wanted):
                if one != other and (one == 0 or not isinstance(other, str)):
                    break
            else:
                return True
    return False


def _text(shape: Shape) -> str:
    """A shape as in Python: (h, w, 3)."""
    return '(%s%s)' % (', '.join(map(str, shape)), ',' if len(shape) == 1 else '')
