"""A thing that comes and stands still stays in front of the picture, and darkens it in no case."""
import numpy as np
import pytest
from test_looks import (
    FRAMES_PER_S,
    Drive,
    assert_in_front,
    core,
    hand,
    is_kept,
    is_painted,
    painted,
    stage,
    with_sheet,
)

pytestmark = pytest.mark.long
DARK, LIGHT = (35, 33, 32), (200, 200, 200)


def test_a_thing_that_comes_and_stands_still_stays_in_front_for_good(wall):
    drive, keeps = Drive(wall), stage(foreground='keep', settle=2.0)
    for number in range(12 * FRAMES_PER_S):
        frame, inside = drive.frame(0)
        if number < 3 * FRAMES_PER_S:
            painted(keeps, frame, number)
            continue
        things = hand(frame, 0, DARK, moves=False)
        image = painted(keeps, frame, number)
        if number % FRAMES_PER_S == 0:
            assert_in_front(image, frame, things, inside)


def test_a_dark_thing_that_becomes_wall_is_no_shadow_on_the_picture(wall):
    drive, both = Drive(wall), stage(LIGHT, foreground='keep', light='match', settle=2.0)
    before = None
    for number in range(8 * FRAMES_PER_S):
        frame, inside = drive.frame(0)
        if number >= FRAMES_PER_S // 2:
            things = hand(frame, 0, DARK, moves=False)
        image = painted(both, frame, number)
        if number == 0:
            before = image
    where = core(things) & inside
    assert is_kept(image, frame, where) < 0.05  # it has become wall
    assert np.abs(image[where].astype(float) - before[where]).mean() < 8


def test_where_a_thing_that_was_there_from_the_first_frame_on_has_left_a_pattern_is_soon_painted_over(
        wall, package):
    drive, keeps = Drive(with_sheet(wall, package + '/images/earth.jpg')), stage(foreground='keep')
    for number in range(12 * FRAMES_PER_S):
        frame, inside = drive.frame(0)
        if number < 8 * FRAMES_PER_S:
            hand(frame, 0, moves=False)
        image = painted(keeps, frame, number)
    assert is_painted(image, inside) > 0.98
