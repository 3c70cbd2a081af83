"""Areas, frames and tags of any kind are no harm to the look of the picture."""
import numpy as np
import pytest
from aruco_ar import Area, Tag
from aruco_ar.looks.hanging import Hanging
from aruco_ar.painting.place import find_place
from aruco_ar.settings.settings import PictureSettings
from aruco_ar.tracking.sight import SeenArea, Sight

ALL = PictureSettings(foreground='keep', light='match', grain='match', tags='hide')


@pytest.mark.parametrize('corners', [
    [[-900, -900], [-700, -900], [-700, -800], [-900, -800]],             # out of view
    [[300.2, 200.1], [300.3, 200.1], [300.3, 200.2], [300.2, 200.2]],     # tiny
    [[-1e6, -1e6], [1e6, -1e6], [1e6, 1e6], [-1e6, 1e6]],                 # all around
    [[0, 0], [4000, 10], [640, 480], [10, 3000]],
])
def test_areas_of_any_size_and_place_are_no_harm(frame, corners):
    hanging, area = Hanging(), Area(np.float32(corners))
    for number in range(3):
        on_wall = hanging.update(Sight(frame, float(number)), SeenArea(area, is_located=True), frame, ALL)
        place = find_place(frame, area, frame)
        looked, mask = on_wall.apply(np.full_like(place.window, 128), place)
        assert looked.shape[:2] == mask.shape[:2] == place.window.shape[:2]


def test_random_frames_areas_and_tags_are_no_harm(random):
    hanging = Hanging()
    for number in range(60):
        height, width = [(480, 640), (1, 1), (7, 900), (60, 80)][random.randint(4)]
        frame = random.randint(0, 256, (height, width, 3)).astype(np.uint8)
        frame[:] = [frame, 0, 255, random.randint(256)][random.randint(4)]
        side = 10**random.uniform(0, 4)
        corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * side + random.normal(0, side / 8, (4, 2))
        corners += random.uniform(-side, 640, 2)
        area = Area(np.float32(corners), [None, 1.5, 0.01, 50.0][random.randint(4)])
        tags = [Tag(tag_id, np.float32(corners / 9 + 8 / 9 * corner))
                for tag_id, corner in enumerate(corners[:random.randint(5)])]
        seen = SeenArea(area, tuple(tags), is_located=bool(random.rand() < 0.9))
        with np.errstate(all='raise'):
            on_wall = hanging.update(Sight(frame, number / 15), seen, frame, ALL)
            place = find_place(frame, area, frame)
            picture = random.randint(0, 256, (*place.window.shape[:2], 3 + number % 2)).astype(np.uint8)
            looked, mask = on_wall.apply(picture, place)
        assert looked.shape[:2] == mask.shape[:2] == place.window.shape[:2]
        assert looked.dtype == mask.dtype == np.uint8
