"""Hostile files, and some files that look odd but are good."""
import io
import os
import random
import re
import socket
import struct
import zlib
from typing import NamedTuple

import cv2
import numpy as np
from PIL import Image

from .png import chunk, png
from .yaml_texts import TEXTS

GIGANTIC = 20 * 2**30  # bytes: the size of a sparse file, which takes no space on the disk


class Case(NamedTuple):
    """A file; ``is_picture`` says whether it can be read as a picture, or is None if both are right."""

    name: str
    path: str
    is_picture: bool = None


def cases(folder, seed=1):
    """Create all files in a folder; yields a Case for each. Some paths lead elsewhere, or nowhere."""
    for name, path in _paths(folder):
        yield Case(name, path, False)
    contents = [_good_pictures(), _broken_pictures(), _bombs(), _cut(seed),
                [(name + '.yaml', text, False) for name, text in TEXTS.items()]]
    for number, (name, data, is_picture) in enumerate(entry for part in contents for entry in part):
        path = os.path.join(folder, '%d %s' % (number, name))
        with open(path, 'wb') as file:
            file.write(data)
        yield Case(name, path, is_picture)
    for name, data in (('zeros.jpg', b''), ('jpeg.jpg', jpeg()), ('video.mp4', video('.mp4', 'mp4v')[:200]),
                       ('webp.webp', b'RIFF\xff\xff\xff\xffWEBPVP8X'), ('yaml.yaml', b'areas: []\n')):
        path = os.path.join(folder, 'gigantic ' + name)
        with open(path, 'wb') as file:
            file.write(data)
            file.truncate(GIGANTIC)
        yield Case('gigantic ' + name, path, False)


def _paths(folder):
    """(name, path) of what is not a readable file."""
    def at(name):
        return os.path.join(folder, name)
    yield 'missing', at('missing.jpg')
    yield 'folder', folder
    os.mkfifo(at('pipe.mp4'))
    yield 'pipe', at('pipe.mp4')
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(at('socket'))
    yield 'socket', at('socket')
    for name, target in (('loop', 'loop'), ('dangling', 'missing'), ('to a pipe', 'pipe.mp4'),
                         ('to a device', '/dev/zero')):
        os.symlink(target, at('link ' + name))
        yield 'link ' + name, at('link ' + name)
    for device in ('/dev/zero', '/dev/null', '/dev/full', '/dev/random', '/dev/tty', '/proc/self/mem',
                   '/proc/self/pagemap'):
        yield device, device
    if os.getuid() != 0:  # root may read everything
        os.close(os.open(at('private'), os.O_CREAT, 0))
        yield 'private', at('private')
    for name, path in (('long name', 'n' * 256), ('long path', 'p/' * 2500), ('lines', 'a\nb\r\x1b[31m.jpg'),
                       ('not UTF-8', 'a\udcff.mp4'), ('no text', 'a\ud800.png'), ('zero', 'a\0b'),
                       ('empty', ''), ('below a file', 'socket/a.jpg')):
        yield 'path: ' + name, path and at(path)
    yield 'path: nobody', '~nobody/a.jpg'
    yield 'path: address', 'http://localhost:1/a.mp4'


def jpeg(width=60, height=40, **options):
    file = io.BytesIO()
    Image.new('RGB', (width, height), (200, 100, 50)).save(file, 'JPEG', **options)
    return file.getvalue()


def picture(kind, mode='RGB', size=(60, 40), **options):
    """The bytes of a file with a picture of one color."""
    file, image = io.BytesIO(), Image.new(mode, size, 1)
    if mode == 'P':  # without a palette, Pillow 11 writes a BMP that nobody can read
        image.putpalette([number // 3 for number in range(3 * 256)])
    image.save(file, kind, **options)
    return file.getvalue()


def animation(kind, count=3, size=(60, 40)):
    """The bytes of an animated picture."""
    file = io.BytesIO()
    first, *others = [Image.new('RGB', size, (number * 40, 90, 200)) for number in range(count)]
    first.save(file, kind, save_all=True, append_images=others, duration=100)
    return file.getvalue()


def video(suffix, fourcc, size=(64, 48), count=8):
    """The bytes of a video."""
    path = '/dev/shm/unit5-%d%s' % (os.getpid(), suffix)
    writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*fourcc), 10, size)
    for number in range(count):
        writer.write(np.full((size[1], size[0], 3), 25 * number, np.uint8))
    writer.release()
    with open(path, 'rb') as file:
        os.unlink(path)
        return file.read()


def _good_pictures():
    yield 'picture.jpg', jpeg(), True
    yield 'a PNG.mp4', picture('PNG'), True
    yield 'a JPEG.gif', jpeg(), True
    yield 'a GIF', animation('GIF'), True
    yield 'no suffix', video('.mp4', 'mp4v'), True
    yield 'not UTF-8 \udcff.mp4', video('.mp4', 'mp4v'), True
    yield 'two\nlines.jpg', jpeg(), True
    yield 'a video.jpg', video('.avi', 'MJPG'), True
    for kind, mode in (('JPEG', 'CMYK'), ('JPEG', 'L'), ('PNG', '1'), ('PNG', 'P'), ('PNG', 'LA'),
                       ('PNG', 'RGBA'), ('PNG', 'I;16'), ('WEBP', 'RGBA'), ('BMP', 'P'),
                       ('PPM', '1'), ('GIF', 'L')):
        yield '%s of %s' % (mode, kind), picture(kind, mode), True
    yield '16 bits.png', cv2.imencode('.png', np.full((9, 9, 4), 0x8080, np.uint16))[1].tobytes(), True
    yield 'key color.png', picture('PNG', 'P', transparency=1), True
    yield 'as large as allowed.png', png(8192, 4320, bytes(1025 * 4320)), True
    yield 'one line.png', png(2**25, 1, bytes(2**22 + 1)), None
    for name, exif in (('broken', b'MM\0*\0\0\0\x08\xff\xff\x01\x12'),
                       ('endless', b'II*\0\x08\0\0\0' + b'\xff' * 999),
                       ('turned 99', b'MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x63' + bytes(6))):
        yield 'EXIF %s.jpg' % name, jpeg(exif=b'Exif\0\0' + exif), True
    profile = chunk(b'iCCP', b'sRGB\0\0' + zlib.compress(b'no profile'))
    yield 'color profile.png', png(9, 9, bytes(27), more=profile), True
    yield 'comment.jpg', jpeg()[:2] + b'\xff\xfe\xff\xff' + bytes(65533) + jpeg()[2:], True


def _broken_pictures():
    yield 'empty.jpg', b'', False
    yield 'text.jpg', b'no picture', False
    yield 'zeros.png', bytes(1000), False
    yield 'picture.svg', b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>', False
    yield 'picture.eps', b'%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\nshowpage\n', False
    yield 'paper.pdf', b'%PDF-1.4\n', False
    yield 'picture.tiff', picture('TIFF', compression='tiff_lzw')[:-200], False
    yield 'floats.tiff', cv2.imencode('.tiff', np.ones((8, 8, 4), np.float32))[1].tobytes(), False
    yield 'floats.exr', b'v/1\x01\x02\0\0\0channels\0', False
    yield '0 x 0.png', png(0, 0), False
    yield '0 x 0.gif', b'GIF89a\0\0\0\0\x80\0\0' + bytes(6) + b';', False
    yield 'no data.png', png(60, 40), False
    yield 'half.jpg', re.sub(rb'\xff\xd9$', b'', jpeg(600, 400)[:-2000]), False
    # Texts that FFmpeg takes for videos, and that lead it to other files.
    yield 'list.mp4', b'#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\nfile:///dev/zero\n#EXT-X-ENDLIST\n', False
    yield 'list.m3u8', b'#EXTM3U\n#EXTINF:9,\nhttp://localhost:1/a.mp4\n', False
    yield 'concat.mp4', b'ffconcat version 1.0\nfile pipe.mp4\n', False
    yield 'session.sdp', b'v=0\no=- 0 0 IN IP4 127.0.0.1\nc=IN IP4 127.0.0.1\nm=video 5004 RTP/AVP 96\n', False


def _bombs():
    yield 'bomb.png', png(60000, 60000, bytes(10**6)), False
    yield 'gray bomb.png', png(9000, 4096, bytes(1126 * 4096)), False
    yield 'scans.jpg', _scans(500), False
    text = chunk(b'zTXt', b'a\0\0' + zlib.compress(bytes(2**24), 9))
    yield 'text bomb.png', png(9, 9, bytes(27), more=text), None
    yield 'bomb.jpg', _resized_jpeg(jpeg(), 65000, 65000), False
    wide = b',\0\0\0\0\xff\xff\xff\xff\0\x02\x02D\x01\0'  # a frame of a GIF
    yield 'bomb.gif', b'GIF89a\xff\xff\xff\xff\x80\0\0' + bytes(6) + wide + b';', False
    # Its canvas is small, but its second frame is not.
    yield 'growing.gif', animation('GIF', 1)[:-1] + wide + b';', None
    # Each of its frames is one pixel, and takes only a few bytes.
    yield '100000 frames.gif', b'GIF89a\x09\0\x09\0\x80\0\0' + bytes(6) + \
        100000 * b',\0\0\0\0\x01\0\x01\0\0\x02\x02D\x01\0' + b';', True
    moving = animation('WEBP')
    yield 'bomb.webp', moving[:24] + b'\xff\x3f\0\xff\x3f\0' + moving[30:], False
    yield 'bomb.bmp', b'BM' + struct.pack('<IIIIiiHH', 100, 0, 54, 40, 2**30, 2**30, 1, 24) + bytes(60), False
    yield 'bomb.ppm', b'P6 60000 60000 255\n' + bytes(100), False
    yield 'bomb: large.gif', animation('GIF', 2, (4200, 2200)), False
    yield 'bomb: 5K.avi', _resized_jpeg(video('.avi', 'MJPG'), 5120, 2880), False
    yield 'bomb.avi', _resized_jpeg(video('.avi', 'MJPG'), 16000, 16000), False


def _scans(count):
    """A progressive JPEG whose last scan is repeated many times."""
    data = jpeg(progressive=True)
    last = data.rindex(b'\xff\xda')
    return data[:last] + count * data[last:-2] + data[-2:]


def _resized_jpeg(data, width, height):
    """A JPEG, or an AVI of JPEGs, that claims another size."""
    for place, size in ((rb'(\xff\xc0\0\x11\x08)....', struct.pack('>HH', height, width)),
                        (rb'(strf....\x28\0\0\0)........', struct.pack('<ii', width, height))):
        data = re.sub(place, lambda found, size=size: found.group(1) + size, data, flags=re.DOTALL)
    return data


def _cut(seed):
    """Good files that are cut off, and good files in which some bytes are changed."""
    dice = random.Random(seed)
    good = {'c.jpg': jpeg(), 'progressive.jpg': jpeg(progressive=True), 'c.png': picture('PNG', 'RGBA'),
            'c.gif': animation('GIF'), 'c.webp': animation('WEBP'), 'a.png': animation('PNG'),
            'c.bmp': picture('BMP'), 'c.ppm': picture('PPM'), 'c.mp4': video('.mp4', 'mp4v'),
            'c.avi': video('.avi', 'MJPG'), 'c.mkv': video('.mkv', 'mp4v'), 'vp8.mkv': video('.mkv', 'VP80')}
    for name, data in good.items():
        for part in (0.05, 0.3, 0.6, 0.9):
            yield 'cut at %g %s' % (part, name), data[:int(len(data) * part)], None
        for number in range(4):
            other = bytearray(data)
            for _ in range(number + 1):
                other[dice.randrange(len(other))] = dice.randrange(256)
            yield 'changed %d %s' % (number, name), bytes(other), None
