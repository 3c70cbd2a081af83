"""Finding tags in a frame."""
from __future__ import annotations

from typing import Iterable, NamedTuple, Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Booleans, Floats, Image
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.ordering import is_quadrilateral

from .edges import fit_tags, look_at_cells, side_of
from .tag import Tag, get_dictionary, tag_cells


# How a frame is searched. ``scale``: of the picture that is searched to the
# frame. ``windows``: smallest, largest, step, pixels of that picture, of the
# neighborhoods against whose mean a pixel is dark or light. ``smallest``: a
# tag's perimeter as a part of the picture's longer side. ``rereads``: whatever
# is like a quadrilateral is fitted to its edges and read in the frame itself,
# which finds more and takes less for a tag than OpenCV's own reading.
class _Preset(NamedTuple):
    scale: float
    windows: tuple[int, int, int]
    smallest: float
    rereads: bool


_PRESETS = {
    'fast': _Preset(0.5, (11, 11, 1), 0.03, False),
    'normal': _Preset(1, (3, 23, 10), 0.03, False),
    'thorough': _Preset(2, (5, 45, 8), 0.02, True),
}
SEARCHES = tuple(_PRESETS)

# A search for tags of a known size shrinks or enlarges the frame until they are
# this wide, and looks at it with this window alone.
SEARCH_SIDE_PX = 24
SEARCH_WINDOWS = (11, 11, 1)
MAX_ENLARGED = 3
# What is between a tag's edges must be as like it as this (see fit_tags). That
# keeps out what OpenCV would mistake for a tag when it corrects as many wrong
# cells as it can, which is what finds tags blurred by motion.
MIN_LIKENESS = 0.8
# What is reread is sharpened by this, cell by cell: in a far tag each cell is
# blurred into those beside it.
SHARPEN = np.array([[0, -0.25, 0], [-0.25, 2, -0.25], [0, -0.25, 0]], np.float32)
# As large a part may be light of the black border, and dark of the white ring
# around it, of what is reread.
MAX_WRONG = 0.15
# Of the quadrilaterals that OpenCV takes for tags, so many, the largest, are looked
# at any further, and so many of those that it takes for none are reread: fine
# textures have tens of thousands. Each is reread twice, and cv2.remap takes less
# than 32767 edges at once.
MAX_READ = MAX_REREAD = 2000


class Detector:
    """Finds the tags of one dictionary.

    ``dictionary`` is a name such as ``DICT_6X6_250``. With ``ids``, tags of
    other ids are passed over. ``search``: ``fast`` for near tags at a fraction
    of the cost of ``normal``; ``thorough`` for far and slanted tags at many
    times of it. ``correction``, 0 to 1: how many of the wrong cells that the
    dictionary could correct are corrected. ``likeness``, 0 to 1: what is
    between a tag's edges must be more like it (see fit_tags). ``min_side``,
    pixels: tags whose mean side is shorter are passed over. Raises InputError
    for any other.
    """

    def __init__(self, dictionary: str = 'DICT_6X6_250', ids: Iterable[int] = (), search: str = 'normal',
                 correction: float = 1.0, likeness: float = MIN_LIKENESS, min_side: float = 0) -> None:
        if search not in _PRESETS:
            raise InputError('There is no search "%s"; choose one of %s.' % (search, ', '.join(SEARCHES)))
        for name, value in ('correction', correction), ('likeness', likeness):
            if not isinstance(value, (int, float)) or not 0 <= value <= 1:
                raise InputError('A %s of %s cannot be asked for; give 0 to 1.' % (name, value))
        if not isinstance(min_side, (int, float)) or not min_side >= 0:
            raise InputError('Tags cannot be at least %s wide; give pixels, 0 or more.' % (min_side,))
        self._dictionary = dictionary
        self._marker = get_dictionary(dictionary)
        self._ids = frozenset(ids)
        for tag_id in self._ids:
            tag_cells(dictionary, tag_id)  # raises where the dictionary has no such id
        self._correction, self._likeness, self._min_side = correction, likeness, min_side
        self._cells: dict[int, Image] = {}
        self._preset = _PRESETS[search]
        self._anywhere = self._finder(self._preset.windows, self._preset.smallest)
        self._usual = self._finder(_PRESETS['normal'].windows, _PRESETS['normal'].smallest) \
            if self._preset.rereads else None
        self._of_a_size = self._finder(SEARCH_WINDOWS, _PRESETS['normal'].smallest)

    def detect(self, frame: Image) -> list[Tag]:
        """The tags in a frame, a list of Tag in the order in which they were found.

        ``frame``: (h, w, 3) BGR or (h, w) gray, uint8.
        """
        ids, quads = self._find(self._anywhere, frame, self._preset.scale, self._preset.rereads)
        if self._usual is not None:  # a fine search can lose what a coarser one finds
            more, others = self._find(self._usual, frame, _PRESETS['normal'].scale)
            ids, quads = ids + more, np.concatenate([quads, others])
        return self._fitted(frame, ids, quads)

    def search(self, frame: Image, side: float) -> list[Tag]:
        """The same for tags of ``side`` pixels or more: of large ones faster, of small ones more of them."""
        scale = min(SEARCH_SIDE_PX / side, MAX_ENLARGED)
        return self._fitted(frame, *self._find(self._of_a_size, frame, scale))

    def fit(self, frame: Image, ids: Sequence[int], quads: Floats) -> tuple[Floats, Booleans, Floats]:
        """Put quadrilaterals, (n, 4, 2), onto the tags with those ids: see fit_tags."""
        for tag_id in ids:
            if tag_id not in self._cells:
                self._cells[tag_id] = tag_cells(self._dictionary, tag_id)
        return fit_tags(frame, quads, np.array([self._cells[tag_id] for tag_id in ids]))

    def _finder(self, windows: tuple[int, int, int], smallest: float) -> cv2.aruco.ArucoDetector:
        """OpenCV's detector with a preset's windows and smallest perimeter."""
        parameters = cv2.aruco.DetectorParameters()
        parameters.errorCorrectionRate = float(self._correction)
        parameters.maxErroneousBitsInBorderRate = 0.6
        # OpenCV 4.14 and later count each cell as wrong that is not clearly dark or light, and do not find tags
        # that are blurred by motion. Here a cell is again what most of it is; of 25 pixels there is no half.
        if hasattr(parameters, 'validBitIdThreshold'):
            parameters.validBitIdThreshold, parameters.perspectiveRemovePixelPerCell = 0.5, 5
        parameters.adaptiveThreshWinSizeMin = windows[0]
        parameters.adaptiveThreshWinSizeMax = windows[1]
        parameters.adaptiveThreshWinSizeStep = windows[2]
        parameters.minMarkerPerimeterRate = smallest
        # Whole pixels will do, to fit edges; what refines them goes to the rim's corners where that is narrow.
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        return cv2.aruco.ArucoDetector(self._marker, parameters)

    def _find(self, finder: cv2.aruco.ArucoDetector, frame: Image, scale: float,
              rereads: bool = False) -> tuple[list[int], Floats]:
        """Ids and quadrilaterals, (n, 4, 2) float32, of what may be tags, seen in the scaled frame."""
        scale = max(scale, 1 / min(frame.shape[:2]))  # leaves a pixel of it
        corners, ids, rejected = finder.detectMarkers(_scaled(frame, scale))
        ids = [] if ids is None else [int(tag_id) for tag_id in ids.ravel()]
        if len(ids) > MAX_READ:
            largest = np.argsort(-side_of(np.array(corners, np.float32).reshape(-1, 4, 2)))[:MAX_READ]
            corners, ids = [corners[number] for number in largest], [ids[number] for number in largest]
        quads = np.array([*corners, *rejected] if rereads else corners, np.float32).reshape(-1, 4, 2)
        # The middle of the first pixel is (0, 0), before and after scaling.
        quads = (quads + 0.5) / np.float32(scale) - 0.5
        if rereads and len(quads):
            more, others = self._reread(frame, quads[:len(corners) + MAX_REREAD])
            ids, quads = ids + more, np.concatenate([quads[:len(corners)], others])
        wanted = [number for number, tag_id in enumerate(ids) if not self._ids or tag_id in self._ids]
        return [ids[number] for number in wanted], quads[wanted]

    def _reread(self, frame: Image, quads: Floats) -> tuple[list[int], Floats]:
        """Ids and quadrilaterals, (n, 4, 2) float32, of those that are tags, as given or fitted to edges."""
        count = self._marker.markerSize + 2
        unknown = np.zeros((len(quads), count, count))
        quads, found, places = np.concatenate([quads, fit_tags(frame, quads, unknown)[0]]), [], []
        grays = look_at_cells(frame, quads, count, -1).astype(np.uint8)
        for quad, gray in zip(quads, grays.reshape(-1, count + 2, count + 2)):
            inside = _light(cv2.filter2D(gray, -1, SHARPEN))[2:-2, 2:-2]
            good, tag_id, turns = self._marker.identify(inside.astype(np.uint8), float(self._correction))
            if good and _wrong(_light(gray)) <= MAX_WRONG:
                found.append(tag_id)
                places.append(np.roll(quad, turns, axis=0))
        return found, np.array(places, np.float32).reshape(-1, 4, 2)

    def _fitted(self, frame: Image, ids: list[int], quads: Floats) -> list[Tag]:
        """Tags, fitted to their edges where those can be seen."""
        if not ids:
            return []
        fitted, _, likeness = self.fit(frame, ids, quads)
        good = np.flatnonzero((likeness > self._likeness) & (side_of(fitted) >= self._min_side)
                              & is_quadrilateral(fitted))
        if self._preset.rereads:
            good = _once(fitted, likeness, good)
        return [Tag(ids[number], fitted[number]) for number in good]


def _scaled(frame: Image, scale: float) -> Image:
    """(h, w) uint8: a frame in gray and in another size; sharpened if enlarged."""
    if scale < 1:
        frame = cv2.resize(frame, None, fx=scale, fy=scale)
    gray = frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    if scale <= 1:
        return gray
    # Or blur would fill the cells of small tags, and join a tag to what is beyond a narrow rim.
    sharp = cv2.addWeighted(gray, 2, cv2.GaussianBlur(gray, (0, 0), 1), -1, 0)
    return cv2.resize(sharp, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)


def _once(quads: Floats, likeness: Floats, numbers: Iterable[int]) -> list[int]:
    """Those of the numbers of quadrilaterals, (n, 4, 2), that are the most alike in their place.

    A tag can be found several times: by the contours on both sides of its
    edges, as given and as fitted.
    """
    centers, sides = quads.mean(axis=1), side_of(quads)
    kept: list[int] = []
    left = np.array(sorted(numbers, key=lambda number: -likeness[number]), int)
    while len(left):
        best = left[0]
        kept.append(best)
        off = np.abs(centers[left] - centers[best]).max(axis=1) + np.abs(sides[left] - sides[best])
        left = left[off > np.maximum(sides[left], sides[best]) / 2]
    return sorted(kept)


def _light(gray: Image) -> Booleans:
    """(n, n) bool: which cells, (n, n) uint8, of a tag and the ring around it are light, by the tag's own."""
    middle, _ = cv2.threshold(gray[1:-1, 1:-1].copy(), 0, 1, cv2.THRESH_OTSU)
    return gray > middle


def _wrong(light: Booleans) -> float:
    """The part of the ring around a tag, (n, n) bool with it, that is dark, or of its border that is light."""
    around, border, inside = light.sum(), light[1:-1, 1:-1].sum(), light[2:-2, 2:-2].sum()
    ring = 4 * (len(light) - 1)
    return max(1 - (around - border) / ring, (border - inside) / (ring - 8))
