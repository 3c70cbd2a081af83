"""Says why arrays do not fit together, from their shapes and types."""
from __future__ import annotations

from typing import Any, Dict

# What the names of a line have in them, as inside/describe.py tells it.
Values = Dict[str, Dict[str, Any]]


def arrays_of(values: Values) -> Values:
    """The arrays among them."""
    return {name: what for name, what in values.items() if 'shape' in what and 'dtype' in what}


def fit_of(values: Values) -> str:
    """Why the images among these values cannot be added or subtracted, or '' if that is not known."""
    images = {name: what for name, what in arrays_of(values).items() if len(what['shape']) in (2, 3)}
    if len(images) < 2:
        return ''
    (one, first), (other, second) = list(images.items())[:2]
    for name, what in images.items():
        if what['shape'] != first['shape'] or what['dtype'] != first['dtype']:
            other, second = name, what
            break
    a, b = tuple(first['shape']), tuple(second['shape'])
    if a == b:
        if first['dtype'] == second['dtype']:
            return ''
        return '%s is of the type %s, and %s of %s. Images are of uint8: dtype=np.uint8.' % (
            one, first['dtype'], other, second['dtype'])
    what = '%s is %s, and %s is %s.' % (one, size_of(a), other, size_of(b))
    if a[:2] == b[:2]:
        gray = one if len(a) == 2 else other
        return what + ' cv2.merge([%s, %s, %s]) has three channels.' % (gray, gray, gray)
    if a[:2] == b[1::-1]:
        return what + (' Height and width are exchanged: arrays take the height first, (h, w), but '
                       'cv2.resize and cv2.warpPerspective take (w, h).')
    return what + ' They must be of the same size.'


def size_of(shape: tuple[int, ...]) -> str:
    """Such as '448 x 336 pixels and gray'."""
    channels = shape[2] if len(shape) == 3 else 1
    return '%d x %d pixels, %s' % (shape[1], shape[0], 'gray' if channels == 1 else '%d channels' % channels)
