"""Real clips in which something covers a part of a tag: a thing that slides over its rim, or lies there.

The clip, its tags and their paper are real. What is covered is known exactly, so each frame is compared with
what is found in the same clip without the cover. Only the four tags count as tags.
"""
import os
from copy import copy, deepcopy
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from aruco_ar.base.progress import progress, tell
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.tracking.area_tracker import AreaTracker
from aruco_ar.tracking.tag_search import TagSearch
from rig import PACKAGE

from .clips import corners_by

COVERED_S, AFTER_S = 1.5, 1.0  # how long something covers a tag, and how long the clip is watched after that
# How far a thing reaches over a tag, in its sides: one that slides goes that far and back, others lie still.
SLIDES, LIES = 0.33, (0.06, 0.11)
REACH = 1.0                    # how far it reaches beyond the tag, in sides of the tag
WAVES, WAVE = 3.0, 0.012       # of its edge: waves a side, and their height in sides
EDGE_PX = 0.8                  # the blur of its edge
FROM = {'below': (0, 1), 'the right': (1, 0), 'a corner': (0.7, 0.71)}  # unit vectors in the tag's plane
COLORS = {'skin': (120, 150, 200), 'white': (215, 215, 215), 'dark': (45, 45, 45), 'picture': None}
OFF_PX, FAR_OFF_PX = 0.5, 2.0


@dataclass(frozen=True)
class Cover:
    """What covers tags: its ``color``, from where it comes, and its ``depth`` if it lies still, or None."""

    color: str
    side: str
    depth: float = None

    def depth_at(self, passed):
        """How far it reaches over the tag after that time, seconds; 0 if it does not."""
        if not 0 <= passed < COVERED_S:
            return 0.0
        return self.depth or SLIDES * np.sin(np.pi * passed / COVERED_S)

    def put(self, frame, quad, depth):
        """Cover a tag, (4, 2) pixels, in a frame, (h, w, 3), which changes. ``depth``: see depth_at."""
        outward, across = np.array(FROM[self.side]), np.array(FROM[self.side])[::-1] * (1, -1)
        along = np.linspace(-1, 1, 41)
        wavy = WAVE * np.sin(2 * np.pi * WAVES * along)
        # The farthest point of the tag in that direction, from its middle.
        rim = np.abs(outward).sum() / 2 - depth
        edge = 0.5 + np.outer(rim + wavy, outward) + np.outer(along, across)
        far = 0.5 + (rim + REACH) * outward + np.array([[1], [-1]]) * across
        pixels = transform(homography_to(quad), np.concatenate([edge, far]))
        low = np.maximum(np.floor(pixels.min(axis=0)).astype(int) - 4, 0)
        high = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + 5, frame.shape[1::-1])
        width, height = high - low
        if width <= 0 or height <= 0:
            return
        mask = np.zeros((4 * height, 4 * width), np.uint8)
        cv2.fillPoly(mask, [np.round((pixels - low + 0.5) * 4 * 16).astype(np.int32)], 255, cv2.LINE_8, 4)
        mask = cv2.resize(mask, (width, height), interpolation=cv2.INTER_AREA)
        share = cv2.GaussianBlur(mask, (0, 0), EDGE_PX)[..., None] / 255.0
        window = frame[low[1]:high[1], low[0]:high[0]]
        window[:] = np.round(share * self._colors(width, height) + (1 - share) * window)

    def _colors(self, width, height):
        """(h, w, 3) BGR: what it looks like."""
        if COLORS[self.color] is None:
            picture = cv2.imread(os.path.join(PACKAGE, 'images', 'earth.jpg'))
            return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
        noise = cv2.GaussianBlur(np.random.RandomState(0).normal(0, 60, (height, width, 1)), (0, 0), 5)
        return np.clip(np.array(COLORS[self.color]) + noise.reshape(height, width, 1), 0, 255)


class Following:
    """A tracker for which only the four tags of a clip are tags."""

    def __init__(self, clip):
        self._search, self.tracker = TagSearch(clip.dictionary, ids=clip.ids), AreaTracker(clip.ids)

    def copy(self):
        """Another one that has seen the same."""
        other = copy(self)
        other.tracker = deepcopy(self.tracker)
        return other

    def corners(self, frame, stamp):
        """(4, 2): the area's corners in a frame, NaN without an area."""
        return corners_by(self.tracker, self._search, frame, stamp)


COVERS = [Cover(color, side, depth) for color, side, depth in product(COLORS, FROM, (None, *LIES))]


@dataclass(frozen=True)
class Plain:
    """What is found in a clip without covers.

    ``corners``: (n, 4, 2), the area's, NaN without one. ``tags``: for each frame, {id: (4, 2) pixels}.
    ``followings``: {frame: Following}, as they were before the first frame that has an area, and before the
    middle of the clip, where the wall is learned.
    """

    corners: np.ndarray
    tags: list
    followings: dict

    @classmethod
    def of(cls, clip, frames, rate):
        following, corners, tags, followings = Following(clip), [], [], {}
        for number, frame in enumerate(frames):
            before = following.copy() if not followings or number == len(frames) // 2 else None
            corners.append(following.corners(frame, number / rate))
            if before is not None and not np.isnan(corners[-1]).any():
                followings[number] = before
            tags.append({tag.id: tag.corners for tag in following.tracker.tags})
        return cls(np.array(corners), tags, followings)


def run_covered(clip, frames, rate, plain, start, cover, ids):
    """(n,) pixels: how far off a corner is at most in the frames from ``start`` on, while a cover is on tags.

    It is infinite in a frame that has lost its area, and NaN where there is none without the cover, either.
    ``plain``: Plain. ``ids``: the tags that are covered.
    """
    following, errors = plain.followings[start].copy(), []
    for number in range(start, min(start + int((COVERED_S + AFTER_S) * rate), len(frames))):
        depth, frame = cover.depth_at((number - start) / rate), frames[number]
        if depth:
            frame = frame.copy()
            for tag_id in set(ids) & set(plain.tags[number]):
                cover.put(frame, plain.tags[number][tag_id], depth)
        corners = following.corners(frame, number / rate)
        off = np.linalg.norm(corners - plain.corners[number], axis=1).max()
        is_lost = np.isnan(corners).any() and not np.isnan(plain.corners[number]).any()
        errors.append(np.inf if is_lost else off)
    return np.array(errors)


def measure(clip, covers):
    """Print the rows of a clip."""
    frames, rate = clip.frames()
    plain = Plain.of(clip, frames, rate)
    for (number, start), count in product(enumerate(plain.followings), (1, 2)):
        errors = np.concatenate([
            run_covered(clip, frames, rate, plain, start, cover, np.roll(clip.ids, turn)[:count].tolist())
            for turn, cover in enumerate(covers)])
        errors = errors[~np.isnan(errors)]
        shown = errors[np.isfinite(errors)]
        tell('%-12s %-12s %4d %8d %7.1f %% %7.1f %% %7.1f %% %7.2f %6.1f' % (
            os.path.basename(clip.path), 'middle' if number else 'first sight', count, len(errors),
            100 * np.mean(np.isinf(errors)), 100 * np.mean(shown > OFF_PX), 100 * np.mean(shown > FAR_OFF_PX),
            np.sqrt(np.mean(shown**2)), shown.max()))


def run(clips):
    """Print the table of some Clips."""
    print('\nA thing slides over a part of tags, or lies there, for %g s: from the first frame with an area\n'
          'on, or after the wall was learned. The clip is compared with itself without the thing, also for\n'
          '%g s after that. lost: no area, though there was one. off: a corner is off by more than %g px.\n'
          'far off: by more than %g px. Errors are in pixels.\n\n%-12s %-12s %4s %8s %9s %9s %9s %7s %6s' % (
              COVERED_S, AFTER_S, OFF_PX, FAR_OFF_PX, '', 'from', 'tags', 'frames', 'lost', 'off', 'far off',
              'rms', 'worst'))
    for clip in progress(clips, 'clips'):
        measure(clip, COVERS)
