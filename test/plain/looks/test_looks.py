"""What stands in front of the wall stays in front of the picture, and the picture takes the wall's light."""
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import Area, Lens, Tracker, area_mask
from aruco_ar.exercise import Runner
from aruco_ar.looks.hanging import Hanging
from aruco_ar.painting.paint import warp
from aruco_ar.painting.place import find_place
from aruco_ar.painting.sources import Still
from aruco_ar.settings.settings import PictureSettings
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.tracking.sight import SeenArea, Sight
from aruco_ar.walls.wall import Poster
from exercise5_6 import EXERCISE

pytestmark = pytest.mark.long
GREEN, SKIN = (40, 160, 60), (118, 150, 200)
FRAMES_PER_S = 15
BENT = Camera(distortion=[-0.25, 0.08, 0, 0, 0])
STRAIGHT = Camera()


def stage(color=GREEN, **settings):
    """A Runner of exercise 5.6 that paints a color, or a picture."""
    picture = np.full((60, 90, len(color)), color, np.uint8) if isinstance(color, tuple) else color
    return Runner(EXERCISE, [PictureSettings(**settings)], lambda _: Still(picture))


def painted(stage, frame, number, lens=None):
    return stage.run(frame, number / FRAMES_PER_S, lens, keeps_frame=True)[1][0]


class Drive:
    """Frames of a wall from a camera that moves a little, and where the area is in them."""

    def __init__(self, wall, camera=STRAIGHT, noise=2.0, **look):
        self._wall, self._camera = wall, camera
        self._renderer = WallRenderer(wall, camera, noise=noise, **look)

    def frame(self, number):
        """(the frame, (h, w) bool: the inside of the area)."""
        view = wall_to_camera(Pose(-1.9, 0.1 + 0.004 * number, -0.05 - 0.001 * number))
        frame = self._renderer.render(*view)
        lens = self._camera.lens if self._camera.lens.bends else None
        area = Area(np.float32(project(self._wall.area_corners, *view, self._camera)[0]), lens=lens)
        return frame, cv2.erode(area_mask(frame, area)[..., 0], np.ones((5, 5))) == 255


def hand(frame, number, color=SKIN, moves=True):
    """Draw a hand and an arm that reach into the area from below; returns where they are, (h, w) bool."""
    x, y = (int(3 * (number % 20)), int(2 * (number % 7))) if moves else (0, 0)
    cover = np.zeros(frame.shape[:2], np.uint8)
    cv2.line(cover, (330 + x, 470), (290 + x, 230 + y), 255, 46)
    cv2.circle(cover, (288 + x, 215 + y), 34, 255, -1)
    soft = cv2.GaussianBlur(cover, (0, 0), 0.7)[..., None] / 255
    frame[:] = np.round(frame * (1 - soft) + np.array(color) * soft)
    return cover > 0


def is_kept(image, frame, where):
    """The share of these pixels that are as in the frame."""
    return np.mean(np.abs(image[where].astype(int) - frame[where]).max(axis=1) < 25)


def is_painted(image, where, color=GREEN):
    return np.mean(np.abs(image[where].astype(int) - color).max(axis=1) < 25)


def core(where):
    return cv2.erode(where.astype(np.uint8), np.ones((5, 5))) > 0


def around(things, inside, px=15):
    """Where the area is farther from things than px // 2 pixels."""
    return inside & ~(cv2.dilate(things.astype(np.uint8), np.ones((px, px))) > 0)


def with_sheet(wall, path):
    """The wall with a picture hung behind its tags."""
    return replace(wall, posters=(Poster(str(path), 0, 0.6, 1.6, 1.2),))


def assert_in_front(image, frame, things, inside):
    """Assert that the picture is painted all around things that stand in front of it, and not over them."""
    assert is_kept(image, frame, core(things) & inside) > 0.97
    assert is_painted(image, around(things, inside, 9)) > 0.99


@pytest.mark.parametrize('light, levels', [('full', 0), ('match', 2)])  # with keep, light is learned more often
def test_where_nothing_is_in_front_every_pixel_is_painted_as_without_keep(wall, light, levels):
    drive, with_it, without = Drive(wall), stage(foreground='keep', light=light), stage(light=light)
    for number in range(20):
        frame, _ = drive.frame(number)
        off = cv2.absdiff(painted(with_it, frame, number), painted(without, frame, number))
        assert off.max() <= levels


@pytest.mark.parametrize('camera', [STRAIGHT, BENT])
def test_a_hand_stays_in_front_of_the_picture(wall, camera):
    drive, keeps, paints = Drive(wall, camera), stage(foreground='keep'), stage()
    lens = camera.lens if camera.lens.bends else None
    for number in range(30):
        frame, inside = drive.frame(number)
        if number < 10:
            painted(keeps, frame, number, lens)
            painted(paints, frame, number, lens)
            continue
        things = hand(frame, number)
        assert_in_front(painted(keeps, frame, number, lens), frame, things, inside)
        assert is_painted(painted(paints, frame, number, lens), things & inside) > 0.97


def test_a_hand_that_is_there_from_the_first_frame_stays_in_front_on_a_blank_wall(wall):
    drive, keeps = Drive(wall), stage(foreground='keep')
    for number in range(45):
        frame, inside = drive.frame(number)
        things = hand(frame, number)
        image = painted(keeps, frame, number)
        if number > FRAMES_PER_S:
            assert_in_front(image, frame, things, inside)


def test_a_hand_in_front_of_a_painting_stays_in_front(wall, package):
    drive, keeps = Drive(with_sheet(wall, package + '/images/earth.jpg')), stage(foreground='keep')
    for number in range(30):
        frame, inside = drive.frame(number)
        things = hand(frame, number) if number >= 10 else None
        image = painted(keeps, frame, number)
        if things is None:
            assert is_painted(image, inside) == 1
        else:
            assert is_kept(image, frame, core(things) & inside) > 0.9
            assert is_painted(image, around(things, inside)) > 0.98


def shadow(frame, number, factor=(0.55, 0.5, 0.48)):
    """Put a moving shadow with a soft rim on a frame; returns the light, (h, w, 3)."""
    shade = np.zeros(frame.shape[:2], np.float32)
    cv2.fillPoly(shade, [np.int32([[150, 0], [330, 0], [380, 479], [200, 479]]) + [5 * number, 0]], 1.0)
    shade = cv2.GaussianBlur(shade, (0, 0), 6)[..., None]
    light = 1 + shade * (np.float32(factor) - 1)
    frame[:] = np.round(frame * light)
    return light


def test_a_shadow_is_painted_over_but_falls_on_the_picture(wall):
    drive, both = Drive(wall), stage((200, 200, 200), foreground='keep', light='match')
    keeps = stage(foreground='keep')
    for number in range(30):
        frame, inside = drive.frame(number)
        bright = painted(stage((200, 200, 200), light='match'), frame, number)
        light = shadow(frame, number) if number >= 10 else 1
        assert is_painted(painted(keeps, frame, number), inside) > 0.99
        image = painted(both, frame, number)
        if number >= 10:
            off = np.abs(image.astype(float) - bright * light)[inside]
            assert off.mean() < 4 and np.percentile(off, 99) < 20


def test_white_in_the_picture_is_as_light_as_the_paper_of_the_tags(wall):
    drive = Drive(wall, noise=0.0)
    for color, level in (255, 245), (0, 20):  # the levels of the simulated paper and ink
        frame, inside = drive.frame(0)
        image = painted(stage((color,) * 3, light='match'), frame, 0)
        np.testing.assert_allclose(image[inside].mean(axis=0), level, atol=7)


def test_a_thing_that_hangs_there_for_long_becomes_wall_and_the_wall_comes_back_at_once(wall):
    drive, keeps = Drive(wall), stage(foreground='keep', settle=2.0)
    shares = []
    for number in range(110):
        frame, inside = drive.frame(0)
        things = np.zeros(frame.shape[:2], bool)
        if number >= 20:
            things = hand(frame, 0, moves=False)
        shares.append(is_painted(painted(keeps, frame, number), core(things) & inside) if number >= 20 else 1)
    assert max(shares[21:40]) < 0.05   # in front at first
    assert min(shares[90:]) > 0.95     # and a part of the wall after 2 s, and 2 s to see that it is still
    for number in range(110, 115):
        frame, inside = drive.frame(0)
        image = painted(keeps, frame, number)
    assert is_painted(image, inside) > 0.99


def test_a_hand_that_moves_very_slowly_stays_in_front(wall):
    drive, keeps = Drive(wall), stage(foreground='keep')
    for number in range(250):
        frame, inside = drive.frame(abs(number % 20 - 10))
        things = hand(frame, 0.04 * number)
        image = painted(keeps, frame, number)
        if number % 10 == 9:
            assert is_kept(image, frame, core(things) & inside) > 0.97


def test_another_wall_is_learned_at_once(wall):
    keeps = stage(foreground='keep')
    for number in range(40):
        color = wall.color if number < 20 else (60, 120, 70)
        frame, inside = Drive(replace(wall, color=color)).frame(0)
        image = painted(keeps, frame, number)
        assert number == 0 or is_painted(image, inside) > 0.99


def test_a_screen_that_shows_a_film_stays_in_front_until_it_stops(wall):
    drive, keeps = Drive(wall), stage(foreground='keep', settle=2.0)
    colors = [(60, 60, 210), (200, 90, 40), (40, 180, 60), (30, 190, 220), (180, 40, 160)]
    for number in range(140):
        frame, inside = drive.frame(0)
        screen = cv2.erode(inside.astype(np.uint8), np.ones((71, 71))) > 0
        if number >= 10:
            frame[screen] = colors[min(number, 60) // 5 % len(colors)]
        image = painted(keeps, frame, number)
        if 10 <= number < 60:
            assert is_kept(image, frame, core(screen)) > 0.9
        assert is_painted(image, around(screen, inside, 9)) > 0.99
    assert is_painted(image, inside) > 0.97


def test_reset_and_a_jump_back_in_time_forget_the_wall(wall):
    drive, frames = Drive(wall), []
    for number in range(3):
        frame, inside = drive.frame(number)
        hand(frame, 0, moves=False)
        frames.append(frame)
    bare, _ = drive.frame(5)
    for forget in (lambda stage: stage.reset()), (lambda stage: None):
        keeps = stage(foreground='keep')
        for number in range(20):
            painted(keeps, bare, 100 + number)
        image = painted(keeps, frames[0], 120)
        assert is_painted(image, inside) < 0.95
        forget(keeps)
        poster, _ = Drive(replace(wall, color=(60, 120, 70))).frame(0)
        assert is_painted(painted(keeps, poster, 0), inside) > 0.97


def test_a_frame_that_does_not_show_where_the_area_is_teaches_nothing(wall):
    drive, hanging = Drive(wall), Hanging()
    frame, _ = drive.frame(0)
    view = wall_to_camera(Pose(-1.9, 0.1, -0.05))
    area = Area(np.float32(project(wall.area_corners, *view, STRAIGHT)[0]), 1.5)
    picture = np.full_like(frame, GREEN)
    settings = PictureSettings(foreground='keep')
    for number in range(20):
        hanging.update(Sight(frame, number / FRAMES_PER_S), SeenArea(area, is_located=True), frame, settings)
    black = np.zeros_like(frame)
    on_wall = hanging.update(Sight(black, 1.4), SeenArea(area, is_located=False), black, settings)
    place = find_place(frame, area, picture)
    warped = warp(picture, place.homography, place.mask)
    assert on_wall.apply(warped, place)[0] is warped


def test_the_settings_that_ask_for_nothing_learn_nothing(wall):
    drive, hanging = Drive(wall), Hanging()
    frame, _ = drive.frame(0)
    seen = SeenArea(Tracker().update(frame, 0.0), is_located=True)
    assert hanging.update(Sight(frame, 0.0), seen, frame, PictureSettings()) is None
    asking = PictureSettings(foreground='keep', light='match', grain='match')
    on_wall = hanging.update(Sight(frame, 0.1), replace(seen, is_located=False), frame, asking)
    picture = np.full_like(frame, GREEN)
    place = find_place(frame, seen.area, picture)
    warped = warp(picture, place.homography, place.mask)
    applied, _ = on_wall.apply(warped.copy(), place)
    assert applied[..., :3].tolist() == warped.tolist()


def test_a_lens_and_an_area_partly_out_of_view_are_no_harm(wall):
    """The picture is painted on whatever of the area is in view."""
    lens = Lens(640, 480, STRAIGHT.matrix, np.array([-0.25, 0.08, 0, 0, 0.0]))
    renderer, keeps = WallRenderer(wall, BENT, noise=2.0), stage(foreground='keep', light='match')
    for number in range(40):
        view = wall_to_camera(Pose(-1.7, 0.1, -0.05 - 0.01 * number))
        frame = renderer.render(*view)
        sight, (image,) = keeps.run(frame, number / FRAMES_PER_S, lens, keeps_frame=True)
        area = Area(np.float32(project(wall.area_corners, *view, BENT)[0]), lens=lens)
        inside = cv2.erode(area_mask(frame, area)[..., 0], np.ones((9, 9))) == 255
        if sight.areas[0].is_located and sight.tags and inside.any():
            changed = np.abs(image.astype(int) - frame).max(axis=2) > 10
            assert changed[inside].mean() > 0.97
