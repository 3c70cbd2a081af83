"""The picture of a verdict: what is expected beside what the learner's code shows, the difference marked."""
from __future__ import annotations

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Image

from aruco_course.check import Fault, Shown

BAR_PX, GAP_PX = 34, 12
PAPER, INK = (255, 255, 255), (40, 40, 40)
MARK, HALO = (0, 60, 255), (255, 255, 255)  # seen on any image: red within white
REACH_PX = 5                                # the mark goes around what differs, at this distance
SMALLEST_PX = 12                            # smaller parts of the difference are noise at rims


def verdict_picture(fault: Fault | None, shown: Shown | None) -> Image | None:
    """(h, w, 3) BGR uint8. ``shown``: what the code made of some frame, if it made anything.

    Without a fault it is what the code shows, all its outputs side by side. With one it is what is expected
    beside what the code shows; only the latter if the fault does not say what is expected. None if there is
    nothing to show.
    """
    if fault is None:
        return None if shown is None else _row([_bgr(image) for image in shown.images])
    shown = fault.shown or shown
    if shown is None:
        return None
    yours = _bgr(shown.image)
    if fault.expected is None:
        return _row([_titled(_marked(yours, fault.marked), 'yours')])
    expected = _bgr(fault.expected)
    return _row([_titled(_marked(expected, fault.marked), 'expected'),
                 _titled(_marked(yours, fault.marked), 'yours, wrong where it is outlined'
                         if fault.marked is not None else 'yours')])


def _marked(image: Image, marked: Booleans | None) -> Image:
    """A copy, with a line around each part that differs. ``marked``: (h, w) bool, or None."""
    image = image.copy()
    if marked is None or marked.shape != image.shape[:2]:
        return image
    reach = 2 * REACH_PX + 1
    brush = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    mask = cv2.dilate(np.asarray(marked, np.uint8), brush)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    parts = [contour for contour in contours if max(cv2.boundingRect(contour)[2:]) > reach + SMALLEST_PX]
    for color, width in (HALO, 5), (MARK, 2):
        cv2.drawContours(image, parts or contours, -1, color, width, cv2.LINE_AA)
    return image


def _titled(image: Image, title: str) -> Image:
    """The image below a bar with a word."""
    bar = np.full((BAR_PX, image.shape[1], 3), PAPER, np.uint8)
    cv2.putText(bar, title, (4, BAR_PX - 11), cv2.FONT_HERSHEY_SIMPLEX, 0.75, INK, 2, cv2.LINE_AA)
    return np.vstack([bar, image])


def _row(images: list[Image]) -> Image:
    """Images side by side, on white."""
    height = max(image.shape[0] for image in images)
    parts: list[Image] = []
    for image in images:
        if parts:
            parts.append(np.full((height, GAP_PX, 3), PAPER, np.uint8))
        below = height - image.shape[0]
        parts.append(np.vstack([image, np.full((below, image.shape[1], 3), PAPER, np.uint8)]))
    return np.hstack(parts)


def _bgr(image: Image) -> Image:
    return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else np.asarray(image[..., :3])
