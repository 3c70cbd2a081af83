"""Tags: what one is, the dictionaries they come from, and drawing one."""
from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats, Image, Numbers
from aruco_ar.base.errors import InputError

DICTIONARIES = {name: getattr(cv2.aruco, name)
                for name in sorted(dir(cv2.aruco)) if name.startswith('DICT_')}
# Each once: OpenCV has some twice, as DICT_APRILTAG_36h11 and DICT_APRILTAG_36H11.
DICTIONARY_NAMES = sorted({number: name for name, number in DICTIONARIES.items()}.values())

# How many wrong cells are corrected, where OpenCV has changed its mind: none of an AprilTag up to 4.11, and
# since then all that can be, with which anything square is a tag now and then. AprilTag's own default is 2.
CORRECTED = {'DICT_APRILTAG_16H5': 0, 'DICT_APRILTAG_25H9': 1, 'DICT_APRILTAG_36H10': 2,
             'DICT_APRILTAG_36H11': 2, 'DICT_ARUCO_MIP_36H12': 5, 'DICT_ARUCO_ORIGINAL': 0}

SIDE_M = 0.001, 10.0  # what the side of a real tag may be
MAX_SIZE_PX = 10000
MAX_BORDER_CELLS = 10
MAX_QUIET_CELLS = 10


@dataclass(frozen=True, eq=False)
class Tag:
    """One tag seen in a frame.

    ``id``: its number in the dictionary. ``corners``: (4, 2) float32, pixels,
    clockwise from the tag's own top left (which is not the frame's when the
    tag is turned); the middle of the top left pixel is (0, 0).
    """

    id: int
    corners: Floats

    @property
    def center(self) -> Floats:
        """(2,) float32, pixels: where the diagonals cross.

        A perspective view keeps straight lines straight, so the crossing
        stays the center of the real tag; the mean of the corners does not.
        """
        top_left, top_right, bottom_right, bottom_left = np.asarray(self.corners, np.float64)
        down, up = bottom_right - top_left, bottom_left - top_right
        parallel = down[0] * up[1] - down[1] * up[0]
        if abs(parallel) < 1e-9:
            return np.mean(self.corners, axis=0, dtype=np.float32)
        across = top_right - top_left
        along = (across[0] * up[1] - across[1] * up[0]) / parallel
        return (top_left + along * down).astype(np.float32)


def get_dictionary(name: str) -> cv2.aruco.Dictionary:
    """The OpenCV dictionary of that name, such as ``DICT_6X6_250``.

    Raises InputError for a name that OpenCV does not predefine.
    """
    if name not in DICTIONARIES:
        raise InputError('There is no tag dictionary "%s"; choose one of %s.'
                         % (name, ', '.join(DICTIONARY_NAMES)))
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[name])
    dictionary.maxCorrectionBits = CORRECTED.get(name.upper(), dictionary.maxCorrectionBits)
    return dictionary


def tag_cells(dictionary: str, tag_id: int, border: int = 1) -> Image:
    """The cells of a tag: (n, n) uint8, 0 black and 255 white, border included.

    ``dictionary`` is a name, ``border`` the width of the black frame in cells.
    Raises InputError for an id that the dictionary does not have.
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


def check_size(cells: int, size: float) -> None:
    """Raise InputError if a tag that many cells wide cannot be drawn with that size in pixels."""
    if not cells <= size <= MAX_SIZE_PX:
        raise InputError('A tag %d cells wide cannot be drawn with a size of %d px; choose from %d to '
                         '%d.' % (cells, size, cells, MAX_SIZE_PX))


def check_quiet(quiet: float) -> None:
    """Raise InputError if a quiet zone of that many cells cannot be drawn."""
    if not 0 <= quiet <= MAX_QUIET_CELLS:
        raise InputError('A quiet zone of %g cells cannot be drawn; choose from 0 to %d.'
                         % (quiet, MAX_QUIET_CELLS))


def draw_tag(dictionary: str, tag_id: int, size: int = 700, border: int = 1, quiet: float = 0) -> Image:
    """One tag as a picture, (n, n) uint8, 0 black and 255 white.

    ``size`` is the side of the tag itself in pixels; ``quiet`` cells of white
    are added around it, so n = size + 2 * round(quiet * size / cells).
    Raises InputError for an id that the dictionary does not have, and for a
    size with less than one pixel for each cell.
    """
    cells = len(tag_cells(dictionary, tag_id, border))
    check_size(cells, size)
    check_quiet(quiet)
    tag = cv2.aruco.generateImageMarker(get_dictionary(dictionary), tag_id, size, borderBits=border)
    margin = round(quiet * size / cells)
    return cv2.copyMakeBorder(tag, margin, margin, margin, margin, cv2.BORDER_CONSTANT, value=(255,))


def square(sizes: Numbers) -> Floats:
    """(n, 4, 3) meters: the corners of tags of sizes (n,) in their own axes, from their own top left."""
    corners = [[-0.5, 0.5, 0], [0.5, 0.5, 0], [0.5, -0.5, 0], [-0.5, -0.5, 0]]
    return np.multiply.outer(np.asarray(sizes, np.float64), corners)
