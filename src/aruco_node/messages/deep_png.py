"""PNGs with 16 bits for each color. Pillow gives only the upper 8, which are dark if a camera uses 12."""
import struct
import zlib

import cv2
import numpy as np

SIGNATURE = b'\x89PNG\r\n\x1a\n'
# Places in the header, which is the first chunk.
FIRST, BITS, KIND, INTERLACED = slice(12, 16), 24, 25, 28
NUMBERS = {2: 3, 4: 2, 6: 4}  # per pixel, for each kind: color, gray with alpha, color with alpha
LAST_FILTER = 4               # each row begins with the number of a filter


def is_deep(data):
    """Whether the bytes of a file, whose header Pillow has read, are such a PNG.

    This is False for interlaced ones, which no camera sends.
    """
    return data[:len(SIGNATURE)] == SIGNATURE and data[FIRST] == b'IHDR' and data[BITS] == 16 and \
        data[KIND] in NUMBERS and data[INTERLACED] == 0


def colors_of(data, width, height):
    """The colors of a PNG for which is_deep is True, (h, w, 3) BGR uint16.

    Raises many kinds of error if it is broken. OpenCV would write a line to stderr about most faults of a PNG.
    So it gets one that has nothing but the pixels, after these have been found to be whole.
    """
    row = 1 + 2 * NUMBERS[data[KIND]] * width
    packed, whole = _packed_pixels(data), zlib.decompressobj()
    rows = whole.decompress(packed, row * height)
    if len(rows) != row * height or max(rows[::row]) > LAST_FILTER or \
            whole.decompress(whole.unconsumed_tail, 1) or not whole.eof:
        raise ValueError('a broken PNG')
    del rows  # they may take hundreds of megabytes
    header = struct.pack('>IIBBBBB', width, height, 16, data[KIND], 0, 0, 0)
    used = packed[:len(packed) - len(whole.unused_data)]
    clean = SIGNATURE + _chunk(b'IHDR', header) + _chunk(b'IDAT', used) + _chunk(b'IEND', b'')
    return np.ascontiguousarray(cv2.imdecode(np.frombuffer(clean, np.uint8), cv2.IMREAD_UNCHANGED)[..., :3])


def _packed_pixels(data):
    """The contents of all IDAT chunks."""
    parts, at = [], len(SIGNATURE)
    while at + 8 <= len(data):
        length, kind = struct.unpack_from('>I4s', data, at)
        if kind == b'IDAT':
            parts.append(data[at + 8:at + 8 + length])
        at += 12 + length  # with its length, kind and checksum
    return b''.join(parts)


def _chunk(kind, content):
    return struct.pack('>I', len(content)) + kind + content + struct.pack('>I', zlib.crc32(kind + content))
