"""Sequences of hostile pictures.

Each shows a few canvases from a camera that moves and jerks. They may be
blurred, inverted, noisy or covered, and the clock may jump.
"""
from collections import namedtuple

import cv2
import numpy as np

from .scenes import NAMES, SHARES, any_place, canvas_of

# A picture: its kind, the frame, (h, w, 3) BGR uint8, and its time in seconds.
Picture = namedtuple('Picture', 'kind frame stamp')


def _motion(random, size, strong):
    """(3, 3): a homography that moves pixels as a small motion of the camera does, or rarely a jerk."""
    width, height = size
    scale = random.choice([0.004, 0.03, 0.03, 0.3]) * strong
    shift, tilt = scale * random.normal(0, 1, 2) * size, 0.3 * scale * random.normal(0, 1, 2) / size
    turn, zoom = scale * random.normal(), np.exp(scale * random.normal())
    middle = np.array([[1, 0, -width / 2], [0, 1, -height / 2], [0, 0, 1]])
    move = np.array([[zoom * np.cos(turn), -zoom * np.sin(turn), shift[0]],
                     [zoom * np.sin(turn), zoom * np.cos(turn), shift[1]], [*tilt, 1]])
    return np.linalg.inv(middle) @ move @ middle


def _seen(canvas, random):
    """(h, w, 3) BGR: how a camera may see the canvas, (h, w) uint8."""
    seen = canvas
    if random.rand() < 0.15:
        seen = cv2.GaussianBlur(seen, (0, 0), random.uniform(0.4, 4))
    if random.rand() < 0.08:
        seen = cv2.blur(seen, (int(random.randint(2, 25)), 1))
    if random.rand() < 0.1:
        seen = 255 - seen
    if random.rand() < 0.1:
        seen = cv2.convertScaleAbs(seen, alpha=random.choice([0.05, 0.3, 2.0]), beta=random.uniform(0, 100))
    frame = cv2.cvtColor(seen, cv2.COLOR_GRAY2BGR)
    if random.rand() < 0.3:
        frame = cv2.add(frame, random.randint(0, random.choice([4, 20, 80]), frame.shape).astype(np.uint8))
    if random.rand() < 0.15:  # something stands in front of it
        low = np.int32(any_place(canvas, random))
        cv2.rectangle(frame, tuple(map(int, low)), tuple(map(int, low + random.randint(5, 100, 2))),
                      tuple(map(int, random.randint(0, 256, 3))), -1)
    return frame


def _later(stamp, random):
    """The time of the next picture: usually 1/30 s later, but clocks may stop, jump, or be set back."""
    kind = random.rand()
    if kind < 0.85:
        return stamp + 1 / 30
    passed = random.choice([0, 1e-9, 0.2, 0.6, 1e6, -0.1, -stamp, 4e9 - stamp])
    return max(float(stamp + passed), 0.0)


def sequence(random, dictionary, count, size):
    """Yields Pictures. After a few of them, another canvas or another size follows."""
    canvas, stamp = None, float(random.choice([0.0, 1.6e9]))
    while count:
        kind = str(random.choice(NAMES, p=SHARES / SHARES.sum()))
        if canvas is None or random.rand() < 0.8:
            canvas = canvas_of(kind, random, dictionary, size)
        else:  # another canvas of the same size
            canvas = cv2.resize(canvas_of(kind, random, dictionary, size), canvas.shape[::-1])
        motion, speed = np.eye(3), _motion(random, canvas.shape[::-1], 0.2)
        for _ in range(min(count, int(random.choice([1, 3, 8])))):
            yield Picture(kind, _seen(cv2.warpPerspective(
                canvas, motion, canvas.shape[::-1], borderMode=cv2.BORDER_REPLICATE), random), stamp)
            motion = (_motion(random, canvas.shape[::-1], 1.0) if random.rand() < 0.1 else speed) @ motion
            stamp = _later(stamp, random)
            count -= 1
