"""What real walls do to the model of the wall: patterns, sheets that are not flat, glare, and deep shadows."""
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar.looks.wall_model import WallModel
from test_looks import FRAMES_PER_S, Drive, around, core, hand, is_kept, is_painted, painted, stage, with_sheet

pytestmark = pytest.mark.long
SHEET_PX = 800, 600


@pytest.fixture
def checkered(wall, tmp_path):
    """A function that makes the wall checkered. It takes the width of a field, in pixels of the sheet."""
    def make(field):
        y, x = np.mgrid[:SHEET_PX[1], :SHEET_PX[0]] // field
        cv2.imwrite(str(tmp_path / 'sheet.png'), np.where((x + y) % 2, 210, 25).astype(np.uint8))
        return with_sheet(wall, tmp_path / 'sheet.png')
    return make


def bulging(frame, inside, number, px):
    """The frame as if the sheet bulged: in the middle it moves by ``px`` to both sides."""
    rows, columns = np.float32(np.mgrid[:frame.shape[0], :frame.shape[1]])
    from_middle = np.hypot(rows - rows[inside].mean(), columns - columns[inside].mean())
    off = px * np.sin(2 * np.pi * number / FRAMES_PER_S) * np.exp(-(from_middle / 60)**2)
    return cv2.remap(frame, np.float32(columns + off), rows, cv2.INTER_LINEAR)


def test_large_dark_fields_of_a_pattern_are_no_things_in_front(checkered):
    drive, keeps = Drive(checkered(130)), stage(foreground='keep')
    for number in range(10):
        frame, inside = drive.frame(number)
        assert is_painted(painted(keeps, frame, number), inside) > 0.99


def test_half_of_a_wall_in_another_color_is_a_part_of_it_after_some_seconds(wall, tmp_path):
    sheet = np.full((600, 800, 3), (225, 228, 230), np.uint8)
    sheet[:, 450:] = 60, 40, 90
    cv2.imwrite(str(tmp_path / 'sheet.png'), sheet)
    drive, keeps = Drive(with_sheet(wall, tmp_path / 'sheet.png')), stage(foreground='keep')
    for number in range(6 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        image = painted(keeps, frame, number)
    assert is_painted(image, inside) > 0.99


def test_a_sheet_that_bulges_is_painted_all_over_and_a_hand_stays_in_front_of_it(checkered):
    drive, keeps = Drive(checkered(40)), stage(foreground='keep')
    for number in range(4 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        if number > FRAMES_PER_S:
            frame = bulging(frame, inside, number, 5)
        things = hand(frame, number) if number > 3 * FRAMES_PER_S else np.zeros(inside.shape, bool)
        image = painted(keeps, frame, number)
        assert is_painted(image, around(things, inside)) > 0.98
        if things.any():
            assert is_kept(image, frame, core(things) & inside) > 0.9


def test_a_glare_on_a_pattern_is_painted_over(checkered):
    drive, keeps = Drive(checkered(130)), stage(foreground='keep')
    for number in range(2 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        if number > FRAMES_PER_S:
            glare = np.zeros(frame.shape[:2], np.float32)
            cv2.circle(glare, (290 + 4 * (number % 10), 200), 60, 1, -1)
            glare = cv2.GaussianBlur(glare, (0, 0), 20)[..., None]
            frame = np.uint8(np.clip(frame * (1 - 0.5 * glare) + 110 * glare, 0, 255))
        assert is_painted(painted(keeps, frame, number), inside) > 0.97


def test_black_fields_do_not_tell_the_color_of_the_light(checkered):
    # In little light, a black field has few gray levels. So a faint reflection multiplies them.
    drive, matches = Drive(checkered(100), noise=1.0), stage((255, 255, 255), light='match')
    for number in range(FRAMES_PER_S):
        frame, inside = drive.frame(number)
        dim = frame * 0.2 + (np.array([3, 1, 0]) if number > 5 else 0)
        image = painted(matches, np.uint8(dim), number)
        light = np.median(image[inside], axis=0)
        assert light.min() > 0.17 * 245
        off = np.abs(image[inside] - light).max(axis=1)
        assert np.percentile(off, 99) < 8


def test_what_is_much_lighter_than_the_wall_stays_in_front_though_its_color_is_the_wall_s(wall):
    drive, keeps = Drive(replace(wall, color=(90, 100, 110))), stage(foreground='keep')
    for number in range(2 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        if number < FRAMES_PER_S:
            assert is_painted(painted(keeps, frame, number), inside) == 1
            continue
        things = np.zeros(frame.shape[:2], np.uint8)
        cv2.circle(things, (300 + 2 * (number % 10), 200), 45, 255, -1)
        soft = cv2.GaussianBlur(things, (0, 0), 1.0)[..., None] / 255
        frame = np.uint8(frame * (1 - soft) + np.array([162, 180, 198]) * soft)
        assert is_kept(painted(keeps, frame, number), frame, core(things > 0) & inside) > 0.97


@pytest.mark.parametrize('begin, end', [(-60, 700), (260, 1100), (400, 80)])
def test_while_a_deep_shadow_comes_or_leaves_or_crosses_all_of_the_wall_is_painted(wall, begin, end):
    drive, keeps, frames = Drive(wall), stage(foreground='keep'), 5 * FRAMES_PER_S
    for number in range(frames):
        frame, inside = drive.frame(number)
        shade = np.zeros(frame.shape[:2], np.float32)
        edge = begin + (end - begin) * number // frames
        cv2.rectangle(shade, (edge - 330, 0), (edge, 480), 1.0, -1)
        frame = np.uint8(frame * (1 - 0.55 * cv2.GaussianBlur(shade, (0, 0), 9)[..., None]))
        assert is_painted(painted(keeps, frame, number), inside) > 0.99


def test_a_hand_in_front_of_a_fine_pattern_stays_in_front(checkered):
    drive, keeps = Drive(checkered(16)), stage(foreground='keep')
    for number in range(5 * FRAMES_PER_S):
        frame, inside = drive.frame(number)
        if number < 3 * FRAMES_PER_S:
            painted(keeps, frame, number)
            continue
        things = hand(frame, number)
        assert is_kept(painted(keeps, frame, number), frame, core(things) & inside) > 0.98


def test_the_light_does_not_take_its_color_from_a_person_who_comes_while_a_shadow_falls():
    model, valid = WallModel(), np.ones((160, 240), bool)
    wall = np.full((160, 240, 3), (180, 190, 200), np.uint8)
    for number in range(30):
        frame = wall.copy()
        if number >= 20:
            frame[:, :80] = 60, 60, 210                 # a red shirt
            frame[:, 160:] = frame[:, 160:] * 0.45      # a shadow
        model.update(frame, valid, lambda: ~valid, 1 / FRAMES_PER_S, 30)
        assert model.light.max() < 1.1 * model.light.min()


def test_a_black_frame_teaches_nothing_and_says_nothing(recwarn):
    model, valid = WallModel(), np.ones((160, 240), bool)
    wall = np.full((160, 240, 3), (180, 190, 200), np.uint8)
    for frame in wall, wall * 0, wall:
        model.update(frame, valid, lambda: ~valid, 1 / FRAMES_PER_S, 30)
    assert not recwarn.list
    assert model.front.mean() < 0.01
