"""Files of tags: what a learner's program wrote, and whether each file shows the tag that it should."""
from __future__ import annotations

import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, Sequence

import cv2
import numpy as np
from aruco_ar.base.arrays import Image

from aruco_course.check import Fault, Written

DICTIONARY = 'DICT_6X6_250'
SAME_TAGS = re.compile('DICT_6[Xx]6_')  # the first tags of these dictionaries are the same
WANTED = 1, 2, 3, 4
FOLDER = 'Tags'
ENDINGS = '.jpg', '.jpeg', '.png', '.bmp', '.tif', '.tiff', '.webp', '.pgm', '.ppm', '.gif', '.jp2'
LEAST_PX = 100        # the least width and height of a tag's file
MARGIN = 0.2          # width of the white margin that is added, as on paper: a share of the image's size
ASPECT = 0.05         # by how much a file may be wider than high, or higher than wide
GRAY = 60, 195        # between these levels, a pixel is neither black nor white
MOST_GRAY = 0.25      # share of such pixels from which on a tag is blurred
BLURRED = 'The tag is blurred. Draw it in the size that you want; if you enlarge it, use cv2.INTER_NEAREST.'
CLEAR_PX = 256        # files are looked at in at most about this size


def image_files(folder: Path) -> dict[Path, tuple[int, int, int]]:
    """The image files in a folder and below, not in hidden ones, with what changes when they are written."""
    found = {}
    for parent, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith('.')]
        for name in names:
            if name.lower().endswith(ENDINGS):
                path = Path(parent, name)
                with suppress(OSError):  # it is gone, or a link to what is
                    status = path.stat()
                    found[path] = status.st_mtime_ns, status.st_ctime_ns, status.st_ino
    return found


def files_fault(written: Written) -> Fault | None:
    """The first Fault in the files that a program wrote: of the tags 1 to 4, in the folder Tags."""
    here = [path for path in dict.fromkeys(written.paths) if _is_in(path, written.folder / FOLDER)]
    if not here:
        return Fault(_nothing(written))
    seen = {path: _look(path) for path in sorted(here)}
    good = {path: look for path, look in seen.items() if look.ids}
    # A file that is no tag is no mistake if the others are right, such as a sheet of all tags.
    for path, look in seen.items():
        if not look.ids and (set(WANTED) - {tag_id for other in good.values() for tag_id in other.ids}):
            return Fault(look.fault, _name(path))
    for path, look in good.items():
        if look.fault:
            return Fault(look.fault, _name(path))
    return _ids_fault({path: look.ids for path, look in good.items()}, written)


@dataclass(frozen=True)
class Look:
    """What a file shows: the ids of its tags, and what is wrong with it, or nothing."""

    ids: tuple[int, ...]
    fault: str = ''


def _nothing(written: Written) -> str:
    """Why there is no new file in the folder Tags."""
    if written.refused:
        path = written.refused[0]
        why = ('Only a shell knows what ~ is: os.path.expanduser(path) replaces it.'
               if path.parts[0] == '~' else
               'Such a path begins at the folder from which the program is started. One that is made of that '
               "of your file does not: TAGS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath("
               "__file__))), 'Tags')."
               if not path.is_absolute() and path.parent.name else
               'There is no folder %s. The folder for it is TAGS: os.path.join(TAGS, %r).'
               % (path.parent, path.name)
               if path.parent != written.folder / FOLDER and not path.parent.is_dir() else
               'There is no folder %s. Make it first: os.makedirs(TAGS, exist_ok=True).' % path.parent
               if not path.parent.is_dir() else
               'Its name has no ending, such as .jpg.' if not path.suffix else
               'OpenCV writes no files that end in %s.' % path.suffix if path.suffix.lower() not in ENDINGS else
               'Perhaps it may not write there.')
        return '%s was not written: cv2.imwrite only returns False then. %s' % (path, why)
    if written.paths:
        path = written.paths[-1]
        to = str(path.parent) if _is_in(path, written.folder) \
            else 'the folder that it is started from, which may be any'
        return ('Your program writes %s into %s. Write the files into the folder Tags of your package, '
                'which is %s.' % (path.name, to, written.folder / FOLDER))
    if written.elsewhere:
        return ('Your program writes %s. Write the files into the folder Tags of your package: '
                'os.path.join(TAGS, %r).' % (written.elsewhere[0], written.elsewhere[0].name))
    old = image_files(written.folder / FOLDER)
    return ('Your program writes no image%s. Does it call cv2.imwrite, and is main() called?'
            % ('; those in the folder Tags are older' if old else ' into the folder Tags'))


def _is_in(path: Path, folder: Path) -> bool:
    try:
        path.resolve().relative_to(folder.resolve())
    except ValueError:
        return False
    return True


def _name(path: Path) -> str:
    return '%s/%s' % (FOLDER, path.name)


def _look(path: Path) -> Look:
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        return Look((), 'It cannot be read: %s.' % (error.strerror or error))
    image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if len(data) else None
    if image is None:
        return Look((), 'It is no image that can be read.')
    ids = _ids(image)
    height, width = image.shape
    if ids:
        return Look(ids, _form_fault(image) if len(ids) == 1 else '')
    if max(width, height) < LEAST_PX:
        return Look((), _small(width, height))
    return Look((), next(_guesses(image), 'No tag of %s is seen in it, not even on white paper.' % DICTIONARY))


def _form_fault(image: Image) -> str:
    """What is wrong with the image of a tag that can be read, or nothing."""
    height, width = image.shape
    if min(width, height) < LEAST_PX:
        return _small(width, height)
    if max(width, height) > (1 + ASPECT) * min(width, height):
        return 'It has %d x %d pixels, but a tag is a square.' % (width, height)
    return BLURRED if _is_blurred(image) else ''


def _is_blurred(image: Image) -> bool:
    return bool(np.mean((image > GRAY[0]) & (image < GRAY[1])) > MOST_GRAY)


def _small(width: int, height: int) -> str:
    return ('It has only %d x %d pixels, so the tag is blurred when it is printed. Draw it with at least %d, '
            'better with 700.' % (width, height, LEAST_PX))


def _on_paper(image: Image, paper: int = 255) -> Image:
    margin = max(10, round(MARGIN * max(image.shape)))
    return cv2.copyMakeBorder(image, margin, margin, margin, margin, cv2.BORDER_CONSTANT, value=(paper,))


def _ids(image: Image, dictionary: int = cv2.aruco.DICT_6X6_250, border: int = 1) -> tuple[int, ...]:
    """The ids of the tags in an image, (h, w) uint8, that lies on white paper."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.markerBorderBits = border
    factor = max(image.shape) / CLEAR_PX
    if factor > 1:
        image = cv2.resize(image, None, fx=1 / factor, fy=1 / factor, interpolation=cv2.INTER_AREA)
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary), parameters)
    ids = detector.detectMarkers(_on_paper(image))[1]
    return () if ids is None else tuple(sorted(set(ids.ravel().tolist())))


def _guesses(image: Image) -> Iterator[str]:
    """What may be wrong with an image in which no tag is seen."""
    if np.all(image == image[0, 0]):
        yield 'It is of one color only. Is the tag drawn, and is it what draw_tag returns?'
        return
    if image.max() <= 8:
        yield 'It is black: white is 255, not 1.'
        return
    if _is_blurred(image):
        yield BLURRED
        return
    for name, number in sorted(_dictionaries().items(), key=lambda item: ('6X6' not in item[0], item[0])):
        found = _ids(image, number)
        if found and not SAME_TAGS.match(name):
            yield ('It shows a tag of %s, but the tags are to be of %s: a camera that looks for those does not '
                   'find it.' % (_nicer(name), DICTIONARY))
            return
    if _ids(cv2.bitwise_not(image)):
        yield 'Black and white are exchanged: the border of a tag is black, and the paper around it white.'
    if _ids(cv2.flip(image, 1)):
        yield 'The tag is mirrored.'
    cells = max(1, round(max(image.shape) / 6))
    bordered = cv2.copyMakeBorder(image, cells, cells, cells, cells, cv2.BORDER_CONSTANT, value=(0,))
    if _ids(bordered):
        yield 'The black border around the tag is missing, which is as wide as a cell of the pattern.'
    for border in 2, 3, 4:
        if _ids(image, border=border):
            yield 'The black border is %d cells wide. Make it 1 cell wide: that is looked for.' % border


def _dictionaries() -> dict[str, int]:
    """{name: number}: those of OpenCV whose tags have fewer or more cells, or other patterns."""
    return {name: getattr(cv2.aruco, name) for name in dir(cv2.aruco) if re.fullmatch('DICT_.*[0-9LA]', name)
            and not (name.endswith(('_50', '_100', '_250')) and 'X' in name)}


def _nicer(name: str) -> str:
    return re.sub('_1000$', '', name)


def _ids_fault(ids: dict[Path, tuple[int, ...]], written: Written) -> Fault | None:
    """The Fault in which tags the files show, if each file shows one."""
    every = [tag_id for found in ids.values() for tag_id in found]
    missing = sorted(set(WANTED) - set(every))
    several = [path for path, found in ids.items() if len(found) > 1]
    alone = {found[0] for found in ids.values() if len(found) == 1}
    if several and not set(WANTED) <= alone:
        return Fault('It shows the tags %s. Write each tag into a file of its own.'
                     % _list(ids[several[0]]), _name(several[0]))
    if missing:
        return Fault(_missing(ids, every, missing, written))
    for path, found in ids.items():
        numbers = [int(number) for number in re.findall('[0-9]+', path.stem)]
        if numbers and len(found) == 1 and found[0] in WANTED and found[0] not in numbers:
            return Fault('It shows tag %d, not the one that its name tells.' % found[0], _name(path))
    return None


def _missing(ids: dict[Path, tuple[int, ...]], every: Sequence[int], missing: Sequence[int],
             written: Written) -> str:
    if set(every) == {0, 1, 2, 3}:
        return ('The tags have the ids 0, 1, 2, 3: range(4) begins at 0. range(1, 5) is 1, 2, 3, 4, since the '
                'end does not count.')
    if set(every) == {1, 2, 3}:
        return 'Tag 4 is missing: range(1, 4) ends before 4. range(1, 5) is 1, 2, 3, 4.'
    if len(ids) == 1:
        return ('There is only one file, %s, with tag %d. If all four tags are written to one name, each '
                'replaces the one before: put the id into the name.' % (_name(next(iter(ids))), every[0]))
    if len(set(every)) == 1:
        return 'All files show tag %d. Draw each with an id of its own: 1, 2, 3, 4.' % every[0]
    return ('The tags %s are missing. The files show the tags %s; write those with the ids 1, 2, 3, 4.'
            if len(missing) > 1 else
            'Tag %s is missing. The files show the tags %s; write those with the ids 1, 2, 3, 4.') % (
                _list(missing), _list(sorted(set(every))))


def _list(ids: Sequence[int]) -> str:
    return ', '.join(map(str, ids))
