"""What the wall looks like, tags included, which locates the area while the tags alone do not.

It is learned while the tags are in sight. Some points of the wall are chosen that
differ from their neighborhood, and the patches around them are remembered. In a
later frame, the area is rectified as it is expected, and all patches are aligned
with it at once, from coarse to fine. Blur hides what is fine, so it does little
harm.

A point that is not on a tag is used only after tags have confirmed that it stays
in its place. So a screen, a passer-by, or a shadow does not lead the tracker
astray. A point on a tag's rim, or on its paper, must be confirmed once, since it
may be that of a hand that is about to cover the tag.
"""
from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.compiled import binding
from aruco_ar.geometry.homography import UNIT_SQUARE, homography_to, transform
from aruco_ar.geometry.lens import Lens
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.walls.remembered import Look

from .template import PAPER_SIDES, Template

MAX_POINTS, MAX_TAG_POINTS = 80, 40  # on the wall, and on tags
QUALITY, MIN_DISTANCE_PX = 0.02, 7   # limits for the choice of points: see cv2.goodFeaturesToTrack
SMOOTH_PX = 6            # contrast is that with the mean around, so that shadows and exposure do not matter
MIN_CONTRAST = 1.0       # a wall with a lower contrast, in gray levels, shows noise alone
# The correlation of a patch with what is seen. A point needs the first to be confirmed. The second is enough to
# use it: motion may blur the frame, and most points have to fit together then.
CONFIRMING_LIKENESS, USABLE_LIKENESS = 0.75, 0.5
STAYS_PX = 1.0           # a point that is farther off, in pixels of the template, is not on the wall
MIN_CONFIRMED = 2        # a point is used after tags have confirmed it this many times
WITHIN_SIDES = 0.8       # a point in so much of a tag is used at once: what covers more would hide the tag
OUTLIER_PX = 1.5         # a patch that alone is farther off than all together is left out; pixels of its level
MIN_POINTS, MIN_SHARE = 10, 0.4  # this many points, and this share of those in sight, must fit together
# A larger share must fit if they are found farther than this from where they are expected, or if this is not
# known well: in a regular pattern, many look like their neighbors. In pixels of the template.
FAR_PX, FAR_SHARE = 5.0, 0.62
# If they are expected more exactly than this, in pixels of the template, the coarsest levels are left out.
NEAR_PX, NEAR_LEVEL, FAR_LEVEL = 1.5, 1, binding.WALL_LEVELS - 1
FITTING_LEVELS = 2       # in a still coarser level, walls look alike
MIN_LEFT = 0.4           # if a smaller share of the learned points is left, the wall is learned anew
SHARPER = 1.3            # if the frame's contrast is this many times the learned one, the wall is learned anew
ERROR_PX = 0.15          # the least common error of points that fit together, in pixels of the frame
INDEPENDENT_POINTS = 8   # as for that error, all points count as much as this many: neighbors err alike
OVERLAP = 2.0            # by so much the variance of each point counts more, since patches overlap
CHECKS_S = 0.1, 0.2, 0.3, 0.5, 1.0, 2.0  # the times between checks after learning; the last one repeats
LEARN_AGAIN_S = 1.0      # the wait before the wall is learned anew
MEAN_OF = 20             # a point's place is the running mean of about this many checks


class _Points(NamedTuple):
    """Points of the wall. All is in their order.

    ``seen``: (n, 2) pixels of the template, where they were learned. ``places``: (n, 2), in the plane of the
    area. ``patches``: see binding.learn_patches. ``on_tags``: (n,), which are on a tag. ``confirmed``: (n,),
    how often tags have confirmed each.
    """

    seen: Floats
    places: Floats
    patches: Floats
    on_tags: Booleans
    confirmed: Floats

    def chosen(self, which: Booleans) -> _Points:
        return _Points(self.seen[which], self.places[which], np.ascontiguousarray(self.patches[:, which]),
                       self.on_tags[which], self.confirmed[which])


class _Fit(NamedTuple):
    """Where the points were found in a frame.

    ``corners``: (4, 2) pixels, the area's. ``good``: (n,) bool, the points that fit. ``moved``: pixels of the
    template, how far off the expected corners were, at most. ``off``: pixels of the template, the root mean
    square by which each of the points alone is off.
    """

    corners: Floats
    good: Booleans
    moved: float
    off: float


class Texture:
    """Learns the look of a wall, and finds it in later frames."""

    def __init__(self, lens: Lens | None = None) -> None:
        """``lens``: the Lens of the frames, or None. With a lens, positions are undistorted pixels."""
        self._lens = lens
        self._due = -np.inf
        self._points: _Points | None = None
        self._image: Image  # the area, from straight ahead, in the frame in which it was learned
        self._is_draft = False  # whether it is learned anew when possible: see study, and ``remembered``

    @classmethod
    def remembered(cls, look: Look, lens: Lens | None) -> Texture:
        """The texture that was learned once. Raises InputError if the look's image does not have its size."""
        self = cls(lens)
        self._template, self._image, self._bias = Template(look.inner, lens), look.image, look.bias
        if look.image.shape[::-1] != self._template.size:
            raise InputError('The look of a wall is %d x %d pixels large, and should be %d x %d. Save the wall '
                             'again.' % (*look.image.shape[::-1], *self._template.size))
        self._points = _Points(
            look.points, look.places,
            binding.learn_patches(np.asarray(look.image, np.float32), self._template.relative(look.points)),
            look.on_tags, np.full(len(look.points), MIN_CONFIRMED))
        self._is_draft = True
        return self

    @property
    def look(self) -> Look | None:
        """What is to be remembered; None if too little has been learned."""
        if self._points is None:
            return None
        points = self._points.chosen(self._points.confirmed >= MIN_CONFIRMED)
        if len(points.seen) < MIN_POINTS:
            return None
        return Look(self._image, self._template.inner, points.seen, points.places, points.on_tags, self._bias)

    def is_due(self, now: float) -> bool:
        """Whether ``study`` has something to do at that time, seconds."""
        return now >= self._due

    def study(self, frame: Image, corners: Floats, tags: Floats, deviation: float, now: float,
              is_first: bool = False) -> None:
        """Learn the wall, or check its points, in a frame in which tags show the area.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8. ``corners``: (4, 2)
        pixels, the area's. ``tags``: (n, 4, 2) pixels, the corners of the tags.
        ``deviation``: pixels, the standard deviation of the corners. ``now``:
        seconds, a time at which it is due. ``is_first``: whether the tags were
        not followed yet, so that they are known less exactly. What is learned
        then is of use only until the next time, when the wall is learned anew.
        """
        self._due = now + LEARN_AGAIN_S
        if self._is_draft and not Template.fits(corners):
            return  # so small an area shows less than what is remembered
        if self._points is None or self._is_draft:
            self._points, self._bias = self._learn(frame, corners, tags), deviation
            self._is_draft = is_first
        else:
            self._points = self._confirm(self._points, frame, corners)
        if is_first:
            self._due = now
        elif self._points is not None:
            self._due = now + CHECKS_S[min(self._checks, len(CHECKS_S) - 1)]

    def find(self, frame: Image, corners: Floats, deviation: float,
             is_blurred: bool) -> tuple[Floats, Floats, Floats, Floats] | None:
        """Find the learned points in a frame, in which the area is expected at corners, (4, 2) pixels.

        ``deviation``: pixels, the standard deviation of these corners. ``is_blurred``: whether the frame may be
        blurred. Returns a measurement for AreaMotion.correct: the first four arguments, of n points, n being a
        multiple of four. It is None if too few points are recognized.
        """
        points = self._points
        if points is None:
            return None
        usable = points.confirmed >= MIN_CONFIRMED
        if np.count_nonzero(usable) < MIN_POINTS:
            return None
        usable &= self._template.in_sight(points.seen, corners, frame.shape)
        scale = self._template.scale(corners)
        rectified = self._template.rectified(frame, corners)
        found = self._fit(points, frame, rectified, corners, usable, deviation, is_blurred)
        on_wall = usable & ~points.on_tags
        if found is None and MIN_POINTS <= np.count_nonzero(on_wall) < np.count_nonzero(usable):
            # The tags may be covered, or taken down.
            found = self._fit(points, frame, rectified, corners, on_wall, deviation, is_blurred)
        if found is None:
            return None
        count = np.count_nonzero(found.good) // 4 * 4
        places = points.places[found.good][:count]
        error = np.sqrt(ERROR_PX**2 * count / INDEPENDENT_POINTS + OVERLAP * (scale * found.off)**2)
        return (places, transform(homography_to(found.corners), places), np.full(count, error),
                np.full(count, self._bias))

    def _fit(self, points: _Points, frame: Image, rectified: Floats, corners: Floats, usable: Booleans,
             deviation: float, is_blurred: bool) -> _Fit | None:
        """Find the usable points, (n,) bool, in a frame. For the other arguments see find and _align."""
        scale, found = self._template.scale(corners), None
        if deviation < NEAR_PX * scale and not is_blurred:
            found = self._align(points, rectified, corners, usable, NEAR_LEVEL, False)
        if found is None:
            found = self._align(points, rectified, corners, usable, FAR_LEVEL, deviation > FAR_PX * scale)
        if found is not None and found.moved > FAR_PX:  # once more, so that no patch is turned or resized
            rectified = self._template.rectified(frame, found.corners)
            found = self._align(points, rectified, found.corners, usable, NEAR_LEVEL, True)
        return found

    def _align(self, points: _Points, rectified: Floats, corners: Floats, usable: Booleans, coarsest: int,
               is_far: bool) -> _Fit | None:
        """Align the usable points, (n,) bool, with a frame, as finely as it shows them.

        ``rectified``: the frame, by ``corners``, for which see find. ``coarsest``: the level to begin with.
        ``is_far``: whether the corners may be far off.
        """
        template = self._template
        warps, likeness, off = binding.align_patches(
            rectified, points.patches, template.relative(template.from_plane(points.places)), usable, coarsest)
        length = np.hypot(off[..., 0], off[..., 1])
        good = usable & (likeness > USABLE_LIKENESS) & (length < OUTLIER_PX)
        counts, count = good.sum(axis=1).tolist(), np.count_nonzero(usable)
        expected = template.from_plane(UNIT_SQUARE)
        for level in range(FITTING_LEVELS):
            if counts[level] < max(MIN_POINTS, MIN_SHARE * count):
                continue
            seen = template.absolute(transform(warps[level], template.relative(expected)))
            moved = float(np.linalg.norm(seen - expected, axis=1).max())
            seen = transform(homography_to(corners), template.to_plane(seen))
            is_near = moved < FAR_PX and not is_far
            if (is_near or counts[level] >= FAR_SHARE * count) and is_quadrilateral(seen):
                squares = length[level, good[level]]**2
                return _Fit(seen, good[level], moved, 2**level * float(np.sqrt(squares.mean())))
        return None

    def _learn(self, frame: Image, corners: Floats, tags: Floats) -> _Points | None:
        """Choose points in a frame; None if there are too few."""
        if not Template.fits(corners):
            return None
        self._template = template = Template.of(corners, self._lens)
        inside = template.draw_inside(corners, frame.shape)
        papers = cv2.bitwise_and(template.draw_tags(tags, corners, PAPER_SIDES), inside)
        self._wall_region = cv2.subtract(inside, papers)
        rectified = template.rectified(frame, corners)
        self._image = np.asarray(rectified, np.uint8)
        self._contrast, self._checks = self._contrast_of(rectified), 0
        seen = on_tags = _points_in(rectified, papers, MAX_TAG_POINTS)
        if self._contrast >= MIN_CONTRAST:
            seen = np.concatenate([on_tags, _points_in(rectified, self._wall_region, MAX_POINTS)])
        self._learned = len(seen)
        is_on_tag = np.arange(len(seen)) < len(on_tags)
        columns, rows = np.asarray(seen, int).T
        is_within = template.draw_tags(tags, corners, WITHIN_SIDES)[rows, columns] > 0
        confirmed = np.where(is_within, MIN_CONFIRMED, np.where(is_on_tag, MIN_CONFIRMED - 1, 0))
        patches = binding.learn_patches(rectified, template.relative(seen))
        return _Points(seen, template.to_plane(seen), patches, is_on_tag, confirmed) if len(seen) else None

    def _confirm(self, points: _Points, frame: Image, corners: Floats) -> _Points | None:
        """The points without those that are not in their places; None if the wall should be learned anew."""
        template = self._template
        rectified, in_sight = template.rectified(frame, corners), template.in_sight(
            points.seen, corners, frame.shape)
        _, (likeness, *_), (off, *_) = binding.align_patches(
            rectified, points.patches, template.relative(template.from_plane(points.places)), in_sight, 0, True)
        stays = in_sight & (likeness > CONFIRMING_LIKENESS) & (np.hypot(off[:, 0], off[:, 1]) < STAYS_PX)
        confirmed = points.confirmed + stays
        # The mean includes the places by the first frame, which are no more exact than the others.
        share = np.where(stays, 1 / np.minimum(confirmed + 1, MEAN_OF), 0)
        places = points.places - share[:, None] * off / template.inner
        points = points._replace(places=places, confirmed=confirmed).chosen(stays | ~in_sight)
        self._checks += 1
        is_enough = len(points.seen) >= max(MIN_POINTS, MIN_LEFT * self._learned)
        return points if is_enough and self._contrast_of(rectified) <= SHARPER * self._contrast else None

    def _contrast_of(self, rectified: Floats) -> float:
        """The contrast of the wall between the tags in a rectified frame, in gray levels."""
        fine = rectified - cv2.GaussianBlur(rectified, (0, 0), SMOOTH_PX)
        count = max(cv2.countNonZero(self._wall_region), 1)
        return float(cv2.norm(fine, cv2.NORM_L2, self._wall_region) / np.sqrt(count))


def _points_in(image: Floats, region: Image, most: int) -> Floats:
    """(n, 2) float32: points of a gray image that differ from what is around them, where a region is white."""
    points = cv2.goodFeaturesToTrack(image, most, QUALITY, MIN_DISTANCE_PX, mask=region, blockSize=5)
    return np.empty((0, 2), np.float32) if points is None else np.asarray(points, np.float32).reshape(-1, 2)
