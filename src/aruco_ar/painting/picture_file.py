"""Reading the picture that is painted into the area."""
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

# No frame shows more pixels than this. OpenCV can warp pictures of less than 32768 px.
MAX_SIDE_PX = 4096

# Limits of a file. Reading takes ten to twenty bytes of memory for each pixel. The
# largest format of video, 8192 x 4320, has 35 million pixels.
MAX_PICTURE_PIXELS = 36 * 10**6
MAX_PICTURE_BYTES = 128 * 1024 * 1024

# A progressive JPEG consists of scans, each of which covers all pixels. Programs write
# about ten. A small file can have a thousand, which would take minutes to decode.
JPEG_SCAN, MAX_SCANS = b'\xff\xda', 100
JPEGS = 'JPEG', 'MPO'  # Pillow's names of the formats
JPEG_END = b'\xff\xd9'
# What no picture continues with. In a JPEG with restart markers, one comes in time.
VALUES = bytes(range(255))
FILLING = VALUES * 8 + b''.join(VALUES + bytes([0xff, 0xd0 + number]) for number in range(8)) * 2

ORIENTATION = 0x0112  # the tag in EXIF

# Pillow's other formats need external programs, print warnings about broken files,
# or are not made for pictures.
FORMATS = 'JPEG', 'PNG', 'GIF', 'WEBP', 'BMP', 'PPM'
STILL_KINDS = 'JPEG or PNG'


def load_picture(path: str) -> Image:
    """Read a picture: (h, w, 3) BGR or, if some of it is transparent, (h, w, 4) BGRA, uint8.

    A picture with a side above MAX_SIDE_PX is shrunk to that. Raises InputError
    if the file is missing, is not a picture, or is larger than
    MAX_PICTURE_BYTES or MAX_PICTURE_PIXELS.
    """
    with opened_picture(path) as image:
        return picture_of(image)


def decode_picture(data: bytes, name: str) -> Image:
    """The same as load_picture, from the bytes of a file of that name."""
    with _opened_image(data, name, STILL_KINDS) as image:
        return picture_of(image)


def opened_picture(path: str, kinds: str = STILL_KINDS) -> ContextManager[PIL.Image.Image]:
    """A Pillow image of a file, of which only the header has been read, for a ``with`` block.

    Raises the same InputError as load_picture, also if the block finds that
    the file is broken. Its message asks for a file of those ``kinds``.
    """
    return _opened_image(read_whole(path, MAX_PICTURE_BYTES), path, kinds)


def open_header(data: bytes, formats: tuple[str, ...] = FORMATS) -> PIL.Image.Image:
    """A Pillow image of the bytes of a file, of which only the header has been read.

    Raises PIL.Image.DecompressionBombError if it has more than
    MAX_PICTURE_PIXELS. Raises many kinds of error if it has none of those
    formats, or would take too long to decode.
    """
    image = PIL.Image.open(io.BytesIO(data), formats=formats)
    if image.width * image.height > MAX_PICTURE_PIXELS:
        raise PIL.Image.DecompressionBombError('%d x %d pixels' % image.size)
    # In other formats these bytes may occur by chance.
    if image.format in JPEGS and data.count(JPEG_SCAN) > MAX_SCANS:
        raise ValueError('a JPEG with more than %d scans' % MAX_SCANS)
    return image


def with_end(image: PIL.Image.Image, data: bytes) -> bytes:
    """The bytes of a file, with the end marker if it is a JPEG that lacks only this.

    ``image``: the Pillow image of its header. Some cameras never send the marker, or fill the space after the
    picture with zeros. Raises ValueError if more is missing. Raises many kinds of error if the JPEG is broken.
    """
    if image.format not in JPEGS or data.endswith(JPEG_END) or data.rfind(JPEG_END) > data.rfind(JPEG_SCAN):
        return data
    scans = data.rstrip(b'\0')
    if scans.endswith(b'\xff'):  # either half of the marker, or a number, which is written as these two bytes
        scans += b'\0'
    # Whatever follows a picture that is whole is not looked at. If some of it is missing, it becomes that.
    ended, filled = scans + JPEG_END, scans + FILLING + JPEG_END
    if not np.array_equal(_sketch(ended), _sketch(filled)):
        raise ValueError('a JPEG that is cut off')
    return ended


def _sketch(data: bytes) -> Image:
    """A JPEG as gray in an eighth of its size, or whole if only the whole depends on all of its bytes."""
    with open_header(data, JPEGS) as image:
        if not image.info.get('progressive'):
            image.draft('L', (1, 1))
        return np.asarray(image)


@contextmanager
def _opened_image(data: bytes, name: str, kinds: str) -> Iterator[PIL.Image.Image]:
    try:
        with open_header(data) as header, open_header(with_end(header, data)) as image:
            yield image
    except PIL.Image.DecompressionBombError:
        raise too_large(name, MAX_PICTURE_PIXELS) from None
    except InputError:
        raise
    except Exception:  # Pillow raises many kinds
        raise InputError('The picture "%s" cannot be read as a picture; give a %s.'
                         % (name, kinds)) from None


def too_large(name: str, pixels: int) -> InputError:
    """The InputError for a picture or video with more than that many pixels."""
    return InputError('The picture "%s" is too large; give one of at most %d million pixels.'
                      % (name, pixels // 10**6))


def picture_of(image: PIL.Image.Image) -> Image:
    """The current frame of a Pillow image, as load_picture returns it. Raises many kinds of error if broken."""
    image = _upright(image)
    if image.mode.startswith('I'):  # 16 bits of gray
        gray = cv2.convertScaleAbs(np.asarray(image).astype(np.int32), alpha=1 / 257)
        return shrink_to_warp(cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR))
    if image.mode == 'F':
        raise ValueError('an image of floats does not say which value is white')
    mode = 'RGBA' if 'transparency' in image.info or image.mode[-1] in 'Aa' else 'RGB'
    if image.mode != mode:
        image = image.convert(mode)
    picture = np.asarray(image)
    if mode == 'RGBA' and picture[..., 3].min() < 255:
        return shrink_to_warp(cv2.cvtColor(picture, cv2.COLOR_RGBA2BGRA))
    return shrink_to_warp(cv2.cvtColor(picture[..., :3], cv2.COLOR_RGB2BGR))


def shrink_to_warp(picture: Image) -> Image:
    """The picture, (h, w, 3 or 4) uint8, shrunk if a side is longer than MAX_SIDE_PX."""
    shrink = MAX_SIDE_PX / max(picture.shape[:2])
    return resize(picture, shrink) if shrink < 1 else picture


def resize(image: Image, factor: float) -> Image:
    """The image, (h, w, ...) uint8, scaled by that factor, but at least 1 px wide and high."""
    size = [max(1, round(side * factor)) for side in image.shape[1::-1]]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR)


def _upright(image: PIL.Image.Image) -> PIL.Image.Image:
    """The image, turned upright as its EXIF data asks for."""
    try:
        turned = None if image.getexif().get(ORIENTATION, 1) == 1 else PIL.ImageOps.exif_transpose(image)
        return turned or image
    except Exception:  # Pillow raises many kinds if the EXIF data cannot be read
        return image
