"""A picture in several sizes."""
import gc
import weakref

import numpy as np
from aruco_ar import Area, overlay
from aruco_ar.painting.picture import Picture

AREA = Area(np.float32([[10, 10], [50, 10], [50, 50], [10, 50]]))


def gray_picture(gray, channels=3):
    return np.full((160, 160, channels), gray, np.uint8)


def test_each_level_is_the_mean_of_the_one_before(random):
    picture = random.randint(0, 256, (8, 6, 3)).astype(np.uint8)
    levels = Picture(picture).levels(9)
    assert [level.shape[:2] for level in levels] == [(8, 6), (4, 3), (2, 1)]
    mean = picture.reshape(4, 2, 3, 2, 3).mean(axis=(1, 3))
    assert np.abs(levels[1] - mean).max() <= 0.5


def test_hidden_colors_do_not_bleed_into_smaller_levels():
    picture = np.zeros((4, 4, 4), np.uint8)
    picture[:, ::2] = 0, 0, 255, 0     # red, but invisible
    picture[:, 1::2] = 200, 100, 0, 255
    half = np.full((2, 2, 4), (200, 100, 0, 128), np.uint8)
    np.testing.assert_array_equal(Picture(picture).levels(1)[1], half)


def test_the_levels_of_a_picture_are_made_once():
    picture = Picture(gray_picture(7))
    assert picture.levels(2)[2] is picture.levels(3)[2]
    part = Picture(picture.pixels[20:100, 20:100])
    assert part.levels(1)[1] is part.levels(1)[1]
    assert part.levels(1)[1].shape == (40, 40, 3)


def test_the_levels_go_with_their_picture():
    picture = Picture(gray_picture(7))
    level = weakref.ref(picture.levels(1)[1])
    assert level() is not None
    del picture
    gc.collect()
    assert level() is None


def test_a_change_of_a_picture_is_painted():
    picture, frame = gray_picture(50), np.zeros((60, 60, 3), np.uint8)
    assert overlay(frame, picture, AREA)[30, 30, 0] == 50
    picture[:] = 90
    assert overlay(frame, picture, AREA)[30, 30, 0] == 90
