"""How messages become frames, and what is refused before it takes memory."""
import io
import os
import re
import resource
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_node.messages import jpeg
from aruco_node.messages.images import (
    ENCODING,
    END_MARKER,
    END_OF_VIDEO,
    FAST,
    MAX_PICTURE_PIXELS,
    NOTES,
    STEP,
    CompressedDecoder,
    ImageDecoder,
    frame_from_compressed,
    frame_from_image,
    image_from_frame,
    picture_from_image,
)
from aruco_node.ros_internals.subscribers import tolerant
from benchmark.real_clips import clips as real
from cv_bridge import CvBridge
from hostile.files.png import chunk, png
from hostile.messages.camera_messages import KNOWN, Hostile
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

KINDS = {'empty frame', END_OF_VIDEO, 'encoding', 'short frame', 'short step', 'large frame',
         'half a pair of pixels', 'undecodable frame', 'depth image'}


def image(pixels, encoding, big=0):
    pixels = pixels.astype(pixels.dtype.newbyteorder('>' if big else '<'))
    return Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, is_bigendian=big,
                 step=pixels.strides[0], data=pixels.tobytes())


@pytest.mark.parametrize('encoding', sorted(set(KNOWN) - {'yuv422_yuy2'}))
def test_every_encoding_is_decoded_as_by_cv_bridge(encoding, random):
    kind, channels = CvBridge().encoding_to_dtype_with_channels(encoding)
    shape = (37, 52) + (channels,) * (channels > 1)
    pixels = random.randint(0, np.iinfo(kind).max + 1, shape).astype(kind)
    usual = image(pixels, encoding)  # if the byte order is not the machine's, cv_bridge fails with NumPy 2
    for message in usual, image(pixels, encoding, big=1):
        expected = CvBridge().imgmsg_to_cv2(usual, 'bgr8')
        # A mosaic of 16 bits is scaled before its colors are found, and not after.
        np.testing.assert_allclose(frame_from_image(message), expected, rtol=0,
                                   atol=1 if encoding.startswith('bayer') and encoding.endswith('16') else 0)
        if encoding.startswith(('bgra', 'rgba')):
            np.testing.assert_array_equal(picture_from_image(message),
                                          CvBridge().imgmsg_to_cv2(usual, 'bgra8'))
        else:
            np.testing.assert_array_equal(picture_from_image(message), frame_from_image(message))


@pytest.mark.parametrize('encoding, channels', [('bgr8', 3), ('rgb8', 3), ('bgra8', 4)])
def test_images_are_encoded_as_by_cv_bridge(encoding, channels, random):
    pixels = random.randint(0, 256, (37, 52, channels)).astype(np.uint8)
    header = Header(seq=3, frame_id='eye')
    sent, usual = io.BytesIO(), io.BytesIO()
    image_from_frame(pixels, header, 'rgb8' if encoding == 'rgb8' else 'bgr8').serialize(sent)
    CvBridge().cv2_to_imgmsg(pixels[..., ::-1] if encoding == 'rgb8' else pixels, encoding,
                             header).serialize(usual)
    assert sent.getvalue() == usual.getvalue()


def test_cv_bridge_is_not_loaded_for_the_most_common_encodings():
    script = '''
import sys
from aruco_node.messages.images import frame_from_image
from sensor_msgs.msg import Image
for name in sys.argv[1:]:
    frame_from_image(Image(width=1, height=1, step=3, encoding=name, data=b'abc'))
print('cv_bridge' in sys.modules)
'''
    for encodings, loaded in (list(FAST), 'False'), ([*FAST, 'bgr8', 'bayer_rggb8'], 'True'):
        done = subprocess.run([sys.executable, '-c', script, *encodings], stdout=subprocess.PIPE, text=True)
        assert done.stdout.strip() == loaded


PLAIN = {'8UC1': 'mono8', '8UC3': 'bgr8', '8UC4': 'bgra8', '16UC1': 'mono16', '16UC3': 'bgr16',
         '16UC4': 'bgra16'}
NAMED = {'BGR8': 'bgr8', ' rgb8': 'rgb8', 'RGB': 'rgb8', 'TYPE_8UC3': 'bgr8', 'CV_8UC1': 'mono8',
         'BAYER_RGGB8': 'bayer_rggb8', 'Bayer_GBRG16': 'bayer_gbrg16', 'RGB16': 'rgb16', 'RGBA16': 'rgba16',
         'yuyv': 'yuv422_yuy2', 'uyvy': 'yuv422', 'YUY2': 'yuv422_yuy2', 'mono': 'mono8'}


@pytest.mark.parametrize('given, read_as', [*PLAIN.items(), *NAMED.items()])
def test_an_encoding_of_another_name_is_read_in_the_one_sensible_way(given, read_as, random):
    kind, channels = (np.uint8, 2) if read_as.startswith('yuv') else \
        CvBridge().encoding_to_dtype_with_channels(read_as)
    pixels = random.randint(0, np.iinfo(kind).max + 1, (37, 52, channels)).astype(kind)
    decode = ImageDecoder(keeps_alpha=True)
    found = decode(image(pixels, given))
    assert re.search('"%s" are read as %s' % (given.strip(), read_as), decode.notes[ENCODING])
    np.testing.assert_array_equal(found, decode(image(pixels, read_as)))
    assert not decode.notes  # it holds no longer


@pytest.mark.parametrize('given, channels, other', [('8UC3', 3, 'rgb8'), ('8UC4', 4, 'rgba8'),
                                                    ('16UC3', 3, 'rgb16'), ('16UC4', 4, 'rgba16')])
def test_an_encoding_that_does_not_say_where_red_is_has_a_remedy(given, channels, other):
    decode = ImageDecoder()
    pixels = np.full((8, 6, channels), 255, np.uint8 if given[0] == '8' else np.uint16)
    pixels[..., 2] = 0
    found = decode(image(pixels, given))
    assert 'Name %s if blue looks red.' % other in decode.notes[ENCODING]
    assert (decode(image(pixels, other)) == found[..., ::-1]).all()


@pytest.mark.parametrize('encoding, kind, channels', [
    ('bgr8', np.uint8, 3), ('mono8', np.uint8, 1), ('bayer_rggb8', np.uint8, 1), ('16UC1', np.uint16, 1)])
def test_a_step_that_was_not_filled_in_is_that_of_rows_without_padding(encoding, kind, channels, random):
    pixels = random.randint(0, np.iinfo(kind).max + 1, (38, 52, channels)).astype(kind)
    message, decode = image(pixels, encoding), ImageDecoder()
    usual = decode(message)
    assert STEP not in decode.notes
    for step in {0, 1, message.width, message.step} - {message.step}:
        message.step = step
        np.testing.assert_array_equal(decode(message), usual)
        assert 'step of %d bytes' % step in decode.notes[STEP] and STEP in NOTES
        for data in message.data[:-1], message.data + b'\0':
            with pytest.raises(InputError, match='step of %d bytes' % step):
                decode(Image(height=38, width=52, encoding=encoding, step=step, data=data))


def test_an_array_that_a_student_publishes_without_an_encoding_is_a_frame(random):
    for shape, encoding in ((37, 52, 3), '8UC3'), ((37, 52), '8UC1'):
        pixels, decode = random.randint(0, 256, shape).astype(np.uint8), ImageDecoder()
        message = CvBridge().cv2_to_imgmsg(pixels)
        assert message.encoding == encoding
        np.testing.assert_array_equal(decode(message), pixels if len(shape) == 3 else np.dstack([pixels] * 3))
        assert 'cv2_to_imgmsg(image, "%s")' % PLAIN[encoding] in decode.notes[ENCODING]
        assert decode.notes[ENCODING].isprintable() and len(decode.notes[ENCODING]) < 200


def test_yuv422_is_decoded_in_either_order(random):
    pixels = random.randint(0, 256, (8, 6, 2)).astype(np.uint8)
    np.testing.assert_array_equal(frame_from_image(image(pixels[..., ::-1].copy(), 'yuv422_yuy2')),
                                  frame_from_image(image(pixels, 'yuv422')))


def yuv(frame):
    """A frame as the pixels of a yuv422 image, (h, w, 2) uint8 (ITU-R BT.601)."""
    frame = frame[:, :frame.shape[1] // 2 * 2]
    luma, red, blue = (cv2.cvtColor(frame, cv2.COLOR_BGR2YCrCb)[..., each] for each in range(3))
    halves = [cv2.resize(each, None, fx=0.5, fy=1, interpolation=cv2.INTER_AREA) for each in (blue, red)]
    return np.dstack([np.stack(halves, axis=-1).reshape(luma.shape), np.uint8(16 + luma * (219 / 255))])


def gray_of(frame):
    return np.dstack([cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)] * 3)


def scenes(frame):
    """Frames that are colored, gray, dark, noisy, almost of one color, soft, and mirrored."""
    noise = np.random.RandomState(2).normal(0, 8, frame.shape)
    return {'colored': frame, 'gray': gray_of(frame), 'dark': frame // 12,
            'noisy': np.uint8(np.clip(frame + noise, 0, 255)), 'pale': np.uint8(200 + frame // 30),
            'soft': cv2.GaussianBlur(frame, (0, 0), 4), 'mirrored': frame[:, ::-1]}


OTHER = {'yuv422': 'yuv422_yuy2', 'yuv422_yuy2': 'yuv422'}


@pytest.mark.parametrize('encoding', OTHER)
def test_yuv422_in_the_other_order_than_its_name_says_is_recognized(encoding, frame):
    for name, scene in scenes(frame).items():
        pixels = yuv(scene)
        pixels = pixels if encoding == 'yuv422' else pixels[..., ::-1]
        decode = ImageDecoder()
        right = decode(image(pixels.copy(), encoding))
        assert not decode.notes, name
        wrong = decode(image(pixels[..., ::-1].copy(), encoding))
        if name in ('colored', 'gray', 'soft', 'mirrored'):  # if it is not certain, nothing is said
            assert 'Set the camera driver to %s.' % OTHER[encoding] in decode.notes[ENCODING], name
            np.testing.assert_array_equal(wrong, right)


@pytest.mark.clips
def test_the_order_of_yuv422_is_recognized_in_real_clips():
    if not os.path.isdir(real.CLIPS):
        pytest.skip('the folder %s with clips is missing' % os.path.normpath(real.CLIPS))
    names = sorted(name for name in os.listdir(real.CLIPS) if name.endswith(('.mp4', '.avi')))
    assert names
    for name in names:
        video, count = cv2.VideoCapture(os.path.join(real.CLIPS, name)), 0
        while True:
            is_read, frame = video.read()
            if not is_read:
                break
            if count % 5 == 0:
                pixels = yuv(frame)
                for given, said in ('yuv422', False), ('yuv422_yuy2', True):
                    decode = ImageDecoder()
                    decode(image(pixels, given))
                    assert bool(decode.notes) == said, (name, count, given)
            count += 1
        assert count


def test_16_bit_numbers_are_scaled_in_either_byte_order():
    values = np.uint16([[0, 257, 128 * 257, 65535]])
    for big in (0, 1, 255):
        assert frame_from_image(image(values, 'mono16', big))[0, :, 0].tolist() == [0, 1, 128, 255]


def test_padding_between_rows_is_ignored(random):
    wide = random.randint(0, 2**16, (5, 9)).astype(np.uint16)
    padded = image(wide, 'mono16')
    padded.width = 6
    np.testing.assert_array_equal(frame_from_image(padded),
                                  frame_from_image(image(wide[:, :6].copy(), 'mono16')))


@pytest.mark.parametrize('encoding', ['32FC1', '32FC3', '64FC1', '16SC1', '8SC1', '8UC2', '', 'x' * 10**6,
                                      'rgb8\n[ERROR]', 'type_', 'nv12'])
def test_an_encoding_without_color_is_refused_in_one_short_line(encoding):
    values = np.float32([[np.nan, np.inf, 0, 1]])
    with pytest.raises(InputError, match='Set the camera driver to an encoding such as rgb8') as error:
        frame_from_image(image(values, encoding))
    assert error.value.kind == 'encoding' and len(str(error.value)) < 200 and str(error.value).isprintable()


@pytest.mark.parametrize('kind, frame', [('.jpg', np.uint8), ('.png', np.uint8), ('.png', np.uint16)])
@pytest.mark.parametrize('channels', [1, 3, 4])
def test_a_compressed_frame_is_decoded(kind, frame, channels, random):
    small = random.randint(0, 256, (6, 8, channels)).astype(np.uint8)
    pixels = cv2.resize(small, (64, 48)).reshape(48, 64, channels)
    stored = np.uint16(pixels) * 257 if frame is np.uint16 else pixels
    data = cv2.imencode(kind, stored)[1].tobytes()
    found = frame_from_compressed(CompressedImage(data=data)).astype(int)
    expected = pixels[..., :3] if channels > 1 else np.repeat(pixels, 3, axis=2)
    assert np.abs(found - expected).mean() < (6 if kind == '.jpg' else 1e-9)


@pytest.mark.parametrize('sampling', ['411', '420', '422', '440', '444'])
def test_simplejpeg_and_pillow_decode_a_jpeg_to_the_same_pixels(sampling, frame, monkeypatch):
    pytest.importorskip('simplejpeg')
    factor = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, getattr(cv2, 'IMWRITE_JPEG_SAMPLING_FACTOR_' + sampling)]
    for options in JPEG_KINDS.values():
        for shown in frame, frame[:241, :323], gray_of(frame)[..., 0]:
            message = CompressedImage(data=cv2.imencode('.jpg', shown, options + factor)[1].tobytes())
            found = frame_from_compressed(message)
            assert found.flags.writeable
            with monkeypatch.context() as patch:
                patch.setattr(jpeg, 'decode_jpeg', None)
                np.testing.assert_array_equal(found, frame_from_compressed(message))


def test_a_damaged_jpeg_has_the_same_pixels_and_is_decoded_once(frame, monkeypatch):
    """Some webcams send a few bytes too many before the end marker of each frame."""
    simplejpeg, tries, decode = pytest.importorskip('simplejpeg'), [], CompressedDecoder()
    monkeypatch.setattr(jpeg, 'decode_jpeg',
                        lambda *arguments: tries.append(1) or simplejpeg.decode_jpeg(*arguments))
    data = cv2.imencode('.jpg', frame)[1].tobytes()
    good, damaged = CompressedImage(data=data), CompressedImage(data=data[:-2] + bytes(range(1, 4)) + data[-2:])
    for message in [good] * 3 + [damaged] * 50 + [good]:
        np.testing.assert_array_equal(decode(message), frame_from_compressed(good))
    tries.clear()
    for _ in range(50):
        decode(damaged)
    assert not tries  # it would take half as long again


JPEG_KINDS = {'baseline': [], 'progressive': [cv2.IMWRITE_JPEG_PROGRESSIVE, 1],
              'with restart markers': [cv2.IMWRITE_JPEG_RST_INTERVAL, 4],
              'coarse': [cv2.IMWRITE_JPEG_QUALITY, 20]}


@pytest.mark.parametrize('options', JPEG_KINDS.values(), ids=JPEG_KINDS)
def test_a_jpeg_that_lacks_only_its_end_marker_is_used(options, frame):
    for shown in frame, gray_of(frame)[..., 0], np.full((48, 64, 3), 255, np.uint8):
        data = cv2.imencode('.jpg', shown, options)[1].tobytes()
        decode = CompressedDecoder()
        whole = decode(CompressedImage(data=data))
        assert data[-2:] == b'\xff\xd9' and not decode.notes
        # Some drivers fill the space after it with zeros.
        for less in data[:-2], data[:-1], data[:-2] + bytes(1000), data[:-1] + bytes(3):
            np.testing.assert_array_equal(decode(CompressedImage(data=less)), whole)
            assert 'lack their end marker' in decode.notes[END_MARKER]
        decode(CompressedImage(data=data + bytes(1000)))
        assert not decode.notes


@pytest.mark.parametrize('options', JPEG_KINDS.values(), ids=JPEG_KINDS)
def test_a_jpeg_that_is_cut_off_is_refused(options, frame):
    data = cv2.imencode('.jpg', frame, options)[1].tobytes()
    for share in np.linspace(0.001, 0.97, 60):
        cut = data[:int(share * len(data))]
        for tail in b'', bytes(1000):
            with pytest.raises(InputError, match='must be a complete JPEG or PNG') as error:
                frame_from_compressed(CompressedImage(data=cut + tail))
            assert error.value.kind == 'undecodable frame'


def large(width, height):
    """A JPEG whose header claims a size of ``width`` x ``height`` pixels."""
    data = cv2.imencode('.jpg', np.zeros((64, 64), np.uint8))[1].tobytes()
    at = data.find(b'\xff\xc0') + 5
    return data[:at] + height.to_bytes(2, 'big') + width.to_bytes(2, 'big') + data[at + 4:] + bytes(10**6)


@pytest.mark.parametrize('make', [
    lambda: (frame_from_image, Image(width=2**32 - 1, height=2**32 - 1, encoding='bgr8')),
    lambda: (frame_from_image, Image(width=2**16, height=2**16, step=3 * 2**16, encoding='bgr8')),
    lambda: (frame_from_image, Image(width=1, height=40000, step=3, encoding='bgr8', data=bytes(120000))),
    lambda: (frame_from_compressed, CompressedImage(data=large(65000, 65000))),
    lambda: (frame_from_compressed, CompressedImage(data=large(10000, 10000)))])
def test_a_frame_that_is_too_large_is_refused(make):
    convert, message = make()
    words = 'too large; frames have at most %d million' % (MAX_PICTURE_PIXELS // 10**6)
    with pytest.raises(InputError, match=words):
        convert(message)


def test_decompression_bombs_take_neither_memory_nor_time():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    scan = cv2.imencode('.jpg', np.zeros((64, 64), np.uint8), [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
    many = scan[:-2] + scan[scan.rfind(b'\xff\xda'):-2] * 5000 + scan[-2:]
    at = many.find(b'\xff\xc2') + 5
    for data in (large(65000, 65000), large(6000, 6000)[:-10**6],
                 many[:at] + (5000).to_bytes(2, 'big') * 2 + many[at + 4:], zlib.compress(bytes(10**7))):
        with pytest.raises(InputError):
            frame_from_compressed(CompressedImage(data=data))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50 * 1024


@pytest.mark.parametrize('kind', [Image, CompressedImage])
def test_an_unreadable_message_counts_as_an_empty_one(kind, random):
    good = io.BytesIO()
    kind(data=random.bytes(100)).serialize(good)
    good = good.getvalue()
    assert tolerant(kind)().deserialize(good).data == kind().deserialize(good).data != b''
    for data in (b'', b'x', good[:10], b'\xff' * 64):
        assert tolerant(kind)().deserialize(data).data == b''


def test_hostile_messages_become_frames_or_one_of_a_few_sentences(frame):
    hostile, found, count = Hostile(1, [frame]), set(), 0
    for kind, make, convert in ((Image, hostile.image, picture_from_image),
                                (CompressedImage, hostile.compressed, frame_from_compressed)):
        for _ in range(2000):
            data = io.BytesIO()
            make().serialize(data)
            try:
                pixels = convert(tolerant(kind)().deserialize(data.getvalue()))
                assert pixels.dtype == np.uint8 and pixels.ndim == 3
                count += 1
            except InputError as error:
                assert len(str(error)) < 300 and str(error).isprintable()
                found.add(error.kind)
    assert found == KINDS
    assert count > 200


def test_the_decoders_print_nothing(package):
    script = '''
import aruco_ar
import numpy as np
from aruco_node.messages.images import frame_from_compressed
from hostile.messages.camera_messages import Garbage, Hostile
hostile = Hostile(2, [np.zeros((480, 640, 3), np.uint8)])
for _ in range(1000):
    message = hostile.compressed()
    try:
        isinstance(message, Garbage) or frame_from_compressed(message)
    except aruco_ar.InputError:
        pass
'''
    path = os.pathsep.join([package + '/test', os.environ['PYTHONPATH']])
    done = subprocess.run([sys.executable, '-c', script], env=dict(os.environ, PYTHONPATH=path),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert (done.returncode, done.stdout) == (0, '')


def test_a_png_may_contain_the_start_marker_of_many_jpeg_scans():
    data = png(9, 9, bytes(27), more=chunk(b'tEXt', b'a\0' + 200 * b'\xff\xda'))
    assert frame_from_compressed(CompressedImage(data=data)).shape == (9, 9, 3)
