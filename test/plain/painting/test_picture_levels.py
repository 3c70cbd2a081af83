"""A picture in several sizes."""
import gc
import weakref

import numpy as np
import pytest
from aruco_ar import Area, area_mask, overlay
from aruco_ar.compiled import binding
from aruco_ar.painting.picture import Picture

AREA = Area(np.float32([[10, 10], [50, 10], [50, 50], [10, 50]]))


def gray_picture(gray, channels=3):
    return np.full((160, 160, channels), gray, np.uint8)


@pytest.mark.parametrize('across, down', [(0, 0), (1, 0), (0, 1), (1, 1), (2, 1), (1, 3), (3, 3)])
def test_a_pixel_of_a_level_is_the_mean_of_what_it_covers(random, across, down):
    pixels = random.randint(0, 256, (29, 43, 3)).astype(np.uint8)
    width, height = 43 >> across, 29 >> down
    covered = pixels[:height << down, :width << across].reshape(height, 1 << down, width, 1 << across, 3)
    off = Picture(pixels).level(across, down) - covered.mean(axis=(1, 3))
    assert np.abs(off).max() <= 0.5 * (across + down)  # each halving rounds


def test_a_side_of_one_pixel_is_doubled_and_none_is_halved_to_nothing(random):
    pixels = random.randint(0, 256, (1, 9, 3)).astype(np.uint8)
    np.testing.assert_array_equal(Picture(pixels).level(0, 0), pixels.repeat(2, axis=0))
    assert Picture(pixels).level(3, 1).shape == (1, 1, 3)
    with pytest.raises(IndexError, match='9 x 1 pixels cannot be halved so often'):
        Picture(pixels).level(1, 2)


def test_hidden_colors_do_not_bleed_into_smaller_levels():
    picture = np.zeros((4, 4, 4), np.uint8)
    picture[:, ::2] = 0, 0, 255, 0     # red, but invisible
    picture[:, 1::2] = 200, 100, 0, 255
    half = np.full((2, 2, 4), (100, 50, 0, 128), np.uint8)  # multiplied by alpha
    np.testing.assert_array_equal(Picture(picture).level(1, 1), half)


def test_the_levels_of_a_picture_are_made_once():
    picture = Picture(gray_picture(7))
    assert picture.level(2, 1) is picture.level(2, 1)
    part = Picture(picture.pixels[20:100, 20:100])
    assert part.level(0, 0) is part.level(0, 0)
    assert part.level(1, 1).shape == (40, 40, 3)


@pytest.mark.parametrize('corners, needed', [
    ([[10, 10], [50, 10], [50, 50], [10, 50]], {(1, 1)}),      # 160 pixels become 40, of two samples each way
    ([[10, 10], [20, 10], [20, 90], [10, 90]], {(3, 0)}),
    ([[10, 10], [170, 10], [170, 170], [10, 170]], {(0, 0)}),
    ([[300, 300], [310, 300], [310, 310], [300, 310]], set())])
def test_only_levels_that_are_needed_are_made(corners, needed):
    area, picture, asked = Area(np.float32(corners)), Picture(gray_picture(7)), set()

    def level(across, down):
        asked.add((across, down))
        return picture.level(across, down)
    mask = area_mask(np.zeros((200, 200), np.uint8), area)
    binding.warp_picture(picture.pixels, level, np.linalg.inv(area.homography(160, 160)), mask)
    assert asked == needed


def test_the_levels_go_with_their_picture():
    picture = Picture(gray_picture(7))
    level = weakref.ref(picture.level(1, 1))
    assert level() is not None
    del picture
    gc.collect()
    assert level() is None


def test_a_change_of_a_picture_is_painted():
    picture, frame = gray_picture(50), np.zeros((60, 60, 3), np.uint8)
    assert overlay(frame, picture, AREA)[30, 30, 0] == 50
    picture[:] = 90
    assert overlay(frame, picture, AREA)[30, 30, 0] == 90
