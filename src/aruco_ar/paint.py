"""Painting on frames.

Every function takes a frame, (h, w, 3) BGR uint8, leaves it as it is, and
returns a new one of the same shape. Positions are in pixels and stay
fractions of a pixel until they are drawn; the middle of the top left pixel
is (0, 0). Colors are (blue, green, red).
"""
import cv2
import numpy as np

GREEN = (0, 255, 0)
RED = (0, 0, 255)
YELLOW = (0, 255, 255)
BLACK = (0, 0, 0)
WHITE = (255, 255, 255)
PURPLE = (255, 0, 150)  # the course's

# OpenCV draws fractions of a pixel as whole numbers of 1 / 2**SHIFT px.
SHIFT = 4


def _fixed(points):
    return np.int32(np.round(np.asarray(points, np.float64) * (1 << SHIFT)))


def mark_tags(frame, tags):
    """Outline every tag, mark its first corner (its own top left), and write its id."""
    image = frame.copy()
    for tag in tags:
        cv2.polylines(image, [_fixed(tag.corners)], True, GREEN, 2, cv2.LINE_AA, SHIFT)
        cv2.circle(image, tuple(map(int, _fixed(tag.corners[0]))), 4 << SHIFT, RED, -1,
                   cv2.LINE_AA, SHIFT)
    for tag in tags:  # after all outlines, so that no line crosses a number
        _write(image, str(tag.id), tag.center)
    return image


def _write(image, text, center):
    """Write text around a center, dark-rimmed to be readable on black and on white."""
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, 0.7
    (width, height), _ = cv2.getTextSize(text, font, scale, 2)
    left = int(np.clip(center[0] - width / 2, 2, max(2, image.shape[1] - width - 2)))
    foot = int(np.clip(center[1] + height / 2, height + 2, max(height + 2, image.shape[0] - 3)))
    cv2.putText(image, text, (left, foot), font, scale, BLACK, 5, cv2.LINE_AA)
    cv2.putText(image, text, (left, foot), font, scale, YELLOW, 2, cv2.LINE_AA)


def mark_centers(frame, centers):
    """Put a dot on every center, (n, 2)."""
    image = frame.copy()
    for center in centers:
        point = tuple(map(int, _fixed(center)))
        cv2.circle(image, point, 5 << SHIFT, BLACK, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(image, point, 4 << SHIFT, YELLOW, -1, cv2.LINE_AA, SHIFT)
    return image


def fill_polygon(frame, points, color=PURPLE):
    """Fill the polygon through points, (n, 2), in the order in which they are given.

    Fewer than three points make no polygon and change nothing.
    """
    image = frame.copy()
    if len(points) >= 3:
        cv2.fillPoly(image, [_fixed(points)], color, cv2.LINE_AA, SHIFT)
    return image


def area_mask(frame, area):
    """White where the area is, black elsewhere; all black if ``area`` is None.

    On the area's rim it is as gray as the part of the pixel that the area covers.
    """
    mask = np.zeros_like(frame)
    if area is not None:
        part, cover = _cover(area, frame.shape)
        mask[part] = cover
    return mask


def _cover(area, shape):
    """The part of a frame that the area touches, as slices, and how much of each pixel is covered.

    The latter is (h, w, 3) uint8, 0 to 255: half a pixel in, on, or half a
    pixel out of the nearest side is all, half, or nothing.
    """
    left, top = np.maximum(np.floor(area.corners.min(axis=0)), 0).astype(int)
    right, bottom = np.minimum(np.ceil(area.corners.max(axis=0)) + 1, shape[1::-1]).astype(int)
    right, bottom = max(left, right), max(top, bottom)
    x = np.arange(left, right, dtype=np.float32)
    y = np.arange(top, bottom, dtype=np.float32)[:, None]
    corners = np.asarray(area.corners, np.float64)
    inward = 1 if cv2.contourArea(np.float32(corners), oriented=True) >= 0 else -1
    cover = np.full((bottom - top, right - left), 255, np.float32)
    for start, end in zip(corners, np.roll(corners, -1, axis=0)):
        along = (end - start) * inward * 255 / np.linalg.norm(end - start)
        # 255 times the distance from this side, plus a half
        row = np.float32(-along[1]) * (x - np.float32(start[0])) + 127.5
        column = np.float32(along[0]) * (y - np.float32(start[1]))
        np.minimum(cover, row + column, out=cover)
    cover = np.uint8(np.maximum(cover, 0, out=cover) + 0.5)
    return (slice(top, bottom), slice(left, right)), np.repeat(cover[..., None], 3, axis=2)


def subtract(frame, mask):
    """The frame without what is white in the mask: black there, untouched where the mask is black."""
    return cv2.subtract(frame, mask)


def overlay(frame, picture, area):
    """The frame with a picture painted into the area; the frame itself if ``area`` is None.

    ``picture``: (h, w, 3) BGR, or (h, w, 4) BGRA, whose alpha lets the frame
    shine through. The rim is smooth: its pixels are part frame, part picture.
    """
    image = frame.copy()
    if area is None:
        return image
    part, cover = _cover(area, frame.shape)
    if cover.size == 0:
        return image
    shift = np.array([[1, 0, -part[1].start], [0, 1, -part[0].start], [0, 0, 1.0]])
    homography = shift @ area.homography(picture.shape[1], picture.shape[0])

    def warp(pixels):
        return cv2.warpPerspective(pixels, homography, cover.shape[1::-1],
                                   flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    if picture.shape[2] == 3:
        image[part] = blend(image[part], warp(picture), cover)
    else:
        # Colors go weighted with their alpha, or those that nobody sees would bleed in at its rim.
        alpha = cv2.cvtColor(picture[:, :, 3], cv2.COLOR_GRAY2BGR)
        weighted = warp(cv2.multiply(picture[:, :, :3], alpha, scale=1 / 255))
        clear = cv2.bitwise_not(cv2.multiply(cover, warp(alpha), scale=1 / 255))
        image[part] = cv2.add(cv2.multiply(image[part], clear, scale=1 / 255),
                              cv2.multiply(weighted, cover, scale=1 / 255))
    return image


def blend(frame, picture, cover):
    """The picture where ``cover`` is white, the frame where it is black, their mixture between.

    All three are (h, w, 3) uint8, and so is the result.
    """
    return cv2.add(cv2.multiply(frame, cv2.bitwise_not(cover), scale=1 / 255),
                   cv2.multiply(picture, cover, scale=1 / 255))
