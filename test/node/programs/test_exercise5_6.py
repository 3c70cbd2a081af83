"""Exercise 5.6 itself, without ROS: what it paints."""
import numpy as np
import pytest
from aruco_ar import Lens, Tracker, overlay
from aruco_ar.exercise import Runner, Scene
from aruco_ar.painting.picture import Picture
from aruco_ar.painting.sources import Still
from aruco_ar.settings.settings import PictureSettings
from aruco_ar.simulation.robot import Camera
from exercise5_6 import EXERCISE, paint_picture

LENS = Lens(640, 480, Camera().matrix, np.array([-0.3, 0.1, 0.001, -0.001, 0.0]))


@pytest.mark.parametrize('fit', ['stretch', 'contain', 'cover'])
@pytest.mark.parametrize('lens', [None, LENS])
def test_the_function_paints_what_exercise_5_6_paints(frame, earth, fit, lens):
    settings = PictureSettings(fit=fit, opacity=0.7)
    area = Tracker().update(frame, 0.0, lens)
    result = paint_picture(Scene(frame, frame.copy(), settings, [], area, Picture(earth), lens))
    assert not np.array_equal(result.images[0], frame)
    np.testing.assert_array_equal(
        result.images[0], overlay(frame, earth, area, fit=fit, opacity=settings.opacity))


def test_what_is_in_front_of_the_wall_stays_there_in_the_walls_light(frame):
    """The same steps in detail: test/plain/looks."""
    white = np.full((40, 60, 3), 255, np.uint8)
    runner = Runner(EXERCISE, [PictureSettings(foreground='keep', light='match')], lambda _: Still(white))
    for number in range(20):
        seen = frame.copy()
        if number >= 10:
            seen[:, 250:330] = (40, 40, 200)
        sight, images = runner.run(seen, number / 15, keeps_frame=True)
        image = images[0].astype(int)
        area = np.int32(sight.areas[0].area.corners)
    y = area[:, 1].mean().astype(int)
    assert area[0, 0] < 240 and area[1, 0] > 340  # the red thing covers the middle, and not all
    np.testing.assert_allclose(image[y, 290], (40, 40, 200), atol=8)
    for column in (area[0, 0] + 30, area[1, 0] - 30):
        assert image[y, column].min() > 200 and np.any(image[y, column] != frame[y, column])
