"""The picture in the area: whether it is there, and if not, what was done instead."""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import permutations
from typing import Iterator, NamedTuple, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Booleans, Floats, Image

from aruco_course.check import Fault, View

from .areas import (
    NOISE,
    RIM_PX,
    Sight,
    changed,
    crossing_orders,
    fill,
    ids_text,
    other_shapes,
    outside_of,
    where,
)
from .drawing import brightest, darkest, place_of
from .views import course_detect

SIZES = (240, 320), (300, 300), (400, 230)  # width and height of the pictures, which are not those of the areas
PICTURE_SLACK = 20    # gray levels that a pixel of the picture may be beyond all those around its place
WRONG = 0.02          # share of the area in which the picture may be wrong
TOUCHED = 0.0005      # share of the frame that may be changed outside of the area
LIKE = 0.35           # an explanation differs from the image at most so many times as much as what is right
CLEARLY = 0.95        # a later explanation differs at most so many times as much as the best one before
SURELY = 0.1          # an explanation that differs less than that is right
SHRINK = 4            # explanations are compared in images so many times smaller
FLAT = 8              # gray levels that the least difference worth an explanation has, where it is
DARK = 8              # gray levels up to which a pixel counts as black


@lru_cache(maxsize=None)
def own_picture(number: int = 0) -> Image:
    """A picture, (h, w, 3) BGR uint8, that looks different if it is turned, mirrored or has other colors."""
    width, height = SIZES[number % len(SIZES)]
    picture = np.zeros((height, width, 3), np.uint8)
    half_width, half_height = width // 2, height // 2
    colors = (60, 60, 215), (70, 165, 60), (60, 205, 235), (190, 90, 40)  # red, green, yellow, blue
    for corner, color in zip(((0, 0), (half_width, 0), (0, half_height), (half_width, half_height)), colors):
        cv2.rectangle(picture, corner, (corner[0] + half_width, corner[1] + half_height), color, -1)
    wave = 18 * np.sin(np.arange(width) / 7)[None, :] + 12 * np.sin(np.arange(height) / 11)[:, None]
    picture = np.clip(picture + wave[..., None], 0, 255).astype(np.uint8)
    unit = min(width, height) / 10
    cv2.putText(picture, 'TOP', (int(0.6 * unit), int(2.2 * unit)), cv2.FONT_HERSHEY_DUPLEX, unit / 17,
                (255, 255, 255), max(1, round(unit / 9)), cv2.LINE_AA)
    black = np.array([[0.58, 0.56], [0.95, 0.56], [0.95, 0.68], [0.72, 0.68], [0.72, 0.73], [0.88, 0.73],
                      [0.88, 0.84], [0.72, 0.84], [0.72, 0.96], [0.58, 0.96]]) * (width, height)  # an F
    cv2.fillPoly(picture, [black.astype(np.int32)], (0, 0, 0))
    picture.flags.writeable = False
    return picture


def with_pictures(views: Sequence[View]) -> tuple[View, ...]:
    """The Views, each with a picture."""
    return tuple(replace(view, picture=own_picture(number)) for number, view in enumerate(views))


def picture_fault(sight: Sight, before: Sequence[Sight]) -> Fault | None:
    """Why a View's picture is not painted into its area, or None. ``before``: the Sights before it."""
    if is_painted(sight):
        return None
    shown, canvas, fault = sight.shown, _canvas_of(sight), sight.drawing.fault
    wrong, touched = _wrong(canvas, sight), _touched(sight)
    inside_wrong = np.mean(wrong[sight.inside]) > WRONG
    if fault is not None and 'wide' in fault.what:
        return fault
    expected = canvas.painted()
    marked = wrong | touched
    what = _explanation(sight, before)
    if not what and fault is not None:
        return fault
    if not what and inside_wrong and _is_plain(sight):
        what = 'The area is of one color only, and there is no picture in it.'
    if not what and inside_wrong:
        share = np.mean(wrong[sight.inside])
        what = ('The picture is not in the area as it should be%s. Each of its corners goes to the center at '
                'the same corner of the area, and it fills the area.'
                % ('' if share > 0.4 else ', as can be seen ' + where(wrong, sight)))
    if not what:
        what = ('Your image is changed outside of the area, too, %s of it. The rest of the frame stays as it '
                'is.'
                % where(touched, sight))
    return Fault(what, place_of(shown), shown, expected, marked)


def is_painted(sight: Sight) -> bool:
    """Whether a View's picture is in its area, and nothing else is changed."""
    wrong = _wrong(_canvas_of(sight), sight)
    return bool(np.mean(wrong[sight.inside]) <= WRONG and np.mean(_touched(sight)) <= TOUCHED)


def _touched(sight: Sight) -> Booleans:
    """(h, w): where the frame is changed outside of the area, and not at the tags."""
    return np.asarray(changed(sight.drawing.image, sight.drawing.frame) & sight.outside & ~sight.near_tags)


@dataclass(frozen=True, eq=False)
class Canvas:
    """What an image is made of: the frame, (h, w, 3), the picture, (h, w, 3), and the area, (4, 2).

    ``fitted``: (width, height) of the true picture, of which the picture may be a smaller version.
    """

    frame: Image
    picture: Image
    area: Floats
    fitted: tuple[int, int]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frame."""
        return self.frame.shape[1], self.frame.shape[0]

    def to_area(self, width: float | None = None, height: float | None = None,
                order: Sequence[int] = (0, 1, 2, 3)) -> Floats:
        """(3, 3): the homography that takes a picture's corners to those of the area, in that order.

        ``width``, ``height``: the size that the picture is thought to have, by default its own.
        """
        width, height = width or self.fitted[0], height or self.fitted[1]
        across, down = self.picture.shape[1] / self.fitted[0], self.picture.shape[0] / self.fitted[1]
        corners = np.array([[0, 0], [width, 0], [width, height], [0, height]]) * (across, down)
        goals = np.asarray(self.area[list(order)], np.float32)
        return np.asarray(cv2.getPerspectiveTransform(np.asarray(corners, np.float32), goals), np.float64)

    def warped(self, homography: Floats, picture: Image | None = None) -> Image:
        """(h, w, 3): the picture, or another one, warped to the size of the frame, and black elsewhere."""
        return cv2.warpPerspective(self.picture if picture is None else picture, homography, self.size)

    @property
    def mask(self) -> Image:
        """(h, w, 3): white in the area."""
        return cv2.cvtColor(fill(self.frame.shape, self.area), cv2.COLOR_GRAY2BGR)

    @property
    def black(self) -> Image:
        """The frame with a black area."""
        return cv2.subtract(self.frame, self.mask)

    def painted(self) -> Image:
        """What is right."""
        return cv2.add(self.black, cv2.bitwise_and(self.warped(self.to_area()), self.mask))


class Explanation(NamedTuple):
    """What may have been done instead: a sentence, and the image that it makes."""

    what: str
    image: Image


def _canvas_of(sight: Sight) -> Canvas:
    picture = sight.shown.view.picture
    assert picture is not None, 'The view has a picture.'
    if np.array_equal(brightest(sight.drawing.image), darkest(sight.drawing.image)):
        picture = cv2.cvtColor(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
    height, width = picture.shape[:2]
    return Canvas(sight.drawing.frame, picture, sight.area, (width, height))


def _wrong(canvas: Canvas, sight: Sight) -> Booleans:
    """(h, w): where in the area the output is none of the picture's pixels that are near."""
    homography = canvas.to_area()
    # How many of the picture's pixels are within the rim's tolerance, where most are.
    height, width = canvas.picture.shape[:2]
    sides = np.linalg.norm(canvas.area - np.roll(canvas.area, -1, axis=0), axis=1)
    reach = [max(1, int(np.ceil(RIM_PX * length / max(min(pair), 1))))
             for length, pair in ((width, sides[[0, 2]]), (height, sides[[1, 3]]))]
    around = np.ones((2 * reach[1] + 1, 2 * reach[0] + 1), np.uint8)
    low, high = (canvas.warped(homography, near(canvas.picture, around)) for near in (cv2.erode, cv2.dilate))
    return outside_of(sight.drawing.image, low, high, PICTURE_SLACK) & sight.inside & ~sight.near_tags


def _is_plain(sight: Sight) -> bool:
    colors = sight.drawing.image[sight.inside & ~sight.near_tags].astype(int)
    return bool(np.mean(np.abs(colors - np.median(colors, axis=0)).max(axis=1) <= NOISE) > 0.9)


def _explanation(sight: Sight, before: Sequence[Sight]) -> str:
    """The sentence that says what was done instead of what is right, or nothing."""
    whole = _canvas_of(sight)
    canvas = _shrunk(whole)
    image = _small(sight.drawing.image)
    usual = _difference(image, canvas.painted())
    best, least = '', LIKE * usual
    for explanations in (_compositions(canvas), _by_pixels(whole), _arrangements(canvas, sight),
                         _others(canvas), _shapes(canvas, sight, before), _pairs(canvas, sight)):
        for what, seen in explanations:
            difference = _difference(image, seen)
            if difference < CLEARLY * least:
                best, least = what, difference
        if least < SURELY * usual:
            break  # simple mistakes come first, and some of the others look the same
    return best


def _difference(image: Image, other: Image) -> float:
    """How much two small images differ; single pixels of a rim count little."""
    difference = brightest(cv2.absdiff(cv2.blur(image, (3, 3)), cv2.blur(other, (3, 3))))
    return float(np.mean(np.clip(difference.astype(int) - FLAT, 0, 64)))


def _small(image: Image) -> Image:
    return cv2.resize(image, (image.shape[1] // SHRINK, image.shape[0] // SHRINK), interpolation=cv2.INTER_AREA)


def _shrunk(canvas: Canvas) -> Canvas:
    frame = _small(canvas.frame)
    scale = np.array(frame.shape[1::-1]) / canvas.size
    picture = canvas.picture
    room = 1.5 * max(np.ptp(canvas.area, axis=0) / SHRINK)
    if max(picture.shape[:2]) > room:
        factor = room / max(picture.shape[:2])
        picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    return Canvas(frame, picture, (canvas.area + 0.5) * scale - 0.5,
                  (canvas.fitted[0] * scale[0], canvas.fitted[1] * scale[1]))


# Where the picture's corners go, from its top left one, clockwise: to these corners of the area.
TURNS = {
    (1, 2, 3, 0): 'Your picture is turned by a quarter, clockwise: its top left corner is at the top right.',
    (2, 3, 0, 1): 'Your picture is upside down: it is turned by 180 degrees.',
    (3, 0, 1, 2): 'Your picture is turned by a quarter, counterclockwise: its top left corner is at the bottom '
                  'left.',
    (1, 0, 3, 2): 'Your picture is mirrored: its left and its right are exchanged.',
    (3, 2, 1, 0): 'Your picture is upside down and mirrored: its top and its bottom are exchanged.',
    (0, 3, 2, 1): 'Your picture is mirrored and turned: its rows are columns. Are x and y exchanged, '
                  "or do the picture's corners go the other way around?",
    (2, 1, 0, 3): 'Your picture is mirrored and turned: its top left corner is at the bottom right, and the '
                  'other two have stayed.',
}


def _orders(sight: Sight) -> Iterator[tuple[str, tuple[int, ...]]]:
    """All wrong orders of the area's corners, and what to say of them."""
    _, ids, _ = course_detect(sight.drawing.frame)
    found = ids, ids[:2] + ids[:1:-1]  # the picture's corners may be listed around, or row by row
    for order in permutations(range(4)):
        if order == (0, 1, 2, 3):
            continue
        goals = [sight.ids[corner] for corner in order]
        what = TURNS[order] if order in TURNS else (
            'Your picture is twisted: its corners go to the tags %s, in the order top left, top right, bottom '
            "right, bottom left. List the picture's corners and the centers in the same "
            'order.' % ids_text(goals))
        if goals in found:
            what += ' That is also the order in which the tags were found: are the centers in order?'
        yield what, order


def _arrangements(canvas: Canvas, sight: Sight) -> Iterator[Explanation]:
    for what, order in _orders(sight):
        warped = canvas.warped(canvas.to_area(order=order))
        yield Explanation(what, cv2.add(canvas.black, warped))
        yield Explanation(what, cv2.add(canvas.black, cv2.bitwise_and(warped, canvas.mask)))


def _blended(canvas: Canvas, warped: Image) -> Iterator[Explanation]:
    """What may be made of the frame and the warped picture other than what is right."""
    frame, mask = canvas.frame, canvas.mask
    yield Explanation('The picture is added to the wall, which shines through and makes it too bright. '
                      'Subtract the area first, as in exercise 5.5.', cv2.add(frame, warped))
    for share in 0.3, 0.5, 0.7:
        what = ('The picture is half transparent: the wall shines through. Make the area black first, as in '
                'exercise 5.5, then add the picture.')
        mixed = cv2.addWeighted(frame, 1 - share, warped, share, 0)
        yield Explanation(what, mixed)
        yield Explanation(what, np.where(mask > 0, mixed, frame))
        yield Explanation(what, cv2.addWeighted(frame, 1, warped, share, 0))
        yield Explanation('Your picture is too dark. Add all of it: the area is black already.',
                          cv2.add(canvas.black, np.asarray(share * warped, np.uint8)))
    yield Explanation('Only the picture is to be seen, and everything around it is black. Add it to the frame '
                      'of which the area was subtracted.', warped)
    yield Explanation('Only the area is left of your image, and the rest is black: the mask is the wrong way '
                      'around.',
                      cv2.add(cv2.bitwise_and(frame, mask), warped))
    yield Explanation('The picture is on a white area: the mask was added. Subtract it.',
                      cv2.add(cv2.add(frame, mask), warped))
    yield Explanation('The wall shines through the picture. Make the area black first, as in exercise 5.5, '
                      'then add the picture.', cv2.bitwise_or(frame, warped))
    yield Explanation('The wall shines through the picture. Make the area black first, as in exercise 5.5, '
                      'then add the picture.', cv2.max(frame, warped))


def _by_pixels(canvas: Canvas) -> Iterator[Explanation]:
    """What becomes of a picture whose black is taken for nothing, or whose white and black are passed.

    ``canvas``: not shrunk, since single pixels count.
    """
    warped = canvas.warped(canvas.to_area())
    wraps = ("NumPy's plus and minus begin again at 0 and 255. Subtract the mask with cv2.subtract, and add "
             'the picture with cv2.add.')
    yield Explanation(wraps, _small(canvas.frame + warped))
    yield Explanation(wraps, _small(canvas.frame - canvas.mask + warped))
    what = ('Where the picture is dark, the wall shines through. Make all of the area black before you add the '
            'picture.')
    for painted in (warped > 0, brightest(warped)[..., None] > 0, brightest(warped)[..., None] > 10):
        yield Explanation(what, _small(np.where(painted, warped, canvas.frame)))


def _recolored(canvas: Canvas) -> Iterator[tuple[str, Image]]:
    swapped = np.ascontiguousarray(canvas.picture[:, :, ::-1])
    yield "Your picture's colors are exchanged: its red is blue. OpenCV's images are blue, green, red.", swapped
    yield 'Your picture has no colors: it is gray.', _gray(canvas.picture)
    yield 'Your picture is a negative.', cv2.bitwise_not(canvas.picture)


def _compositions(canvas: Canvas) -> Iterator[Explanation]:
    yield from _blended(canvas, canvas.warped(canvas.to_area()))
    for what, picture in _recolored(canvas):
        yield Explanation(what, replace(canvas, picture=picture).painted())
    yield Explanation('The area is black, and there is no picture in it. Is the warped picture added? And do '
                      'its corners go to the centers in the same order?', canvas.black)
    yield Explanation('Your image is the frame as it came, and there is no picture in it. Is it the result '
                      'that you return?', canvas.frame)
    yield Explanation('The area is white, and there is no picture in it.', cv2.add(canvas.frame, canvas.mask))
    yield Explanation('Your image is black all over.', np.zeros_like(canvas.frame))


def _others(canvas: Canvas) -> Iterator[Explanation]:
    """Other ways to bring the picture to the area."""
    width, height = canvas.fitted
    black, mask, (frame_width, frame_height) = canvas.black, canvas.mask, canvas.size

    def add(homography: Floats) -> Iterator[Image]:
        warped = canvas.warped(homography)
        yield cv2.add(black, warped)
        yield cv2.add(black, cv2.bitwise_and(warped, mask))

    def within(what: str, homography: Floats) -> Iterator[Explanation]:
        for image in add(homography):
            yield Explanation(what, image)

    exchanged = ("Your picture is stretched: its width and height are exchanged. An array's shape is (height, "
                 'width), and a corner is (x, y), so the bottom right one is (width, height).')
    yield from within(exchanged, canvas.to_area(height, width))
    for _, image in _blended(canvas, canvas.warped(canvas.to_area(height, width))):
        yield Explanation(exchanged, image)
    sizes = ('Your picture does not fill the area, or goes beyond it: take its own width and height for its '
             'corners, not those of the frame.')
    yield from within(sizes, canvas.to_area(frame_width, frame_height))
    yield from within(sizes, canvas.to_area(frame_height, frame_width))
    for factor in 0.5, 0.7, 1 / 0.7, 2.0:
        yield from within('Your picture has the wrong size: its corners are those of a picture %.3g times as '
                          'large.'
                          % factor, canvas.to_area(factor * width, factor * height))
    homography = canvas.to_area()
    backward = ('The homography goes the wrong way, from the area to the picture. Take the '
                "picture's corners first, then the centers.")
    to_small = np.diag([canvas.picture.shape[1] / width, canvas.picture.shape[0] / height, 1.0])
    whole: Floats = homography @ to_small  # from the true picture's pixels
    scaled = np.asarray(np.linalg.inv(whole) @ np.linalg.inv(to_small), np.float64)
    yield from within(backward, scaled)
    for _, image in _blended(canvas, canvas.warped(scaled)):
        yield Explanation(backward, image)
    left, top = canvas.area.min(axis=0)
    right, bottom = canvas.area.max(axis=0)
    box = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    yield from within('Your picture is an upright rectangle, which is only cut out to the area. Warp it, so '
                      'that each of its corners is at a center.', replace(canvas, area=box).to_area())
    for kept in range(4):
        three = [i for i in range(4) if i != kept]
        own = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])[three] * canvas.picture.shape[1::-1]
        affine = cv2.getAffineTransform(np.asarray(own, np.float32), np.asarray(canvas.area[three], np.float32))
        yield from within('Your picture is a parallelogram, as from three of the centers. Four points and '
                          'cv2.warpPerspective let far sides be shorter.', np.vstack([affine, [0, 0, 1]]))
    full = np.array([[0, 0], [frame_width, 0], [frame_width, frame_height], [0, frame_height]], np.float64)
    to_frame = replace(canvas, area=full).to_area()
    yield Explanation('Your picture covers the whole frame. Warp it to the area.', canvas.warped(to_frame))
    yield from within('Your picture is as large as the frame, and only cut out to the area. Warp it, so that '
                      'all of it is in the area.', to_frame)
    # Without a warp: the picture in its own size.
    own_size = np.diag([width / canvas.picture.shape[1], height / canvas.picture.shape[0], 1.0])
    unwarped = 'Your picture is not warped: it has its own size and shape.'
    for x, y in (0.0, 0.0), (left, top), canvas.area[0]:
        shifted = np.array([[1, 0, x], [0, 1, y], [0, 0, 1]]) @ own_size
        yield from within(unwarped, shifted)
        warped, cover = canvas.warped(shifted), canvas.warped(shifted, np.full_like(canvas.picture, 255))
        yield Explanation(unwarped, np.where(cover > 127, warped, canvas.frame))


def _shapes(canvas: Canvas, sight: Sight, before: Sequence[Sight]) -> Iterator[Explanation]:
    """The picture in something else than the area."""
    scale = np.array(canvas.size) / sight.drawing.image.shape[1::-1]
    for what, corners in other_shapes(sight, before):
        if len(corners) == 4:
            for first in range(4):
                other = replace(canvas, area=(np.roll(corners, -first, axis=0) + 0.5) * scale - 0.5)
                yield Explanation('Your picture is not in the right area. Its rim ' + what, other.painted())
                warped = canvas.warped(other.to_area())
                for image in warped, cv2.bitwise_and(warped, canvas.mask):
                    yield Explanation('Your picture is not warped to the area that you subtract. The rim of '
                                      'the picture '
                                      + what, cv2.add(canvas.black, image))
    warped = canvas.warped(canvas.to_area())
    for what, filled in crossing_orders(sight):
        mask = cv2.cvtColor(_small(filled), cv2.COLOR_GRAY2BGR)
        for image in warped, cv2.bitwise_and(warped, mask):
            yield Explanation('The area that you subtract is not the right one. Its rim ' + what,
                              cv2.add(cv2.subtract(canvas.frame, mask), image))


def _pairs(canvas: Canvas, sight: Sight) -> Iterator[Explanation]:
    """Two of the mistakes at once: another order of the corners, and something else."""
    for what, order in _orders(sight):
        homography = canvas.to_area(order=order)
        for other, picture in _recolored(canvas):
            warped = canvas.warped(homography, picture)
            yield Explanation(what + ' ' + other, cv2.add(canvas.black, warped))
        warped = canvas.warped(homography)
        for _, image in _blended(canvas, warped):
            yield Explanation(what, image)
        if order not in TURNS:  # the area to be subtracted has the same order
            area, convex = canvas.area[list(order)], np.zeros(canvas.frame.shape, np.uint8)
            cv2.fillConvexPoly(convex, np.asarray(np.round(area), np.int32), (255, 255, 255))
            filled = cv2.cvtColor(fill(canvas.frame.shape, area), cv2.COLOR_GRAY2BGR)
            for mask in convex, filled:
                yield Explanation(what, cv2.add(cv2.subtract(canvas.frame, mask), warped))


def _gray(image: Image) -> Image:
    return cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
