"""PNGs, chunk by chunk, whether they are good or not."""
import struct
import zlib


def png(width, height, rows=b'', bits=1, kind=0, more=b''):
    """A PNG that claims this size. ``rows``: its uncompressed data. ``more``: chunks before the data."""
    return png_of(width, height, more + chunk(b'IDAT', zlib.compress(rows, 9)), bits, kind)


def png_of(width, height, chunks, bits=8, kind=0):
    """A PNG that claims this size, with these bytes between its head and its end."""
    head = struct.pack('>IIBBBBB', width, height, bits, kind, 0, 0, 0)
    return b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + chunks + chunk(b'IEND', b'')


def chunk(name, data):
    """A chunk of a PNG: the bytes of its length, name, data and checksum."""
    return struct.pack('>I', len(data)) + name + data + struct.pack('>I', zlib.crc32(name + data))
