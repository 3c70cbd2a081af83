"""Pictures: which files are accepted, and how others are explained."""
import os

import cv2
import numpy as np
import pytest
from aruco_ar import InputError, load_picture


def test_the_earth_has_its_colors(package):
    path = package + '/images/earth.jpg'
    earth = load_picture(path)
    assert os.path.getsize(path) <= 400_000
    blue, green, red = earth[330, 330].astype(int)  # the Atlantic
    assert blue > red + 30
    blue, green, red = earth[270, 430].astype(int)  # the Sahara
    assert red > green > blue and red > 150
    assert earth[20, 20].max() < 60                 # space


def test_gray_color_and_transparent_pictures_are_read(tmp_path):
    for shape, channels in (((8, 6), 3), ((8, 6, 3), 3), ((8, 6, 4), 4)):
        path = str(tmp_path / 'picture.png')
        cv2.imwrite(path, np.full(shape, 77, np.uint8))
        picture = load_picture(path)
        assert picture.shape == (8, 6, channels) and picture.dtype == np.uint8
        assert np.all(picture == 77)


def test_16_bit_pictures_become_8_bit_ones(tmp_path):
    path = str(tmp_path / 'picture.png')
    for channels in (3, 4):
        cv2.imwrite(path, np.full((4, 4, channels), 0x8080, np.uint16))
        assert load_picture(path).dtype == np.uint8
        assert abs(int(load_picture(path)[0, 0, 0]) - 128) <= 1


def test_a_jpeg_that_lacks_its_end_marker_is_read_and_one_that_is_cut_off_is_not(tmp_path, earth):
    path, data = str(tmp_path / 'earth.jpg'), cv2.imencode('.jpg', earth)[1].tobytes()
    (tmp_path / 'earth.jpg').write_bytes(data)
    whole = load_picture(path)
    for less in data[:-2], data[:-2] + bytes(99):
        (tmp_path / 'earth.jpg').write_bytes(less)
        np.testing.assert_array_equal(load_picture(path), whole)
    (tmp_path / 'earth.jpg').write_bytes(data[:len(data) // 2])
    with pytest.raises(InputError, match='cannot be read as a picture'):
        load_picture(path)


def test_a_picture_that_is_too_large_is_shrunk(tmp_path):
    path = str(tmp_path / 'long.png')
    cv2.imwrite(path, np.full((2, 40000, 3), 50, np.uint8))
    assert load_picture(path).shape == (1, 4096, 3)


def test_a_float_picture_with_alpha_is_refused(tmp_path):
    path = str(tmp_path / 'float.tiff')
    cv2.imwrite(path, np.full((8, 8, 4), 1.0, np.float32))
    with pytest.raises(InputError, match='cannot be read as a picture'):
        load_picture(path)


def test_missing_broken_and_empty_files_are_named(tmp_path):
    (tmp_path / 'empty.jpg').write_bytes(b'')
    (tmp_path / 'broken.jpg').write_bytes(b'\xff\xd8\xff no picture')
    for name, words in (('missing.jpg', 'cannot be read: No such file'), ('empty.jpg', 'read as a picture'),
                        ('broken.jpg', 'cannot be read as a picture'), ('.', 'is not a file')):
        path = str(tmp_path / name)
        with pytest.raises(InputError, match=words) as error:
            load_picture(path)
        assert path in str(error.value)
