"""Frames to and from ROS messages, and the explanations if no frames arrive."""
import re
from io import BytesIO

import cv2
import numpy as np
import pytest
from aruco_ar import InputError
from aruco_node.health.silence import explain_silence
from aruco_node.messages.images import (
    TRANSPORTS,
    compressed_from_frame,
    frame_from_compressed,
    frame_from_image,
    image_from_frame,
    picture_from_image,
)
from aruco_node.messages.topics import IMAGE_TYPES
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

COLORS = np.zeros((32, 48, 3), np.uint8)  # smooth colors, which Bayer and yuv422 keep
COLORS[..., 0] = 40
COLORS[..., 1] = np.linspace(60, 180, 48).astype(np.uint8)
COLORS[..., 2] = 200


def bayer(red_row, red_column):
    mosaic = COLORS[..., 1].copy()
    mosaic[red_row::2, red_column::2] = COLORS[red_row::2, red_column::2, 2]
    mosaic[1 - red_row::2, 1 - red_column::2] = COLORS[1 - red_row::2, 1 - red_column::2, 0]
    return mosaic


def uyvy():
    # ITU-R BT.601 in video range
    blue, green, red = (COLORS[..., channel].astype(float) for channel in range(3))
    yuv = np.stack([16 + 0.257 * red + 0.504 * green + 0.098 * blue,
                    128 - 0.148 * red - 0.291 * green + 0.439 * blue,
                    128 + 0.439 * red - 0.368 * green - 0.071 * blue], axis=-1).round()
    packed = np.zeros((32, 48, 2), np.uint8)
    packed[..., 1] = yuv[..., 0]
    packed[:, 0::2, 0] = yuv[:, 0::2, 1]
    packed[:, 1::2, 0] = yuv[:, 0::2, 2]
    return packed


GRAY = cv2.cvtColor(COLORS, cv2.COLOR_BGR2GRAY)
ENCODED = {
    'bgr8': COLORS, 'rgb8': COLORS[..., ::-1],
    'bgra8': cv2.cvtColor(COLORS, cv2.COLOR_BGR2BGRA), 'rgba8': cv2.cvtColor(COLORS, cv2.COLOR_BGR2RGBA),
    'mono8': GRAY, 'mono16': GRAY.astype(np.uint16) * 257,
    'bayer_rggb8': bayer(0, 0), 'bayer_bggr8': bayer(1, 1),
    'bayer_grbg8': bayer(0, 1), 'bayer_gbrg8': bayer(1, 0), 'yuv422': uyvy(),
}


def message(pixels, encoding, padding=0):
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(len(pixels), -1)
    rows = np.pad(rows, ((0, 0), (0, padding)))
    return Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding,
                 step=rows.shape[1], data=rows.tobytes())


@pytest.mark.parametrize('padding', [0, 6])
@pytest.mark.parametrize('encoding', ENCODED)
def test_every_encoding_becomes_the_same_frame(encoding, padding):
    if padding and encoding == 'mono16':
        padding = 8
    frame = frame_from_image(message(ENCODED[encoding], encoding, padding))
    expected = cv2.cvtColor(GRAY, cv2.COLOR_GRAY2BGR) if encoding.startswith('mono') else COLORS
    assert frame.shape == COLORS.shape and frame.dtype == np.uint8
    tolerance = 6 if encoding[:3] in ('bay', 'yuv') else 1
    inner = slice(2, -2)
    assert np.abs(frame[inner, inner].astype(int) - expected[inner, inner]).max() <= tolerance


@pytest.mark.parametrize('kind', ['.jpg', '.png'])
def test_jpeg_and_png_are_decoded(kind):
    data = cv2.imencode(kind, COLORS)[1].tobytes()
    frame = frame_from_compressed(CompressedImage(format=kind[1:], data=data))
    assert np.abs(frame.astype(int) - COLORS).max() <= 8


def test_gray_and_transparent_pngs_are_decoded():
    for pixels in (GRAY, cv2.cvtColor(COLORS, cv2.COLOR_BGR2BGRA)):
        frame = frame_from_compressed(CompressedImage(data=cv2.imencode('.png', pixels)[1].tobytes()))
        assert frame.shape == COLORS.shape


def test_a_frame_survives_a_round_trip_with_its_header():
    header = Header(frame_id='eye')
    out = image_from_frame(COLORS, header)
    assert out.encoding == 'bgr8' and out.header is header
    np.testing.assert_array_equal(frame_from_image(out), COLORS)
    small = compressed_from_frame(COLORS, header)
    assert small.header is header and 'jpeg' in small.format
    assert np.abs(frame_from_compressed(small).astype(int) - COLORS).max() <= 12


def test_a_picture_keeps_its_alpha_channel_in_a_round_trip():
    picture = np.dstack([COLORS, np.full(COLORS.shape[:2], 77, np.uint8)])
    out = image_from_frame(picture, Header())
    assert out.encoding == 'bgra8'
    np.testing.assert_array_equal(picture_from_image(out), picture)
    np.testing.assert_array_equal(picture_from_image(image_from_frame(COLORS, Header())), COLORS)


GOOD = message(COLORS, 'bgr8')


@pytest.mark.parametrize('change, words', [
    (dict(width=0, height=0, step=0, data=b''), '0 x 0'),
    (dict(data=GOOD.data[:-1]), '4607 bytes, but by its step and height it must have 4608'),
    (dict(encoding='32FC1', width=36), '"32FC1".*such as rgb8'),
    (dict(encoding='16SC1', width=72), '"16SC1"'),
    (dict(encoding='nonsense'), '"nonsense"'),
    (dict(encoding=''), '""'),
    (dict(step=10, data=GOOD.data + b'0'), 'step of 10 bytes, but 48 pixels'),
    (dict(width=10**4), 'step of 144 bytes, but 10000'),
    (dict(width=10**6), '1000000 x 32 pixels is too large'),
])
def test_an_unusable_frame_is_explained(change, words):
    fields = {name: getattr(GOOD, name) for name in ('height', 'width', 'encoding', 'step', 'data')}
    with pytest.raises(InputError, match=words):
        frame_from_image(Image(**dict(fields, **change)))


@pytest.mark.parametrize('padding', [0, 6])
@pytest.mark.parametrize('encoding', ENCODED)
def test_writing_into_a_frame_does_not_change_the_message(encoding, padding):
    image = message(ENCODED[encoding], encoding, padding)
    before = bytes(image.data)
    frame_from_image(image)[:] = 7
    assert image.data == before


def test_a_message_is_serialized_to_the_same_bytes_as_by_genpy():
    header = Header(seq=3, frame_id='camera')
    ours, usual = BytesIO(), BytesIO()
    image_from_frame(COLORS, header).serialize(ours)
    Image(header=header, height=32, width=48, encoding='bgr8', step=144,
          data=COLORS.tobytes()).serialize(usual)
    assert ours.getvalue() == usual.getvalue()


@pytest.mark.parametrize('data', [b'', b'no picture', b'\xff\xd8\xff\xe0'])
def test_undecodable_compressed_data_is_explained(data):
    with pytest.raises(InputError, match='must be a complete JPEG or PNG'):
        frame_from_compressed(CompressedImage(data=data))


@pytest.mark.parametrize('format', ['16UC1; compressedDepth', '32FC1; compressedDepth png',
                                    '16UC1; compressedDepth rvl'])
def test_a_compressed_depth_image_is_named_as_such(format):
    png = cv2.imencode('.png', np.full((8, 8), 1000, np.uint16))[1].tobytes()
    with pytest.raises(InputError, match='"%s.* is a depth image' % format[:20]) as error:
        frame_from_compressed(CompressedImage(format=format, data=bytes(12) + png))
    assert 'JPEG' not in str(error.value)


RAW, COMPRESSED = IMAGE_TYPES['raw'], IMAGE_TYPES['compressed']


@pytest.mark.parametrize('transport, published, words', [
    ('raw', {}, 'nothing publishes it, nor any other'),
    ('raw', {'/usb/image': RAW, '/out': RAW, '/robot/exercise5_5/mask': RAW, '/page/picture': RAW,
             '/tag_poses/image': RAW, '/calibrate_live/image': RAW}, 'are published: /usb/image. Choose one'),
    ('raw', {'/cam': 'std_msgs/String'}, 'published as std_msgs/String, but must be sensor_msgs/Image'),
    ('raw', {'/cam': COMPRESSED}, 'published as sensor_msgs/CompressedImage'),
    ('raw', {'/cam/compressed': COMPRESSED}, 'only its compressed form .*transport:=compressed'),
    ('compressed', {'/cam': RAW}, 'only its raw form .*transport:=raw'),
    ('compressed', {'/usb/compressed': COMPRESSED}, 'published: /usb. Choose'),
    ('raw', {'/cam': RAW}, 'has a publisher, but nothing arrives'),
])
def test_missing_frames_are_explained(transport, published, words):
    with_words = explain_silence('/cam', transport, published, own=['/out'])
    assert with_words.startswith('Waiting for frames on /cam')
    assert re.search(words, with_words)


def test_the_types_of_the_transports_agree():
    assert {name: kind._type for name, (_, kind, _) in TRANSPORTS.items()} == IMAGE_TYPES
