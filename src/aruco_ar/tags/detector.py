"""Finding tags in a frame."""
from __future__ import annotations

from typing import Iterable, NamedTuple, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.base.checks import GRAY_OR_COLOR, check_array
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.ordering import is_quadrilateral

from .completion import Completion
from .confidence import Confidence, count_changes
from .edges import (
    MARGIN,
    UNEVEN,
    check_tags,
    compare_tags,
    fit_tags,
    guess_tags,
    room_of,
    sample_cells,
    side_of,
)
from .quads import UNREAD, find_quads, read_tags, tag_words
from .tag import MAX_BORDER_CELLS, Tag, get_dictionary, tag_cells


# How a frame is searched. ``scale``: the frame is enlarged by this factor first. ``passes``: each a factor by
# which that image is shrunk, and the window, pixels, by which dark parts are found in it. ``shortest``: the
# least sum of the sides of a tag, relative to the image's longer side. ``rereads``: every quadrilateral is
# also fitted to its edges, and its cells are read in the frame itself. This finds more tags, and mistakes
# fewer other things for tags.
class _Preset(NamedTuple):
    scale: float
    passes: tuple[tuple[float, int], ...]
    shortest: float
    rereads: bool


_PRESETS = {
    'fast': _Preset(1, ((0.5, 11),), 0.03, False),
    'normal': _Preset(1, ((0.5, 15), (1, 5), (1, 11)), 0.03, False),
    'thorough': _Preset(2, ((1, 5), (1, 13), (0.5, 5), (0.5, 11), (0.25, 11)), 0.02, True),
}
SEARCHES = tuple(_PRESETS)

# A search for tags of a known size resizes the frame so that they are SEARCH_SIDE_PX
# wide, but enlarges it at most by MAX_ENLARGED. It needs only one window.
SEARCH_SIDE_PX, SEARCH_WINDOW = 22, 11
MAX_ENLARGED = 3
# A tag must have at least this likeness (see fit_tags). As many wrong cells are corrected
# as can be, which finds tags that are blurred by motion. This limit rejects the other
# things that are then mistaken for tags.
MIN_LIKENESS = 0.76
# Usually a tag must have more confidence than this. It is low: a missed tag costs more than a false one,
# since an area needs four tags.
MIN_CONFIDENCE = 0.2
# All of it, as compare_tags sees it, must be like the tag as well. Blur takes more from tags with small cells,
# so these need less: the least, what each pixel of a cell's width adds, and the limit for wide cells.
MIN_WHOLE, WHOLE_OF_PX, MIN_WHOLE_WIDE = 0.35, 0.1, 0.65
# Cells that are reread are sharpened by this kernel, since the cells of a far tag
# are blurred into each other.
SHARPEN = np.array([[0, -0.25, 0], [-0.25, 2, -0.25], [0, -0.25, 0]], np.float32)
# In a reread tag, at most this share of the black border may be light. At most the
# same share of the white ring around it may be dark.
MAX_WRONG = 0.15
# A corner may be this far beyond the middles of the frame's outermost pixels. Otherwise the tag is cut off, and
# its place is less exact than it seems.
BEYOND_PX = 0.75
SMALL_PX = 24      # a whole pixel is much of a tag with a side of less than this
MIN_CONTRAST = 12  # of a tag's border with what is around it, in gray levels
# In a shadow, a cell is compared with those up to two cells away, if their contrast is at least this share of
# that of all.
AROUND, MIN_LOCAL = np.ones((5, 5), np.uint8), 0.2
# A tag that is off is looked for at these multiples of this many cells.
SHIFT_CELLS = 0.6
SHIFTS = np.stack(np.meshgrid(np.arange(-3, 4), np.arange(-3, 4)), axis=-1).reshape(-1, 2)
# Fine textures can have tens of thousands of quadrilaterals. Only this many, the largest, are read.
MAX_READ = 2000


class Detector:
    """Finds the tags of one dictionary, black on white or white on black.

    ``dictionary``: a name such as ``DICT_6X6_250``. ``ids``: if given, tags
    with other ids are ignored. ``search``: ``normal``; ``fast``, which finds
    near tags at a fraction of the cost; or ``thorough``, which also finds far
    and slanted tags, at many times the cost. ``correction``, 0 to 1: how many
    wrong cells are corrected, as a share of those that the dictionary can
    correct. ``confidence``, 0 to 1: a tag must have more (see Confidence); with 0,
    all count that can be read.
    ``min_side``, pixels: tags with a shorter mean side are ignored.
    ``border``, 1 to 10: the width of the tags' black border, whole cells. Raises
    InputError for any other value.
    """

    def __init__(self, dictionary: str = 'DICT_6X6_250', ids: Iterable[int] = (), search: str = 'normal',
                 correction: float = 1.0, confidence: float = MIN_CONFIDENCE, min_side: float = 0,
                 border: float = 1) -> None:
        if search not in _PRESETS:
            raise InputError('There is no search "%s"; choose one of %s.' % (search, ', '.join(SEARCHES)))
        for name, value in ('correction', correction), ('confidence', confidence):
            if not isinstance(value, (int, float)) or not 0 <= value <= 1:
                raise InputError('The %s cannot be %s; give a number from 0 to 1.' % (name, value))
        if not isinstance(min_side, (int, float)) or not min_side >= 0:
            raise InputError('The shortest side of tags cannot be %s; give pixels, 0 or more.' % (min_side,))
        if border not in range(1, MAX_BORDER_CELLS + 1):
            raise InputError('The border of tags cannot be %s cells wide; choose from 1 to %d.'
                             % (border, MAX_BORDER_CELLS))
        self._dictionary, self._border = dictionary, int(border)
        self._marker = get_dictionary(dictionary)
        self._ids = frozenset(ids)
        for tag_id in self._ids:
            tag_cells(dictionary, tag_id)  # raises if the dictionary has no such id
        self._correction, self._min_confidence, self._min_side = correction, confidence, min_side
        self._min_likeness = MIN_LIKENESS if confidence > 0 else 0
        self._confidence = Confidence(dictionary, len(self._ids))
        self._changes: dict[int, int] = {}  # of each tag that was found
        self._cells: dict[int, Image] = {}  # of each tag, as it was last seen: some are white on black
        self._completions: dict[tuple[int, bool], Completion] = {}
        self._preset = _PRESETS[search]
        self._words = tag_words(dictionary)
        self._corrected = int(correction * self._marker.maxCorrectionBits)

    def detect(self, frame: Image) -> list[Tag]:
        """The tags in a frame, a list of Tag, in the order in which they are found.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8.
        """
        frame = _gray(frame)
        ids, quads = self._find(frame, self._preset)
        if self._preset.rereads:  # the normal search finds some tags that the fine one misses
            more, others = self._find(frame, _PRESETS['normal'])
            ids, quads = ids + more, np.concatenate([quads, others])
        return self._fitted(frame, ids, quads)

    def search(self, frame: Image, side: float, only: int | None = None) -> list[Tag]:
        """The tags with sides of at least ``side`` pixels. ``only``: the one id to look for, or None for all.

        With a large ``side``, this is faster than ``detect``. With a small one, it finds more tags.
        """
        scale, frame = min(SEARCH_SIDE_PX / side, MAX_ENLARGED), _gray(frame)
        preset = _Preset(max(scale, 1), ((min(scale, 1), SEARCH_WINDOW),), _PRESETS['normal'].shortest, False)
        return self._fitted(frame, *self._find(frame, preset, only))

    def find_at(self, frame: Image, ids: Sequence[int], quads: Floats) -> list[Tag]:
        """Those of the tags with these ids that are at quads, (n, 4, 2) pixels, off by less than a cell.

        A tag whose edges are not all seen is left out, since it would stay where it is expected.
        """
        return self._fitted(_gray(frame), list(ids), quads, needs_edges=True)

    def fit(self, frame: Image, ids: Sequence[int], quads: Floats) -> tuple[Floats, Booleans, Floats]:
        """Move quadrilaterals, (n, 4, 2), onto the edges of the tags with those ids; returns as fit_tags."""
        return fit_tags(frame, quads, self._cells_of(ids))

    def confidence(self, tag_id: int, likeness: float, is_expected: bool) -> float:
        """How sure it is that what looks like the tag with that id is it; see Confidence."""
        if tag_id not in self._changes:
            self._changes[tag_id] = count_changes(self._cells_of([tag_id])[0])
        return self._confidence.of(likeness, self._changes[tag_id], is_expected)

    def find_shifted(self, frame: Image, ids: Sequence[int], quads: Floats) -> list[Tag]:
        """As find_at, but the tags may be off by up to two cells, all corners alike.

        Each is looked for in the place where the frame looks most like it.
        """
        if not ids:
            return []
        cells = self._cells_of(ids)
        steps = np.outer(SHIFT_CELLS / cells.shape[1] * side_of(quads), SHIFTS).reshape(len(quads), -1, 1, 2)
        moved = np.asarray(quads[:, None] + steps, np.float32)
        likeness = compare_tags(frame, moved.reshape(-1, 4, 2), cells.repeat(len(SHIFTS), axis=0), samples=1)
        best = likeness.reshape(moved.shape[:2]).argmax(axis=1)
        return self._fitted(frame, list(ids), moved[np.arange(len(best)), best], needs_edges=True)

    def completion(self, tag_id: int) -> Completion:
        """What completes the tag with that id, if something covers a side of it."""
        cells = self._cells_of([tag_id])[0]
        key = tag_id, bool(cells[0, 0])  # some are white on black
        if key not in self._completions:
            self._completions[key] = Completion(cells, self._border)
        return self._completions[key]

    def _cells_of(self, ids: Sequence[int]) -> Image:
        """(n, m, m) uint8: the cells of the tags with those ids."""
        for tag_id in ids:
            if tag_id not in self._cells:
                self._cells[tag_id] = tag_cells(self._dictionary, tag_id, self._border)
        return np.array([self._cells[tag_id] for tag_id in ids])

    def _find(self, frame: Image, preset: _Preset, only: int | None = None) -> tuple[list[int], Floats]:
        """The ids and quadrilaterals, (n, 4, 2) float32 pixels, of possible tags in a gray frame.

        ``only``: see search.
        """
        scale = preset.scale
        image = _scaled(frame, scale)
        quads = np.concatenate([_quads(image, *way, preset.shortest) for way in preset.passes])
        quads = _largest(quads, MAX_READ)
        numbers, quads = read_tags(image, quads, self._words, self._marker.markerSize, self._border,
                                   self._corrected, MIN_CONTRAST)
        is_read = numbers >= 0
        ids, known, unread = numbers[is_read].tolist(), quads[is_read], quads[numbers == UNREAD]
        quads = known
        if len(unread) and only not in ids:
            more, others = self._read_others(image, unread, known)
            if more:
                ids, quads = ids + more, np.concatenate([known, others])
        quads = _unscaled(quads, scale)
        if preset.rereads and len(known) + len(unread):
            more, others = self._reread(frame, _unscaled(np.concatenate([known, unread]), scale))
            ids, quads = ids + more, np.concatenate([quads, others])
        wanted = self._ids if only is None else {only}
        if not wanted:
            return ids, quads
        kept = [number for number, tag_id in enumerate(ids) if tag_id in wanted]
        return [ids[number] for number in kept], quads[kept]

    def _read_others(self, gray: Image, quads: Floats, known: Floats) -> tuple[list[int], Floats]:
        """The ids and quadrilaterals, (n, 4, 2) float32, of tags that are found, but not read at once.

        These are white on black, or in the light on one side and in a shadow on the other. ``quads``: those
        that could not be read. ``known``: those that could, which are not read again.
        """
        count = self._marker.markerSize + 2 * self._border
        guesses = guess_tags(gray, quads, count, known, MIN_CONTRAST)
        if not guesses.any():
            return [], quads[:0]
        margins = quads[guesses == MARGIN]
        may_be = (guesses > 0) & (guesses != MARGIN)
        is_white, quads = guesses[may_be] != UNEVEN, quads[may_be]
        found: list[int] = []
        turned: list[Floats] = []
        if len(quads):
            self._read_all(gray, quads, is_white, found, turned)
        if len(margins):
            white = np.full((len(margins), count, count), 255)
            within = fit_tags(gray, _without_margin(margins, count), white)[0]
            if turned:
                within = within[guess_tags(gray, within, count, np.array(turned), MIN_CONTRAST) > 0]
            self._read_all(gray, within, np.full(len(within), True), found, turned)
        return found, np.array(turned, np.float32).reshape(-1, 4, 2)

    def _read_all(self, gray: Image, quads: Floats, is_white: Booleans, found: list[int],
                  turned: list[Floats]) -> None:
        """Append the ids of the tags in quadrilaterals, (n, 4, 2), and these, turned; (n,): which are white."""
        for quad, seen, inverted in zip(quads, self._seen(gray, quads), is_white):
            tag_id, turns = self._read(_locally_light(255 - seen if inverted else seen))
            if tag_id is not None:
                found.append(tag_id)
                turned.append(np.roll(quad, turns, axis=0))

    def _seen(self, frame: Image, quads: Floats) -> Image:
        """(n, m, m) uint8: the gray of the cells in quadrilaterals, (n, 4, 2), and of the ring around."""
        count = self._marker.markerSize + 2 * self._border
        if not len(quads):
            return np.empty((0, count + 2, count + 2), np.uint8)
        return sample_cells(frame, quads, count, -1).astype(np.uint8).reshape(-1, count + 2, count + 2)

    def _read(self, light: Booleans) -> tuple[int | None, int]:
        """The id of the tag with these light cells (see _light), or None, and its quarter turns."""
        rim = self._border + 1
        good, tag_id, turns = self._marker.identify(light[rim:-rim, rim:-rim].astype(np.uint8),
                                                    float(self._correction))
        return (tag_id if good else None), turns

    def _reread(self, frame: Image, quads: Floats) -> tuple[list[int], Floats]:
        """The ids and quadrilaterals, (n, 4, 2) float32, of those whose cells are a tag's in the frame itself.

        Each quadrilateral is read twice: as it is given, and fitted to its edges.
        """
        count = self._marker.markerSize + 2 * self._border
        unknown = np.zeros((len(quads), count, count))
        quads, found, turned = np.concatenate([quads, fit_tags(frame, quads, unknown)[0]]), [], []
        for quad, seen in zip(quads, self._seen(frame, quads)):
            is_white = np.median(seen[1:-1, [1, -2]]) > np.median(seen[:, [0, -1]])
            gray = 255 - seen if is_white else seen
            tag_id, turns = self._read(_light(cv2.filter2D(gray, -1, SHARPEN)))
            if tag_id is not None and _wrong(_light(gray), self._border + 1) <= MAX_WRONG:
                found.append(tag_id)
                turned.append(np.roll(quad, turns, axis=0))
        return found, np.array(turned, np.float32).reshape(-1, 4, 2)

    def _fitted(self, frame: Image, ids: list[int], quads: Floats, needs_edges: bool = False) -> list[Tag]:
        """The tags among quadrilaterals, (n, 4, 2), moved onto their edges if these are found."""
        if not ids:
            return []
        # The fit starts at whole pixels, for tags that are found and for those that are followed. Otherwise a
        # tiny error of one fit would pass to the next one, and the errors of all frames would be alike.
        is_large = needs_edges | (side_of(quads) > SMALL_PX)
        quads = np.where(is_large[:, None, None], np.round(quads), quads).astype(np.float32)
        fitted, found, likeness, whole, cells = check_tags(frame, quads, self._cells_of(ids))
        room, sides = room_of(fitted, frame), side_of(fitted)
        least = np.minimum(MIN_WHOLE + WHOLE_OF_PX * sides / len(cells[0]), MIN_WHOLE_WIDE)
        is_in_place = found if needs_edges else found | (room >= 1)
        good = np.flatnonzero(is_in_place & (room >= -BEYOND_PX) & (likeness > self._min_likeness)
                              & (whole > least) & (sides >= self._min_side) & is_quadrilateral(fitted))
        if self._preset.rereads or len(set(ids)) < len(ids):
            good = _without_duplicates(fitted, whole, good)
        self._cells.update((ids[number], cells[number]) for number in good)
        tags = [Tag(ids[number], fitted[number], like, self.confidence(ids[number], like, needs_edges))
                for number, like in zip(good, likeness[good].tolist())]
        return [tag for tag in tags if tag.confidence > self._min_confidence]


def _gray(frame: Image) -> Image:
    """(h, w) uint8: a frame, checked, in gray. All work on it takes less time than on three channels."""
    check_array('frame', frame, np.uint8, *GRAY_OR_COLOR)
    return frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)


def _scaled(gray: Image, scale: float) -> Image:
    """(h, w) uint8: a gray frame, resized, and sharpened if it is enlarged."""
    if scale <= 1:
        return gray if scale == 1 else cv2.resize(gray, None, fx=scale, fy=scale)
    # Without this, blur would fill the cells of small tags, and join a tag to what is beyond a narrow margin.
    sharp = cv2.addWeighted(gray, 2, cv2.GaussianBlur(gray, (0, 0), 1), -1, 0)
    return cv2.resize(sharp, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)


def _quads(image: Image, shrink: float, window: int, shortest: float) -> Floats:
    """(n, 4, 2) float32: the quadrilaterals in an image, found in a smaller one; see _Preset."""
    shrink = max(shrink, 1 / min(image.shape))  # at least one pixel must be left
    small = _scaled(image, shrink)
    return _unscaled(find_quads(small, window, shortest * max(small.shape)), shrink)


def _largest(quads: Floats, most: int) -> Floats:
    """So many of the quadrilaterals, (n, 4, 2), in the order that they have."""
    return quads if len(quads) <= most else quads[np.sort(np.argsort(-side_of(quads), kind='stable')[:most])]


def _unscaled(quads: Floats, scale: float) -> Floats:
    """Quadrilaterals in a scaled frame, in pixels of the frame. The first pixel is at (0, 0) in both."""
    return quads if scale == 1 else (quads + 0.5) / np.float32(scale) - 0.5


def _without_margin(quads: Floats, count: int) -> Floats:
    """(n, 4, 2) float32: the tags, ``count`` cells wide, in quadrilaterals that have margins of a cell."""
    share = 1 / (count + 2)
    weights = np.empty((4, 4), np.float32)
    for corner in range(4):
        for off, weight in enumerate(((1 - share)**2, share * (1 - share), share**2, share * (1 - share))):
            weights[corner, (corner + off) % 4] = weight
    return weights @ quads


def _without_duplicates(quads: Floats, whole: Floats, numbers: Iterable[int]) -> list[int]:
    """The indices of the quadrilaterals, (n, 4, 2), to keep: in each place the one that is most like a tag.

    A tag can be found several times: by the contours on both sides of its
    edges, and both as given and as fitted.
    """
    centers, sides = quads.mean(axis=1), side_of(quads)
    kept: list[int] = []
    left = np.array(sorted(numbers, key=lambda number: -whole[number]), int)
    while len(left):
        best = left[0]
        kept.append(best)
        off = np.abs(centers[left] - centers[best]).max(axis=1) + np.abs(sides[left] - sides[best])
        left = left[off > np.maximum(sides[left], sides[best]) / 2]
    return sorted(kept)


def _light(gray: Image) -> Booleans:
    """(n, n) bool: which cells of a tag and of the ring around it are light.

    ``gray``: (n, n) uint8, the tag with the ring. The threshold is chosen by the tag's own cells.
    """
    threshold, _ = cv2.threshold(gray[1:-1, 1:-1].copy(), 0, 1, cv2.THRESH_OTSU)
    return gray > threshold


def _locally_light(gray: Image) -> Booleans:
    """As _light, if there is a shadow on some of the cells: each is compared with those around it."""
    gray = np.asarray(gray, np.float32) + 1
    darkest, lightest = cv2.erode(gray, AROUND), cv2.dilate(gray, AROUND)
    plain = lightest - darkest < MIN_LOCAL * (gray.max() - gray.min())  # all around are of one color
    # A shadow divides all gray levels, so the limit between dark and light is the mean of their logarithms.
    return np.where(plain, _light(np.asarray(gray - 1, np.uint8)), gray * gray > darkest * lightest)


def _wrong(light: Booleans, rim: int) -> float:
    """The part of the ring that is dark, or of the black border that is light; the larger of the two.

    ``light``: (n, n) bool, a tag's cells with the ring of cells around it. ``rim``: that of both, in cells.
    """
    with_ring, with_border, inside = (int(light[width:-width or None, width:-width or None].sum())
                                      for width in (0, 1, rim))
    tag, middle = len(light) - 2, len(light) - 2 * rim
    return max(1 - (with_ring - with_border) / (len(light)**2 - tag**2),
               (with_border - inside) / (tag**2 - middle**2))
