"""Masks and their connected parts. A mask is (h, w) bool."""
from __future__ import annotations

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Integers

GAP_PX = 5          # smaller gaps in a part are closed
MIN_PART_PX = 40    # smaller parts are noise
MAX_HOLE_PX = 500   # smaller holes are filled: what stands in front may have spots of the wall's color
MARGIN_PX = 24      # such a margin around all parts is larger than a hole, even in a corner of the image
WHOLE = slice(None), slice(None)  # the rows and columns of an image


def grown(mask: Booleans, px: int) -> Booleans:
    """The mask, grown by px // 2 pixels in all directions."""
    return np.asarray(cv2.dilate(mask.view(np.uint8), np.ones((px, px), np.uint8))).view(bool)


def shrunk(mask: Booleans, px: int) -> Booleans:
    """The mask, shrunk by px // 2 pixels, but not at the rim of the image."""
    return np.asarray(cv2.erode(mask.view(np.uint8), np.ones((px, px), np.uint8))).view(bool)


def grown_labels(labels: Integers, px: int) -> Integers:
    """(h, w) int32: the largest label in a window of that width around each pixel: parts with what is near."""
    # OpenCV does not dilate integers.
    return np.asarray(cv2.dilate(labels.astype(np.float32), np.ones((px, px), np.uint8)), np.int32)


def mean_color(image: Floats, mask: Booleans, px: int) -> Floats:
    """(h, w, 3) float32: the mean color of the pixels of a mask in a window of that width around each pixel.

    ``image``: (h, w, 3) float32. Where no such pixel is near, it is 0.
    """
    weight = mask.astype(np.float32)
    masked = cv2.multiply(image, cv2.merge([weight] * 3))
    sums, weights = (cv2.blur(each, (px, px)) for each in (masked, weight))
    return np.asarray(cv2.divide(sums, cv2.merge([np.maximum(weights, np.float32(1e-6))] * 3)), np.float32)


def opened(mask: Booleans) -> Booleans:
    """Of the mask, the pixels of crosses, 3 pixels wide and high, that are in it as a whole."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    return np.asarray(cv2.morphologyEx(mask.view(np.uint8), cv2.MORPH_OPEN, cross)).view(bool)


def around(mask: Booleans, margin: int, step: int = 1) -> tuple[slice, slice]:
    """The rows and columns of an image within a margin around a mask, (h, w), in multiples of a step."""
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    rows, columns = (slice(max(begin - margin, 0) // step * step, -(-(begin + length + margin) // step) * step)
                     for begin, length in ((y, height), (x, width)))
    return rows, columns


def closed(mask: Booleans, px: int) -> Booleans:
    """The mask without gaps narrower than ``px``. Gaps between a part and the rim of the image stay."""
    margin = px // 2 + 1
    wide = cv2.copyMakeBorder(mask.view(np.uint8), margin, margin, margin, margin, cv2.BORDER_REPLICATE)
    wide = cv2.morphologyEx(wide, cv2.MORPH_CLOSE, np.ones((px, px), np.uint8))
    return np.asarray(wide)[margin:-margin, margin:-margin].view(bool)


def outline_of(mask: Booleans) -> Booleans:
    """The pixels of the mask that touch others outside of it, but not those at the rim of the image."""
    return mask & ~shrunk(mask, 3)


def components(mask: Booleans) -> tuple[Integers, int]:
    """The connected parts, as (h, w) int32 labels from 1 on, 0 elsewhere, and their number."""
    count, labels = cv2.connectedComponents(mask.view(np.uint8), connectivity=4)
    return np.asarray(labels, np.int32), count - 1


def parts_of(mask: Booleans) -> tuple[Integers, int]:
    """The connected parts, as (h, w) labels from 1 on, 0 elsewhere, and their number.

    Small gaps and holes are filled first, and small parts are left out.
    """
    labels, part = np.zeros(mask.shape, np.int32), around(mask, MARGIN_PX)
    mask = closed(mask[part], GAP_PX)
    mask |= _parts_of_size(~mask, 1, MAX_HOLE_PX)
    labels[part], count = components(_parts_of_size(mask, MIN_PART_PX, mask.size))
    return labels, count


def still_parts(labels: Integers, count: int, before: Booleans, changed: Booleans, share: float) -> Booleans:
    """The parts whose outlines have hardly moved: at most ``share`` of an outline by more than a pixel.

    ``labels``, ``count``: see parts_of. ``before``: (h, w), where parts were in an earlier frame. ``changed``:
    (h, w), where the colors have changed since then; elsewhere, nothing has moved.
    """
    now = labels > 0
    changed = changed & ((now & ~grown(before, 3)) | (before & ~grown(now, 3)))
    moved = np.bincount(grown_labels(labels, 5)[changed], minlength=count + 1)
    outline = np.bincount(labels[outline_of(now)], minlength=count + 1)
    still = moved <= share * outline
    still[0] = False
    return np.asarray(still[labels])


def _parts_of_size(mask: Booleans, least: int, most: int) -> Booleans:
    """The connected parts with ``least`` to ``most`` pixels."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=4)
    pixels = stats[:, cv2.CC_STAT_AREA]
    wanted = (pixels >= least) & (pixels <= most)
    wanted[0] = False
    return np.asarray(wanted[np.asarray(labels)])
