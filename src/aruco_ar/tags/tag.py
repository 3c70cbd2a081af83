"""The Tag, the dictionaries of tags, and drawing a tag."""
from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image, Numbers
from aruco_ar.base.errors import InputError
from aruco_ar.geometry.lines import cross, crossing

# The names are also taken as many courses spell them: DICT_6x6_250.
DICTIONARIES = {spelling: getattr(cv2.aruco, name)
                for name in sorted(dir(cv2.aruco)) if name.startswith('DICT_')
                for spelling in (name.replace('X', 'x'), name)}
# One name for each: OpenCV has some twice, as DICT_APRILTAG_36h11 and DICT_APRILTAG_36H11.
DICTIONARY_NAMES = sorted({number: name for name, number in DICTIONARIES.items()}.values())

# How many wrong cells are corrected, for the dictionaries where versions of OpenCV differ. Up to 4.11, OpenCV
# corrects none of an AprilTag's cells. Later versions correct as many as possible, so that now and then
# anything square is taken for a tag. AprilTag's own default is 2.
CORRECTED = {'DICT_APRILTAG_16H5': 0, 'DICT_APRILTAG_25H9': 1, 'DICT_APRILTAG_36H10': 2,
             'DICT_APRILTAG_36H11': 2, 'DICT_ARUCO_MIP_36H12': 5, 'DICT_ARUCO_ORIGINAL': 0}

# The cells of the official AprilTag with id 0, without its border: 1 is white, row by row from the top.
# OpenCV 4 has all AprilTags turned by 180 degrees, some versions of OpenCV 5 do not.
OFFICIAL = {'DICT_APRILTAG_16H5': '0010001100011011', 'DICT_APRILTAG_25H9': '1010101011100101111110001',
            'DICT_APRILTAG_36H10': '000111001010100100101010011010000111',
            'DICT_APRILTAG_36H11': '110101011101011000101000010110000100'}

SIDE_M = 0.001, 10.0  # the smallest and the largest side of a real tag
# The corners of a tag in its own axes, from its own top left, in sides of the tag.
CORNERS = np.array([[-0.5, 0.5, 0], [0.5, 0.5, 0], [0.5, -0.5, 0], [-0.5, -0.5, 0]])
MAX_SIZE_PX = 10000
MAX_BORDER_CELLS = 10
MAX_QUIET_CELLS = 10


@dataclass(frozen=True, eq=False)
class Tag:
    """One tag seen in a frame.

    ``id``: its number in the dictionary. ``corners``: (4, 2) float32, pixels,
    clockwise from the tag's own top left, which is elsewhere in the frame if
    the tag is turned. The middle of the frame's top left pixel is (0, 0).
    ``likeness``: how closely the frame matches the tag's cells, 1 at best (see
    fit_tags). It is less if the tag is blurred, and so known less exactly.
    ``confidence``: how sure it is that this is a tag, 0 to 1 (see Confidence).
    """

    id: int
    corners: Floats
    likeness: float = 1.0
    confidence: float = 1.0

    @property
    def center(self) -> Floats:
        """(2,) float32, pixels: where the diagonals cross.

        A perspective view keeps straight lines straight. So this crossing is
        the center of the real tag, but the mean of the corners is not.
        """
        top_left, top_right, bottom_right, bottom_left = np.asarray(self.corners, np.float64)
        diagonal, other_diagonal = bottom_right - top_left, bottom_left - top_right
        if abs(cross(diagonal, other_diagonal)) < 1e-9:
            return np.mean(self.corners, axis=0, dtype=np.float32)
        return crossing(top_left, diagonal, top_right, other_diagonal).astype(np.float32)


def get_dictionary(name: str) -> cv2.aruco.Dictionary:
    """The OpenCV dictionary of that name, such as ``DICT_6X6_250``; of AprilTags the official ones, upright.

    Raises InputError for a name that OpenCV does not know.
    """
    if name not in DICTIONARIES:
        raise InputError('There is no tag dictionary "%s"; choose one of %s.'
                         % (name, ', '.join(DICTIONARY_NAMES)))
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[name])
    dictionary.maxCorrectionBits = CORRECTED.get(name.upper(), dictionary.maxCorrectionBits)
    if name.upper() in OFFICIAL:
        dictionary.bytesList = _official_bytes(name.upper())
    return dictionary


@lru_cache(maxsize=None)  # some nodes make a Detector for each frame
def _official_bytes(name: str) -> Image:
    """The bytes of a dictionary in OFFICIAL, as OpenCV keeps them, but upright."""
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[name])
    bits = cv2.aruco.Dictionary.getBitsFromByteList(dictionary.bytesList[:1], dictionary.markerSize)
    if ''.join(map(str, bits.ravel())) == OFFICIAL[name]:
        return dictionary.bytesList
    # Of each tag it has the bytes of all four quarter turns, one turn after the other.
    turns = dictionary.bytesList.reshape(len(dictionary.bytesList), 4, -1)
    return np.roll(turns, 2, axis=1).reshape(dictionary.bytesList.shape)


def tag_cells(dictionary: str, tag_id: int, border: int = 1) -> Image:
    """The cells of a tag with its black border: (n, n) uint8, 0 black and 255 white.

    ``dictionary``: its name. ``border``: the width of the black border in
    cells. Raises InputError for an id that the dictionary does not have.
    """
    marker = get_dictionary(dictionary)
    count = len(marker.bytesList)
    if not 0 <= tag_id < count:
        raise InputError('Tag id %d is not in %s, which has the ids 0 to %d.'
                         % (tag_id, dictionary, count - 1))
    if not 1 <= border <= MAX_BORDER_CELLS:
        raise InputError('A border of %d cells cannot be drawn; choose from 1 to %d.'
                         % (border, MAX_BORDER_CELLS))
    return cv2.aruco.generateImageMarker(
        marker, tag_id, marker.markerSize + 2 * border, borderBits=border)


def check_quiet(quiet: float) -> None:
    """Raise InputError if a white margin of that many cells cannot be drawn."""
    if not 0 <= quiet <= MAX_QUIET_CELLS:
        raise InputError('A white margin of %g cells cannot be drawn; choose from 0 to %d.'
                         % (quiet, MAX_QUIET_CELLS))


def draw_tag(dictionary: str, tag_id: int, size: int = 700, border: int = 1, quiet: float = 0) -> Image:
    """One tag as a picture, (n, n) uint8, 0 black and 255 white.

    ``size``: the side of the tag itself, pixels. ``border``: the width of the
    black border, cells. ``quiet``: the width of the white margin, cells, so
    n = size + 2 * round(quiet * size / cells). Raises InputError for an id that
    the dictionary does not have, and for a size of less than one pixel a cell.
    """
    check_tag(dictionary, tag_id, size, border, quiet)
    marker = get_dictionary(dictionary)
    tag = cv2.aruco.generateImageMarker(marker, tag_id, size, borderBits=border)
    return add_margin(tag, marker.markerSize + 2 * border, quiet)


def check_tag(dictionary: str, tag_id: int, size: int, border: int, quiet: float) -> None:
    """Raise InputError if ``draw_tag`` cannot draw such a tag."""
    cells = len(tag_cells(dictionary, tag_id, border))
    if not cells <= size <= MAX_SIZE_PX:
        raise InputError('A tag %d cells wide cannot be drawn with a size of %d px; choose from %d to '
                         '%d.' % (cells, size, cells, MAX_SIZE_PX))
    check_quiet(quiet)


def add_margin(tag: Image, cells: int, quiet: float) -> Image:
    """The picture of a tag that is ``cells`` cells wide, with a white margin of ``quiet`` cells around it."""
    margin = round(quiet * len(tag) / cells)
    return cv2.copyMakeBorder(tag, margin, margin, margin, margin, cv2.BORDER_CONSTANT, value=(255,))


def listed(ids: Sequence[int]) -> str:
    """Ids as words: the first twelve."""
    return ', '.join(map(str, ids[:12])) + (', ...' if len(ids) > 12 else '')


def square(sizes: Numbers) -> Floats:
    """(n, 4, 3) meters: the corners of tags with sides (n,) in their own axes, from their own top left."""
    return np.multiply.outer(np.asarray(sizes, np.float64), CORNERS)
