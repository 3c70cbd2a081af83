"""Frames of 16 bits, of which a camera uses fewer: what they show, and that it does not flicker."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector
from aruco_node.messages.images import LEVELS, NOTES, CompressedDecoder, ImageDecoder
from sensor_msgs.msg import CompressedImage, Image

GRAY_LEVELS = 255


def raw(values, encoding='mono16', big=0):
    values = values.astype('>u2' if big else '<u2')
    return Image(height=values.shape[0], width=values.shape[1], encoding=encoding, is_bigendian=big,
                 step=values.strides[0], data=values.tobytes())


def png(values):
    return CompressedImage(format='mono16; png compressed ',
                           data=cv2.imencode('.png', values.astype(np.uint16))[1].tobytes())


@pytest.fixture
def gray(frame):
    """A scene with tags, (480, 640) float64 from 0 to 1, with some white."""
    gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) / GRAY_LEVELS
    gray[400:440, :] = 1.0
    return gray


@pytest.mark.parametrize('decoder, message', [(ImageDecoder, raw), (CompressedDecoder, png),
                                              (ImageDecoder, lambda values: raw(values, big=1)),
                                              (ImageDecoder, lambda values: raw(values, '16UC1'))])
@pytest.mark.parametrize('bits', [8, 10, 12, 14, 16])
def test_gray_of_fewer_bits_is_as_bright_as_gray_of_8(bits, decoder, message, gray):
    decode = decoder()
    shown = decode(message(np.round(gray * (2**bits - 1))))
    np.testing.assert_allclose(shown, np.dstack([gray] * 3) * GRAY_LEVELS, atol=1)
    white = 'values from 0 to %d, ' % (2**bits - 1)
    assert (white in decode.notes.get(LEVELS, '')) == (bits < 16)


@pytest.mark.parametrize('encoding', ['bgr16', 'rgb16', 'bayer_rggb16'])
@pytest.mark.parametrize('bits', [10, 12, 14])
def test_color_of_fewer_bits_has_the_colors_of_16_bits(encoding, bits, frame):
    frame = frame.copy()
    frame[400:440] = GRAY_LEVELS
    pixels = frame if encoding == 'bgr16' else frame[..., ::-1] if encoding == 'rgb16' else frame[..., 1]

    def shown(bits):
        values = np.round(pixels / GRAY_LEVELS * (2**bits - 1)).astype(np.uint16)
        message = raw(values.reshape(len(values), -1), encoding)
        message.width = frame.shape[1]
        return ImageDecoder()(message).astype(int)
    assert np.abs(shown(bits) - shown(16)).max() <= 1


@pytest.mark.parametrize('coldest, warmest', [(28000, 32000), (29000, 29400), (7800, 8300), (27315, 37315),
                                              (60000, 65535), (3, 300)])
def test_tags_are_seen_by_a_thermal_camera(coldest, warmest, frame, gray):
    wanted = {tag.id for tag in Detector().detect(frame)}
    decode = ImageDecoder()
    shown = decode(raw(np.round(coldest + gray * (warmest - coldest))))
    assert wanted and {tag.id for tag in Detector().detect(shown)} == wanted
    assert np.ptp(shown[:, :, 0]) > 60
    assert LEVELS in decode.notes and LEVELS in NOTES


@pytest.mark.parametrize('values_of', [lambda gray: gray * 1023, lambda gray: 28000 + gray * 4000,
                                       lambda gray: 20 + gray * 200])
@pytest.mark.parametrize('passing', [65535, 0])
def test_the_scene_does_not_flicker_while_something_passes(values_of, passing, gray, random):
    decode, still = ImageDecoder(), []
    for number in range(120):
        values = values_of(gray) + random.normal(0, 2, gray.shape)
        if 10 <= number < 90:  # it is as large as a third of the frame
            values[:300, 8 * (number - 10):][:, :300] = passing
        shown = decode(raw(np.clip(values, 0, 65535)))
        still.append(shown[380:480].mean())
    assert np.ptp(still) < 1


def test_a_camera_that_turns_brighter_is_followed_at_once_and_in_few_steps(gray):
    """The first frames of many cameras are black."""
    decode, ranges, shown = ImageDecoder(), [], None
    for number in range(60):
        shown = decode(raw(gray * 4095 * min(number / 40, 1)))
        ranges.append(decode.notes[LEVELS])
    np.testing.assert_allclose(shown[..., 0], gray * GRAY_LEVELS, atol=1)
    assert len(set(ranges)) <= 4


def test_what_was_very_bright_for_a_moment_does_not_leave_the_scene_dark(gray):
    decode = ImageDecoder()
    decode(raw(np.full(gray.shape, 65535)))
    assert decode(raw(gray * 1023)).max() == GRAY_LEVELS


def test_another_camera_on_the_topic_has_another_range(gray):
    decode = ImageDecoder()
    decode(raw(gray * 65535))
    assert decode(raw(gray[:240] * 1023))[:, :, 0].max() > 200


def test_a_range_that_fits_no_longer_is_replaced_after_a_while(gray):
    """After a lens that was covered for long, or a thermal camera that has warmed up."""
    decode = ImageDecoder()
    decode(raw(28000 + gray * 1000))
    shown = [decode(raw(28550 + gray * 1000)) for _ in range(150)]
    white = [(each == GRAY_LEVELS).mean() for each in shown]
    assert white[0] > 0.05 and white[-1] < 0.01
    assert np.ptp(shown[-1]) > 100
