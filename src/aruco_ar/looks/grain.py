"""The grain of a camera's image: how soft its edges are, and how noisy it is."""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import NO_ARRAY, Booleans, Floats, Image, Integers
from aruco_ar.compiled import binding
from aruco_ar.tags.tag import Tag

# Edges. The black border of a tag is one cell wide. The white rim around it is about as wide, at least.
CELLS = 8                  # assumed width of a tag in cells
REACH = 0.75               # length of a profile on each side of an edge, in cells
STEPS = 24                 # number of places along a profile
ALONG = np.linspace(0.2, 0.8, 6)  # places of the profiles along a side, from 0 to 1
# Soft edges of neighboring cells run into each other. In the mean, the cells inside a tag are gray, and a wall
# is a little darker than the paper. So an edge with the deviation TRUE seems to have the deviation SEEN. Both
# are in cells.
TRUE = 0.0, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5
SEEN = 0.0, 0.099, 0.143, 0.181, 0.214, 0.240, 0.261, 0.277, 0.289, 0.299
MIN_CONTRAST = 40.0        # least contrast of paper and ink, in gray levels
MIN_CELL_PX = 2.5          # the edges of smaller cells run into each other
MAX_SIDES = 12             # only this many sides of tags are measured, the longest
# The edges of a painted picture have this variance, in square pixels (see painting.warp).
# Only the variance beyond this has to be added to the picture.
OWN_VARIANCE = 0.40
MIN_VARIANCE = 0.05        # a smaller variance is not worth a filter
# Weight of the assumption that blur is equal in both directions, as a share of the measurements' weight.
SAME = 0.005
RATE = 0.5                 # weight of a new measurement in the running mean; motion blur changes quickly
EDGES_EVERY = 2            # edges are measured in every second frame

# Noise. The kernel takes constant and linear brightness away: J. Immerkaer, Fast noise variance estimation,
# 1996. The norm of its weights is 6. Edges and patterns also remain after filtering. So only the pixels of a
# patch with the smallest slopes count. Noise makes slopes as well, but these say nothing of the filter's
# values, as one is odd and the other even. Of what is left, the smaller values tell the noise: 40 % of a normal
# distribution lie within 0.5244 standard deviations.
KERNEL = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32) / 6
CALM_SHARE = 0.3
SHARE, WITHIN = 0.4, 0.5244
# The same, of every other pixel. In a mosaic of colors that is taken for gray, only these have the same color.
# On photos and videos it found 1 to 4 times as much noise as KERNEL, and on mosaics of them a hundredth of it.
WIDE = np.kron(KERNEL, np.array([[1, 0], [0, 0]], np.float32))[:-1, :-1]
MOSAIC = 0.5               # a share of the noise below this, by WIDE, tells a mosaic
LITTLE = 3.0               # less noise than this is believed, in gray levels
PATCHES, PATCH_PX = 4, 32  # number of patches in each direction, and their side
RIM_PX = 2                 # the kernels reach so far
EVERY = 5                  # noise is measured in every fifth frame
CLIPPED = 8.0              # noise is clipped this near to black and to white, in gray levels
NOISE_RATE = 0.3           # weight of a new measurement in the running mean
GRAY = np.array([0.114, 0.587, 0.299])  # weights of blue, green and red in OpenCV's gray
UNIT = 32.0                # standard deviation of the stored noise, in gray levels
MIDDLE = 128               # mean of the stored noise
SHIFTS = 61                # the stored noise is moved by fewer pixels than this from frame to frame
DRAWN = 2**16              # so many numbers of a normal distribution are drawn; noise repeats them
BLOCK_PX = 128             # stored noise is made in sizes that are multiples of this


class Grain:
    """Measures the grain of frames, and gives it to the picture.

    ``softness``: (2,) square pixels, how much the variance of the frame's edges, across and down, exceeds that
    of a painted picture. ``noise``: the standard deviations of the noise of a color and of gray, gray levels.
    """

    def __init__(self) -> None:
        self._random = np.random.RandomState(0)
        self._stored: list[Image] = []
        self.reset()

    def reset(self) -> None:
        """Forget what was measured."""
        self.softness: Floats | None = None
        self.noise: Floats | None = None
        self._count = 0

    def measure(self, frame: Image, window: Image, tags: Sequence[Tag]) -> None:
        """Take in a frame, (h, w, 3) BGR uint8. ``window``: its part with the wall. ``tags``: those in it."""
        if self.softness is None or self._count % EDGES_EVERY == 0:
            self.softness = _mean(self.softness, edge_variance(frame, tags), RATE, OWN_VARIANCE)
        if self._count % EVERY == 0:
            self.noise = _mean(self.noise, noise_of(window), NOISE_RATE)
        self._count += 1

    def apply(self, picture: Image, mask: Image) -> tuple[Image, Image]:
        """A warped picture, as soft and noisy as the frame, and its mask, which is as soft.

        ``picture``: (h, w, 3) or (h, w, 4), uint8. ``mask``: (h, w, 3). The result is BGRA, so that it is mixed
        in softly. Its own alpha is white, since the returned mask contains the picture's alpha.
        """
        colors = picture
        if picture.shape[2] == 4:
            colors, alpha = picture[:, :, :3], cv2.cvtColor(picture[:, :, 3], cv2.COLOR_GRAY2BGR)
            mask = cv2.multiply(mask, alpha, scale=1 / 255)
        if self.softness is not None and self.softness.max() > MIN_VARIANCE:
            colors, mask = binding.soften_picture(colors, mask, *np.sqrt(np.maximum(self.softness, 0)))
        return cv2.cvtColor(self.noisy(colors), cv2.COLOR_BGR2BGRA), mask

    def noisy(self, picture: Image) -> Image:
        """A picture, (h, w, 3) uint8, with the camera's noise."""
        if self.noise is None or not picture.size:
            return picture
        color, gray = self.noise**2
        # Each color has noise of its own and noise in common. Gray is the weighted sum of the colors.
        own = np.clip((color - gray) / (1 - (GRAY**2).sum()), 0, color)
        for stored, deviation in zip(self._noise_for(picture), np.sqrt([own, color - own])):
            if deviation > 0.1:
                picture = cv2.addWeighted(picture, 1, stored, deviation / UNIT, -MIDDLE * deviation / UNIT)
        return picture

    def _noise_for(self, picture: Image) -> list[Image]:
        """Two images of noise for a picture: one differs between the colors, one is common to them."""
        height, width = picture.shape[:2]
        if not self._stored or self._stored[0].shape[0] < height + SHIFTS or \
                self._stored[0].shape[1] < width + SHIFTS:
            rows, columns = (-(-length // BLOCK_PX) * BLOCK_PX + SHIFTS for length in (height, width))
            self._stored = [_normal(self._random, rows, columns, 3),
                            cv2.cvtColor(_normal(self._random, rows, columns, 1), cv2.COLOR_GRAY2BGR)]
        y, x = self._random.randint(0, SHIFTS, 2)
        return [stored[y:y + height, x:x + width] for stored in self._stored]


def edge_variance(frame: Image, tags: Sequence[Tag]) -> Floats | None:
    """(2,) square pixels: the variance of the blur across and down, as the edges of tags show it, or None.

    ``frame``: (h, w, 3) BGR uint8. Let p go from 0 to 1 across an edge that a normal distribution blurs. Then
    the integral of p(1 - p) is the standard deviation divided by the root of pi. It hardly depends on noise,
    nor on where exactly the edge is.
    """
    corners = np.array([tag.corners for tag in tags], np.float64).reshape(-1, 4, 2)
    begin, end = corners.reshape(-1, 2), corners[:, [1, 2, 3, 0]].reshape(-1, 2)
    lengths = np.linalg.norm(end - begin, axis=1)
    largest = np.argsort(-lengths)[:MAX_SIDES]
    largest = largest[lengths[largest] > MIN_CELL_PX * CELLS]
    if not len(largest):
        return None
    begin, end, lengths = begin[largest], end[largest], lengths[largest]
    along = (end - begin) / lengths[:, None]
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1)  # corners are clockwise in the frame
    reach = REACH * lengths / CELLS
    offsets = np.linspace(-1, 1, STEPS)
    on_side = begin[:, None] + ALONG[:, None] * (end - begin)[:, None]                    # (n, m, 2)
    places = on_side[:, :, None] + (reach[:, None] * offsets)[:, None, :, None] * outward[:, None, None]
    seen = cv2.remap(frame, places.reshape(-1, STEPS, 2).astype(np.float32), NO_ARRAY, cv2.INTER_LINEAR)
    profiles = (seen @ GRAY).reshape(len(lengths), len(ALONG), STEPS)
    few = STEPS // 6
    black, white = profiles[..., :few].mean(axis=2), profiles[..., -few:].mean(axis=2)
    contrast = white - black
    part = (profiles - black[..., None]) / np.maximum(contrast, 1)[..., None]
    width = (part * (1 - part)).sum(axis=2) * (offsets[1] - offsets[0]) * reach[:, None]
    width[contrast < MIN_CONTRAST] = np.inf
    count = np.isfinite(width).sum(axis=1)
    known = count >= len(ALONG) // 2
    if not known.any():
        return None
    medians = np.sort(width, axis=1)[known, count[known] // 2]  # the medians of the finite widths
    cells = lengths[known] / CELLS
    deviations = cells * np.interp(np.sqrt(np.pi) * medians / cells, SEEN, TRUE)
    return _across_and_down(outward[known]**2, deviations**2, lengths[known])


def _across_and_down(shares: Floats, variances: Floats, weights: Floats) -> Floats:
    """(2,): the variances across and down that explain n variances measured along other directions.

    ``shares``: (n, 2), the squares of these directions' components. If the directions do not tell the two
    apart, both results are the same.
    """
    matrix = (shares * weights[:, None]).T @ shares
    matrix += SAME * np.trace(matrix) * np.array([[1, -1], [-1, 1]])
    return np.maximum(np.linalg.solve(matrix, (shares * weights[:, None]).T @ variances), 0)


def noise_of(window: Image) -> Floats | None:
    """(2,): the standard deviations of the noise of a color and of gray, or None if nothing shows it.

    ``window``: (h, w, 3) BGR uint8.
    """
    height, width = window.shape[:2]
    if min(height, width) < PATCH_PX:
        return None
    rows, columns = ((np.linspace(0, length - PATCH_PX, PATCHES).astype(int)[:, None]
                      + np.arange(PATCH_PX)).ravel() for length in (height, width))
    patches = window[rows[:, None], columns].astype(np.float32)
    means = _in_patches(patches).mean(axis=(1, 2, 3))
    shown = (means > CLIPPED) & (means < 255 - CLIPPED)
    if not shown.any():
        return None
    gray = cv2.transform(patches, GRAY[None])
    slopes = np.abs(cv2.Sobel(gray, cv2.CV_32F, 1, 0)) + np.abs(cv2.Sobel(gray, cv2.CV_32F, 0, 1))
    slopes = _inner(slopes)[shown]
    few = int(CALM_SHARE * slopes.shape[1])
    calm = np.argpartition(slopes, few)[:, :few]
    found = _deviations(patches, KERNEL, shown, calm)
    if found[0] > LITTLE:
        wide = _deviations(patches, WIDE, shown, calm)
        if wide[0] < MOSAIC * found[0]:
            return wide
    return found


def _deviations(patches: Image, kernel: Image, shown: Booleans, calm: Integers) -> Floats:
    """(2,): the standard deviations of a color and of gray, by a kernel.

    ``shown``: (n,), which patches count. ``calm``: for each of these, the numbers of the pixels that do.
    """
    rest = np.asarray(cv2.filter2D(patches, -1, kernel), np.float32)
    planes = [*cv2.split(rest), cv2.transform(rest, GRAY[None])]
    values = np.abs(np.stack([np.take_along_axis(_inner(plane)[shown], calm, axis=1) for plane in planes]))
    few = int(SHARE * values.shape[2])
    deviations = np.median(np.partition(values, few, axis=2)[:, :, few], axis=1) / WITHIN
    return np.array([deviations[:3].mean(), deviations[3]])


def _inner(image: Image) -> Floats:
    """(n, m): the pixels of each patch of an image, (h, w), but for its rim, where it meets another patch."""
    inner = _in_patches(image)[:, RIM_PX:-RIM_PX, RIM_PX:-RIM_PX]
    return np.asarray(inner.reshape(PATCHES**2, -1), np.float32)


def _in_patches(image: Image) -> Image:
    """(PATCHES**2, PATCH_PX, PATCH_PX, ...): the patches of an image that consists of them."""
    return image.reshape(PATCHES, PATCH_PX, PATCHES, PATCH_PX, -1).swapaxes(1, 2) \
        .reshape(PATCHES**2, PATCH_PX, PATCH_PX, -1)


def _mean(before: Floats | None, now: Floats | None, rate: float, less: float = 0.0) -> Floats | None:
    """The running mean, updated by a new value unless that is None. ``less`` is subtracted from the value."""
    if now is None:
        return before
    now = now - less
    return now if before is None else before + rate * (now - before)


def _normal(random: np.random.RandomState, rows: int, columns: int, channels: int) -> Image:
    """(rows, columns, channels) uint8: noise. It is drawn from few numbers, which is much faster."""
    values = np.clip(np.round(random.normal(MIDDLE, UNIT, DRAWN)), 0, 255).astype(np.uint8)
    return np.asarray(values[random.randint(0, DRAWN, (rows, columns, channels), np.uint16)])
