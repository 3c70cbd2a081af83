"""Hostile images, compressed images and calibrations, and some good ones. A seed determines them."""
import io
import struct
import zlib
from random import Random

import cv2
import numpy as np
from PIL import Image as Picture
from rospy import Time
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from hostile.files.png import chunk, png_of

KNOWN = ['bgr8', 'rgb8', 'bgra8', 'rgba8', 'mono8', 'bgr16', 'rgb16', 'bgra16', 'rgba16', 'mono16', 'yuv422',
         'yuv422_yuy2', *('bayer_%s%d' % (order, bits) for order in ('rggb', 'bggr', 'gbrg', 'grbg')
                          for bits in (8, 16))]
UNKNOWN = ['', '8UC1', '8UC3', '8UC0', '8UC-1', '8UC513', '8SC1', '16UC1', '16SC1', '32SC1', '32FC1', '32FC3',
           '64FC4', 'BGR8', 'bgr8 ', ' bgr8', 'bgr8; jpeg compressed', 'jpeg', 'yuyv', 'uyvy', 'nv21', 'mono12',
           'mono', 'bayer', 'rgb\0', 'rgb8\n[ERROR] false line', 'bgr८', '⚠', '%s%n', 'x' * 1000]
SIDES = [1, 2, 3, 5, 7, 8, 15, 16, 33, 64]
HUGE = [32767, 65000, 65536, 10**6, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1]
SECONDS = [0, 1, 10**9, 2**31 - 1, 2**31, 2**32 - 1]
NANOSECONDS = [0, 1, 999999999, 10**9, 2**31, 2**32 - 1]
FRAMES = ['', '/', '//', 'eye', '/eye', 'a b', 'a\nb', 'é⚠', 'tag_1', '\0', '%s', '../..', 'x' * 300]
FORMATS = ['', 'jpeg', 'png', 'bgr8; jpeg compressed bgr8', '16UC1; compressedDepth', 'é\n', 'x' * 1000]
FLOATS = [float('nan'), float('inf'), -float('inf'), 0.0, -1.0, 1e-300, 1e-3, 1e300, 5e5, 2e6, 320.0]
GOOD = 0.05   # the share of good messages
LARGE = 0.05  # the share of the good ones that have megabytes


class Garbage:
    """A message that claims a type, but consists of other bytes."""

    def __init__(self, like, data):
        self._data, self.header = data, Header()
        self._type, self._md5sum, self._has_header = like._type, like._md5sum, False

    def serialize(self, buff):
        buff.write(self._data)


class Hostile:
    """Makes hostile messages, which are always the same for a seed."""

    def __init__(self, seed, frames):
        """``frames``: a list of good frames, (h, w, 3) BGR uint8."""
        self._random = Random(seed)
        self._noise = np.random.RandomState(seed).bytes(1 << 16)
        self._frames = [cv2.resize(frame, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
                        for frame in frames for scale in (0.25, 0.4, 0.5)]
        kinds = ('.jpg', []), ('.png', []), ('.jpg', [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])
        self._files = [cv2.imencode(kind, frame, options)[1].tobytes()
                       for frame in self._frames for kind, options in kinds]
        self._files += [cv2.imencode('.png', changed)[1].tobytes() for frame in self._frames for changed in (
            frame[..., 0], cv2.cvtColor(frame, cv2.COLOR_BGR2BGRA), np.uint16(frame) * 257)]
        self._others = _other_formats(self._frames[0])
        self._bombs = _bombs()
        self._large = cv2.resize(frames[0], (1280, 960))
        self._large_file = cv2.imencode('.png', self._large)[1].tobytes()

    def image(self):
        """An Image, or Garbage."""
        return self._one_of(self._good_image, self._unknown_image, self._wrong_step, self._cut_off,
                            self._gigantic, self._empty_image, self._garbage(Image), self._of_floats,
                            self._noisy_image)

    def compressed(self):
        """A CompressedImage, or Garbage."""
        return self._one_of(self._good_file, self._cut_file, self._damaged_file, self._other_file, self._bomb,
                            self._patched_file, self._random_file, self._garbage(CompressedImage))

    def camera_info(self):
        """A CameraInfo with numbers of all kinds, or a good one for some of the images."""
        pick, number = self._random.choice, self._number
        info = CameraInfo(header=self.header())
        sizes = [frame.shape[:2] for frame in self._frames]
        info.height, info.width = pick([*sizes, (0, 0), (1, 1), (480, 2**32 - 1)])
        if self._random.random() < 0.3:
            info.K = [info.width, 0.0, info.width / 2, 0.0, info.width, info.height / 2, 0.0, 0.0, 1.0]
            return info
        info.distortion_model = pick(['plumb_bob', 'rational_polynomial', 'equidistant', '', 'é\n', 'x' * 999])
        info.D = [number() for _ in range(pick([0, 1, 3, 4, 5, 8, 12, 14, 15, 1000]))]
        info.K = pick([[0.0] * 9, [500.0, 0, 320, 0, 500, 240, 0, 0, 1], [number() for _ in range(9)],
                       [number(), 0.0, number(), 0.0, number(), number(), 0.0, 0.0, 1.0]])
        info.P = [number() for _ in range(12)]
        info.binning_x, info.binning_y = pick([0, 1, 2, 2**32 - 1]), pick([0, 1, 2])
        info.roi.x_offset, info.roi.width = pick([0, 2**32 - 1]), pick([0, 640, 1])
        info.roi.height = pick([0, 480])
        return info

    def largest(self, kind):
        """The messages, Image or CompressedImage, that take the most memory; each kind comes several times."""
        height, width = self._large.shape[:2]
        if kind is CompressedImage:
            return [self._compressed(self._large_file) for _ in range(5)]
        return [self._image(width, height, encoding) for encoding in KNOWN for _ in range(3)]

    def header(self):
        """A Header with a random stamp and frame_id."""
        header = Header(stamp=Time(), frame_id=self._random.choice(FRAMES))
        header.stamp.secs, header.stamp.nsecs = self._random.choice(SECONDS), self._random.choice(NANOSECONDS)
        return header

    def _one_of(self, good, *bad):
        return (good if self._random.random() < GOOD else self._random.choice(bad))()

    def _number(self):
        return self._random.choice([self._random.choice(FLOATS), self._random.uniform(-1000, 1000)])

    def _bytes(self, count):
        start = self._random.randrange(1000)
        return (self._noise[start:start + count] + bytes(max(count - 60000, 0)))[:count].ljust(count, b'\0')

    def _image(self, width, height, encoding, step=None, data=None):
        step = width * _size_of(encoding) if step is None else step
        return Image(header=self.header(), width=width, height=height, encoding=encoding, step=step,
                     is_bigendian=self._random.choice([0, 0, 1, 2, 255]),
                     data=self._bytes(step * height) if data is None else data)

    def _good_image(self):
        frame = self._large if self._random.random() < LARGE else self._random.choice(self._frames)
        encoding = self._random.choice(['bgr8', 'mono8', 'bgr16', 'bayer_rggb8'])
        pixels = {'bgr8': frame, 'bgr16': np.uint16(frame) * 257}.get(encoding, frame[..., 0])
        image = self._image(frame.shape[1], frame.shape[0], encoding, data=pixels.tobytes())
        image.is_bigendian = 0
        return image

    def _noisy_image(self):
        return self._image(self._side(), self._side(), self._random.choice(KNOWN))

    def _unknown_image(self):
        return self._image(self._side(), self._side(), self._random.choice(UNKNOWN))

    def _wrong_step(self):
        image = self._noisy_image()
        image.step = max(0, image.step + self._random.choice([-1000, -2, -1, 1, 2, 7, 1000]))
        if self._random.random() < 0.5:
            image.data = self._bytes(image.step * image.height)
        return image

    def _cut_off(self):
        image = self._noisy_image()
        image.data = self._random.choice([image.data[:self._random.randrange(len(image.data) + 1)],
                                          image.data + self._bytes(self._random.randrange(100))])
        return image

    def _gigantic(self):
        image = self._noisy_image()
        names = self._random.choice([['width'], ['height'], ['width', 'height'], ['step'],
                                     ['width', 'height', 'step']])
        for name in names:
            setattr(image, name, self._random.choice(HUGE))
        return image

    def _empty_image(self):
        return self._random.choice([Image(), self._image(0, self._side(), 'bgr8'),
                                    self._image(self._side(), 0, 'bgr8')])

    def _of_floats(self):
        encoding, width, height = self._random.choice(['32FC1', '32FC3', '64FC1', 'mono16', 'bgr8']), 8, 8
        count = width * height * _size_of(encoding) // 4
        data = np.float32([self._random.choice(FLOATS[:5]) for _ in range(count)]).tobytes()
        return self._image(width, height, encoding, data=data)

    def _garbage(self, kind):
        def make():
            good = io.BytesIO()
            (self._noisy_image if kind is Image else self._good_file)().serialize(good)
            good = good.getvalue()[:4000]
            place = self._random.randrange(len(good))
            return Garbage(kind, self._random.choice([
                b'', self._bytes(self._random.randrange(100)), good[:place],
                good[:place] + b'\xff' * 4 + good[place + 4:], good[:12] + b'\2\0\0\0\xff\xfe' + good[16:]]))
        return make

    def _compressed(self, data):
        return CompressedImage(header=self.header(), format=self._random.choice(FORMATS), data=data)

    def _good_file(self):
        large = self._random.random() < LARGE
        return self._compressed(self._large_file if large else self._random.choice(self._files))

    def _cut_file(self):
        data = self._random.choice(self._files)
        end = self._random.choice([b'', b'\xff\xd9'])
        return self._compressed(data[:self._random.randrange(len(data))] + end)

    def _damaged_file(self):
        data = bytearray(self._random.choice(self._files))
        for _ in range(self._random.choice([1, 3, 30])):
            data[self._random.randrange(len(data))] = self._random.randrange(256)
        return self._compressed(bytes(data))

    def _patched_file(self):
        """A small file whose header claims another size."""
        data = self._random.choice(self._files)
        size = [self._random.choice([0, *SIDES, *HUGE]) for _ in range(2)]
        return self._compressed(_png_of_size(data, *size) if data[:1] == b'\x89' else jpeg_of_size(data, *size))

    def _other_file(self):
        return self._compressed(self._random.choice(self._others))

    def _bomb(self):
        return self._compressed(self._random.choice(self._bombs))

    def _random_file(self):
        start = self._random.choice([b'', b'\xff\xd8', b'\xff\xd8\xff\xe0', b'\x89PNG\r\n\x1a\n', b'\xff' * 50])
        return self._compressed(self._random.choice([b'', start + self._bytes(self._random.randrange(3000))]))

    def _side(self):
        return self._random.choice(SIDES)


def _size_of(encoding):
    """About how many bytes a pixel has."""
    channels = 4 if 'a8' in encoding or 'a16' in encoding else 2 if 'yuv' in encoding else \
        1 if encoding.startswith(('mono', 'bayer')) else 3
    return channels * (2 if '16' in encoding else 4 if '32' in encoding else 8 if '64' in encoding else 1)


def _png_of_size(data, width, height):
    header = bytearray(data[16:29])
    header[:8] = struct.pack('>II', width, height)
    return data[:8] + chunk(b'IHDR', bytes(header)) + data[33:]


def jpeg_of_size(data, width, height):
    """The bytes of a JPEG, whose header claims another size."""
    at = max(data.find(b'\xff\xc0'), data.find(b'\xff\xc2')) + 5
    return data[:at] + struct.pack('>HH', min(height, 65535), min(width, 65535)) + data[at + 4:]


def _other_formats(frame):
    """Files that are similar to pictures, or are pictures, but neither JPEG nor PNG."""
    made = []
    for kind in 'GIF', 'TIFF', 'BMP', 'WEBP', 'PPM', 'ICO', 'TGA':
        file = io.BytesIO()
        Picture.fromarray(frame[:48, :48]).save(file, kind)
        made.append(file.getvalue())
    return [*made, b'<svg xmlns="http://www.w3.org/2000/svg" width="99999" height="99999"/>', b'no picture',
            b'%PDF-1.4', b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "&b;&b;">]><a>&b;</a>',
            b'RIFF\xff\xff\xff\xffWEBP', b'GIF89a\xff\xff\xff\xff', b'BM' + b'\xff' * 60,
            b'II*\0' + b'\xff' * 60]


def _bombs():
    """Files of a few bytes that decompress to many pixels or much text, or take much work."""
    gray = np.full((1000, 1000), 90, np.uint8)
    jpeg = cv2.imencode('.jpg', gray[:64, :64], [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
    scan = jpeg[jpeg.rfind(b'\xff\xda'):-2]
    zeros = zlib.compress(bytes(1000 * 1001), 9)
    return [jpeg_of_size(jpeg, 65000, 65000), jpeg_of_size(jpeg[:-2] + scan * 5000 + b'\xff\xd9', 8000, 8000),
            jpeg_of_size(jpeg, 5000, 5000), png_of(65000, 65000, chunk(b'IDAT', zeros)),
            png_of(2**31 - 1, 1, chunk(b'IDAT', zeros)), png_of(1000, 1000, chunk(b'IDAT', zeros[:500])),
            png_of(64, 64, chunk(b'IDAT', zeros)), png_of(32, 32, chunk(b'IDAT', b'')),
            png_of(8, 8, chunk(b'zTXt', b'a\0\0' + zlib.compress(bytes(10**7))) +
                   chunk(b'IDAT', zlib.compress(bytes(72)))),
            png_of(8, 8, chunk(b'IDAT', zlib.compress(b'\x09' * 72))), png_of(8, 8, b'', bits=16, kind=6),
            cv2.imencode('.png', gray)[1].tobytes()]
