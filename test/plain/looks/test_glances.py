"""Frames that are only glanced at, since nothing was in front before: they look like those that are learned."""
import cv2
import numpy as np
import pytest
from aruco_ar import Area, Tag
from aruco_ar.looks.hanging import EVERY, Hanging
from aruco_ar.settings.settings import PictureSettings
from aruco_ar.tracking.sight import SeenArea, Sight

CORNERS = np.float32([[120, 100], [520, 110], [510, 380], [130, 370]])
SETTLED = 45  # frames after which the wall is known
GRAY = 150


def wall(random, pattern):
    """(480, 640, 3) uint8: a wall, and four black tags on the corners of the area."""
    image = np.full((480, 640, 3), GRAY, np.uint8)
    if pattern:
        image[:] = cv2.resize(random.randint(60, 220, (24, 32, 3)).astype(np.uint8), (640, 480))
    for x, y in CORNERS.astype(int):
        image[y - 25:y + 25, x - 25:x + 25] = 235
        image[y - 20:y + 20, x - 20:x + 20] = 20
    return image


def noisy(image, random):
    """Some images with noise: with new noise in each frame, this would take ten times as long."""
    return [np.clip(image + random.normal(0, 2, image.shape), 0, 255).astype(np.uint8) for _ in range(4)]


def look_at(hanging, frame, number, settings):
    tags = tuple(Tag(tag_id, np.float32([[-20, -20], [20, -20], [20, 20], [-20, 20]]) + corner)
                 for tag_id, corner in enumerate(CORNERS))
    return hanging.update(Sight(frame, number / 15), SeenArea(Area(CORNERS, 1.5), tags, is_located=True), frame,
                          settings)


@pytest.mark.parametrize('color', [(40, 40, 40), (90, 120, 190)])
@pytest.mark.parametrize('pattern', [False, True])
@pytest.mark.parametrize('come', range(SETTLED, SETTLED + EVERY))
def test_what_comes_is_in_front_in_its_first_frame(random, come, pattern, color):
    hanging, settings, bare = Hanging(), PictureSettings(foreground='keep'), wall(random, pattern)
    frames = noisy(bare, random)
    for number in range(come):
        assert look_at(hanging, frames[number % 4], number, settings).front is None
    frames[come % 4][220:260, 300:340] = color
    front = look_at(hanging, frames[come % 4], come, settings).front
    seen = cv2.warpPerspective(front, Area(CORNERS).homography(*front.shape[::-1]), (640, 480))
    assert seen[225:255, 305:335].min() > 0.9
    seen[200:280, 280:360] = 0
    assert seen.max() < 0.1


@pytest.mark.parametrize('foreground', ['keep', 'paint'])
def test_the_light_does_not_flicker(random, foreground):
    hanging, settings = Hanging(), PictureSettings(foreground=foreground, light='match')
    bare = wall(random, True)
    white = np.int32([look_at(hanging, bare, number, settings).white for number in range(SETTLED + 2 * EVERY)])
    assert np.abs(np.diff(white[SETTLED:], axis=0)).max() <= 2
