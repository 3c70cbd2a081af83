"""What was drawn: an output of the learner's code compared with the frame that it was given.

Where nothing was drawn, an output is exactly the frame, or the frame as OpenCV shrinks it or makes it gray.
So whatever differs from that was drawn, in whatever color.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterator, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Image, Integers, Numbers

from aruco_course.check import Fault, Shown

INTERPOLATIONS = cv2.INTER_LINEAR, cv2.INTER_AREA, cv2.INTER_NEAREST, cv2.INTER_CUBIC, cv2.INTER_LANCZOS4
SAME = 1              # gray levels: pixels that differ by no more are the same
ROUGHLY = 12          # the same, if the frame was not kept exactly
LEAST_EXACT = 0.3     # share of pixels that are exactly those of the frame, if it was kept exactly
LEAST_SAME = 0.1      # share of pixels that must be those of the frame
ASPECT = 0.02         # how far the scales across and down may be apart, as a share

Change = Callable[[Image], Image]


@dataclass(frozen=True, eq=False)
class Drawing:
    """An output compared with the frame.

    ``image``: the output, (h, w, 3) BGR uint8, even if it was gray. ``frame``: the same if nothing had been
    drawn. ``changed``: (h, w) bool, where something was drawn. ``scale``: (2,), the size of the output as a
    share of that of the frame, across and down. ``fault``: why the output is not the frame with something
    drawn at all, and ``changed`` means little, or None.
    """

    image: Image
    frame: Image
    changed: Booleans
    scale: Floats
    fault: Fault | None = None

    def place(self, points: Numbers) -> Floats:
        """(..., 2) pixels of the output, of points in pixels of the frame."""
        return (np.asarray(points, np.float64) + 0.5) * self.scale - 0.5


def drawing_of(shown: Shown, output: int = -1) -> Drawing:
    """The Drawing of one of the outputs, by default the last."""
    image = as_bgr(shown.images[output])
    frame = shown.view.frame
    scale = np.array(image.shape[1::-1]) / np.array(frame.shape[1::-1])
    blue, green, red = cv2.split(image)
    plain = np.array_equal(blue, green) and np.array_equal(green, red)
    base, same = _closest(image, _bases(frame, image.shape[1::-1], PLAIN if plain else COLORED))
    difference = _difference(image, base)
    # Pixels that were sent as JPEG, or scaled by another program, differ a little everywhere.
    exact = np.mean(difference == 0) > LEAST_EXACT
    changed = difference > (SAME if exact else ROUGHLY)
    fault = _size_fault(shown, scale)
    if fault is None and same < LEAST_SAME:
        fault = _frame_fault(shown, image)
    return Drawing(image, base, changed, scale, fault)


def as_bgr(image: Image) -> Image:
    """Any image, also a gray one or one with an alpha channel, as (h, w, 3) uint8."""
    image = np.asarray(image)
    if image.dtype == np.bool_:
        image = image * np.uint8(255)
    if image.dtype != np.uint8:
        image = np.asarray(np.clip(image, 0, 255), np.uint8)
    if image.ndim == 2 or image.shape[2] == 1:
        return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    return np.ascontiguousarray(image[:, :, :3])


def place_of(shown: Shown) -> str:
    """Where a Fault in it is: such as "Frame 12"."""
    return 'Frame %d' % shown.number


def _gray(code: int) -> Change:
    return lambda image: cv2.cvtColor(cv2.cvtColor(image, code), cv2.COLOR_GRAY2BGR)


def _channel(number: int) -> Change:
    return lambda image: cv2.cvtColor(np.ascontiguousarray(image[:, :, number]), cv2.COLOR_GRAY2BGR)


def _mean(image: Image) -> Image:
    return cv2.cvtColor(image.mean(axis=2).astype(np.uint8), cv2.COLOR_GRAY2BGR)


# What may become of a frame's colors: of a gray output, and of a colored one.
PLAIN: Sequence[Change] = (_gray(cv2.COLOR_BGR2GRAY), _gray(cv2.COLOR_RGB2GRAY), _channel(0), _channel(1),
                           _channel(2), _mean)
COLORED: Sequence[Change] = (lambda image: image, *PLAIN[:2])


# What else may become of a frame.
LOOKS: Sequence[tuple[str, Change]] = (
    ('The colors of your image are exchanged: blue is red, and red is blue.',
     lambda image: np.ascontiguousarray(image[:, :, ::-1])),
    ('Your image is mirrored.', lambda image: cv2.flip(image, 1)),
    ('Your image is upside down.', lambda image: cv2.flip(image, 0)),
    ('Your image is turned by 180 degrees.', lambda image: cv2.flip(image, -1)),
    ('Your image is a negative: each color is 255 minus what it was.', cv2.bitwise_not),
)


def _bases(frame: Image, size: Sequence[int], changes: Sequence[Change]) -> Iterator[Image]:
    """The frame as it may look in an output of that size, (width, height), if nothing is drawn."""
    if frame.shape[1::-1] == tuple(size):
        yield from (change(frame) for change in changes)
        return
    for interpolation in INTERPOLATIONS:
        scaled = cv2.resize(frame, tuple(size), interpolation=interpolation)
        yield from (change(scaled) for change in changes)
    for change in changes[1:]:  # first made gray, then scaled
        yield cv2.resize(change(frame), tuple(size), interpolation=cv2.INTER_LINEAR)


def _closest(image: Image, bases: Iterator[Image]) -> tuple[Image, float]:
    """The base of which the image has most pixels exactly, and the share of those that are nearly the same."""
    best, most = image, -1.0
    for base in bases:
        exact = float(np.mean(_difference(image[::2, ::2], base[::2, ::2]) == 0))
        if exact > most:
            best, most = base, exact
        if most > 0.9:  # it will not become better
            break
    return best, float(np.mean(_difference(image, best) <= SAME))


def _difference(image: Image, other: Image) -> Integers:
    """(h, w) uint8: by how many levels the pixels differ, in the channel in which they differ most."""
    return brightest(cv2.absdiff(image, other))


def _size_fault(shown: Shown, scale: Floats) -> Fault | None:
    across, down = scale
    if abs(across - down) <= ASPECT * max(across, down):
        return None
    height, width = shown.view.frame.shape[:2]
    return Fault('Your image is %d pixels wide and %d high, but the frame is %d wide and %d high. The shape of '
                 'an array has the height first, while OpenCV takes a size as (width, height).'
                 % (round(across * width), round(down * height), width, height), place_of(shown), shown)


def _frame_fault(shown: Shown, image: Image) -> Fault:
    """What became of the frame, of which hardly a pixel is left."""
    base = cv2.resize(shown.view.frame, image.shape[1::-1])
    what = ('The frame is hardly to be seen in your image, since nearly each pixel is changed. '
            'Draw on the frame as it came.')
    if np.all(image == image[0, 0]):
        what = ('Your image is %s, and nothing of the frame is left.'
                % ('of one color only' if image[0, 0].any() else 'black all over'))
    elif np.mean(brightest(image) <= SAME) > 0.5:
        what = 'What you drew is on a black image. Draw it on the frame.'
    else:
        for sentence, change in LOOKS:
            if np.mean(_difference(image, change(base)) <= 2 * SAME) > 0.5:
                what = sentence
                break
    return Fault(what, place_of(shown), shown, base, _difference(image, base) > SAME)


def brightest(image: Image) -> Integers:
    """(h, w) uint8: of each pixel of an image, (h, w, 3), the greatest of blue, green and red."""
    blue, green, red = cv2.split(image)
    return np.asarray(cv2.max(cv2.max(blue, green), red))


def darkest(image: Image) -> Integers:
    """The same for the least."""
    blue, green, red = cv2.split(image)
    return np.asarray(cv2.min(cv2.min(blue, green), red))
