"""The picture: what is painted into the area."""
from __future__ import annotations

import io
from contextlib import contextmanager
from typing import ContextManager, Iterator

import cv2
import numpy as np
import PIL.Image
import PIL.ImageOps

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import read_whole

# More than a frame can show; OpenCV warps pictures of less than 32768 px.
MAX_SIDE_PX = 4096

# Of a file. A picture takes ten to twenty bytes a pixel while it is read. The
# largest format of video, 8192 x 4320, has 35 million pixels.
MAX_PICTURE_PIXELS = 36 * 10**6
MAX_PICTURE_BYTES = 128 * 1024 * 1024

# A progressive JPEG is made of scans, each of which goes over all pixels. Programs
# write about ten; a thousand of them, which need not be long, take minutes.
JPEG_SCAN, MAX_SCANS = b'\xff\xda', 100

ORIENTATION = 0x0112  # in EXIF

# Others that Pillow knows take other programs, print what they think of broken
# files, or are no pictures to look at.
FORMATS = 'JPEG', 'PNG', 'GIF', 'WEBP', 'BMP', 'PPM'
STILLS = 'JPEG or PNG'


def load_picture(path: str) -> Image:
    """Read a picture: (h, w, 3) BGR or, if some of it is clear, (h, w, 4) BGRA, uint8.

    One with a side above MAX_SIDE_PX is shrunk to that. Raises InputError if
    the file is missing, is not a picture, or is larger than MAX_PICTURE_BYTES
    or MAX_PICTURE_PIXELS.
    """
    with opened_picture(path) as image:
        return picture_of(image)


def decode_picture(data: bytes, name: str) -> Image:
    """As load_picture, from the bytes of a file of that name."""
    with _opened_image(data, name, STILLS) as image:
        return picture_of(image)


def opened_picture(path: str, kinds: str = STILLS) -> ContextManager[PIL.Image.Image]:
    """A Pillow image of a file of which only the header has been looked at, for a ``with`` block.

    Raises InputError, in which it tells to give a file of those ``kinds``, as
    load_picture does, also where the block finds the file broken.
    """
    return _opened_image(read_whole(path, MAX_PICTURE_BYTES), path, kinds)


def open_header(data: bytes, formats: tuple[str, ...] = FORMATS) -> PIL.Image.Image:
    """A Pillow image of the bytes of a file, of which only the header has been looked at.

    Raises PIL.Image.DecompressionBombError if it has more than
    MAX_PICTURE_PIXELS, and many kinds of error if it is none of those formats
    or takes too long to read.
    """
    image = PIL.Image.open(io.BytesIO(data), formats=formats)
    if image.width * image.height > MAX_PICTURE_PIXELS:
        raise PIL.Image.DecompressionBombError('%d x %d pixels' % image.size)
    # Others have these bytes by chance.
    if image.format in ('JPEG', 'MPO') and data.count(JPEG_SCAN) > MAX_SCANS:
        raise ValueError('a JPEG of more than %d scans' % MAX_SCANS)
    return image


@contextmanager
def _opened_image(data: bytes, name: str, kinds: str) -> Iterator[PIL.Image.Image]:
    try:
        with open_header(data) as image:
            yield image
    except PIL.Image.DecompressionBombError:
        raise too_large(name, MAX_PICTURE_PIXELS) from None
    except InputError:
        raise
    except Exception:  # Pillow raises many kinds
        raise InputError('The picture "%s" is no picture that can be read; give a %s.'
                         % (name, kinds)) from None


def too_large(name: str, pixels: int) -> InputError:
    """The InputError for a picture or video of more pixels than that."""
    return InputError('The picture "%s" is too large; give one of at most %d million pixels.'
                      % (name, pixels // 10**6))


def picture_of(image: PIL.Image.Image) -> Image:
    """What a Pillow image shows now, as of load_picture. Raises many kinds of error where it is broken."""
    image = _upright(image)
    if image.mode.startswith('I'):  # 16 bits of gray
        gray = cv2.convertScaleAbs(np.asarray(image).astype(np.int32), alpha=1 / 257)
        return shrink_to_warp(cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR))
    if image.mode == 'F':
        raise ValueError('how bright its 1.0 is, it does not say')
    mode = 'RGBA' if 'transparency' in image.info or image.mode[-1] in 'Aa' else 'RGB'
    if image.mode != mode:
        image = image.convert(mode)
    picture = np.asarray(image)
    if mode == 'RGBA' and picture[..., 3].min() < 255:
        return shrink_to_warp(cv2.cvtColor(picture, cv2.COLOR_RGBA2BGRA))
    return shrink_to_warp(cv2.cvtColor(picture[..., :3], cv2.COLOR_RGB2BGR))


def shrink_to_warp(picture: Image) -> Image:
    """The picture, (h, w, 3 or 4) uint8, no larger than can be warped."""
    shrink = MAX_SIDE_PX / max(picture.shape[:2])
    return resize(picture, shrink) if shrink < 1 else picture


def resize(image: Image, factor: float) -> Image:
    """The image, (h, w, ...) uint8, made that many times as large, but at least 1 px."""
    size = [max(1, round(side * factor)) for side in image.shape[1::-1]]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR)


def _upright(image: PIL.Image.Image) -> PIL.Image.Image:
    """The image turned as its camera noted it."""
    try:
        turned = None if image.getexif().get(ORIENTATION, 1) == 1 else PIL.ImageOps.exif_transpose(image)
        return turned or image
    except Exception:  # the note cannot be read, of which Pillow says much
        return image
