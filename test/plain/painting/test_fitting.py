"""Fitting pictures into areas, with their own proportions on the wall, from any viewpoint."""
import tracemalloc

import cv2
import numpy as np
import pytest
from aruco_ar import Area, Detector, InputError, Tracker, area_mask, find_area, overlay
from aruco_ar.painting.fit import fit_picture
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import Wall, WallTag

RED, GREEN, BLUE = (0, 0, 255), (0, 255, 0), (255, 0, 0)
SLANTED = wall_to_camera(Pose(-1.9, 0.9, -0.42))


def wall(width, height, turn=0):
    """A wall with an area of that size in meters, centered at (0, 0.6)."""
    x, y = width / 2, height / 2
    tags = tuple(WallTag(number, *place, 0.15, turn) for number, place in enumerate(
        [(-x, 0.6 + y), (x, 0.6 + y), (x, 0.6 - y), (-x, 0.6 - y)], start=1))
    return Wall(8, 2.6, (186, 203, 214), 'DICT_6X6_250', 1, tags, (1, 2, 3, 4))


def render(wall, view=SLANTED):
    return WallRenderer(wall, Camera()).render(*view)


@pytest.mark.parametrize('turn', [0, 30, 90])
@pytest.mark.parametrize('width, height', [(0.9, 0.6), (0.5, 0.75)])
def test_the_proportions_on_the_wall_are_known_from_any_viewpoint(width, height, turn):
    frame = render(wall(width, height, turn))
    assert find_area(Detector().detect(frame)).ratio == pytest.approx(width / height, rel=0.02)
    area = Tracker(upright='image').update(frame, 0.0)
    assert area.ratio == pytest.approx(width / height, rel=0.02)
    # The tags of a rotated wall have their tops at its side, and so has the picture.
    on_its_side = turn == 90
    area = Tracker().update(frame, 0.0)
    assert area.ratio == pytest.approx(height / width if on_its_side else width / height, rel=0.02)


def on_wall(view, points):
    return project(np.array([[x, y, 0.0] for x, y in points]), *view, Camera())[0]


def test_contain_shows_the_whole_picture_undistorted():
    scene = wall(0.9, 0.6)
    frame = render(scene)
    picture = np.full((100, 50, 3), GREEN, np.uint8)  # it should be 0.3 m wide
    image = overlay(frame, picture, Tracker().update(frame, 0.0), fit='contain')
    inside = on_wall(SLANTED, [(-0.145, 0.895), (0.145, 0.895), (0.145, 0.305), (-0.145, 0.305), (0, 0.6)])
    for x, y in np.int32(np.round(inside)):
        assert image[y, x].tolist() == list(GREEN)
    outside = on_wall(SLANTED, [(-0.16, 0.8), (0.16, 0.8), (-0.16, 0.4), (0.16, 0.4), (-0.4, 0.6), (0.4, 0.6)])
    for x, y in np.int32(np.round(outside)):
        np.testing.assert_array_equal(image[y, x], frame[y, x])


def test_cover_fills_the_area_with_the_middle_of_the_picture():
    scene = wall(0.9, 0.6)
    frame = render(scene)
    picture = np.full((400, 200, 3), RED, np.uint8)   # a third of it fills the area
    picture[134:267] = BLUE
    image = overlay(frame, picture, Tracker().update(frame, 0.0), fit='cover')
    inside = on_wall(SLANTED, [(-0.44, 0.89), (0.44, 0.89), (0.44, 0.31), (-0.44, 0.31), (0, 0.6)])
    for x, y in np.int32(np.round(inside)):
        assert image[y, x].tolist() == list(BLUE)


@pytest.mark.parametrize('channels', [3, 4])
def test_cover_paints_what_a_picture_that_was_cut_by_hand_would_show(random, channels):
    frame = np.full((240, 320, 3), 100, np.uint8)
    area = Area(np.float32([[60, 30], [260, 60], [250, 180], [70, 210]]), 1.5)
    coarse = random.randint(0, 256, (30, 20, channels)).astype(np.uint8)
    picture = cv2.resize(coarse, (600, 900), interpolation=cv2.INTER_CUBIC)
    whole = overlay(frame, picture, area, fit='cover')
    cut = overlay(frame, picture[250:650].copy(), area)
    off = np.abs(whole.astype(int) - cut)
    # Beyond the cut there are real pixels now, where the rim's were repeated: this is seen at the very rim.
    inside = cv2.erode(area_mask(frame, area), np.ones((5, 5)))
    assert off[inside == 255].max() <= 8 and off[inside == 255].mean() < 0.5


def test_a_running_ratio_makes_no_further_smaller_sizes_of_the_picture(random):
    frame = np.full((240, 320, 3), 100, np.uint8)
    corners = np.float32([[60, 30], [260, 60], [250, 180], [70, 210]])
    picture = random.randint(0, 256, (1200, 1600, 3)).astype(np.uint8)
    picture.setflags(write=False)  # as the exercises do
    ratios = np.linspace(1.4, 1.6, 60)
    overlay(frame, picture, Area(corners, ratios[0]), fit='cover')
    tracemalloc.start()
    try:
        images = [overlay(frame, picture, Area(corners, ratio), fit='cover') for ratio in ratios]
        grown, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert grown < sum(image.nbytes for image in images) + 1e6  # one set of smaller sizes has 1.9 MB
    for ratio, image in zip(ratios[::10], images[::10]):
        np.testing.assert_array_equal(image, overlay(frame, picture.copy(), Area(corners, ratio), fit='cover'))


def test_what_is_cut_off_may_be_behind_the_camera(random):
    frame = np.full((480, 640, 3), 100, np.uint8)
    area = Area(np.float32([[100, 20], [500, 200], [500, 280], [100, 460]]), 1 / 3)
    wide = np.full((50, 1000, 3), RED, np.uint8)
    wide[:, 488:513] = BLUE  # 17 px of it fill the area
    image = overlay(frame, wide, area, fit='cover')
    for x, y in ((105, 240), (300, 240), (495, 240)):
        assert image[y, x].tolist() == list(BLUE)


def test_stretch_fills_the_area_with_the_whole_picture():
    picture = np.zeros((40, 20, 3), np.uint8)
    area = Area(np.float32([[10, 10], [110, 10], [110, 60], [10, 60]]), 2.0)
    corners, place = fit_picture(picture, area, 'stretch')
    assert corners.tolist() == [[0, 0], [20, 0], [20, 40], [0, 40]] and place is area


def test_without_tags_the_proportions_in_the_frame_are_used():
    area = Area(np.float32([[10, 10], [110, 10], [110, 60], [10, 60]]))
    _, place = fit_picture(np.zeros((50, 50, 3), np.uint8), area, 'contain')
    np.testing.assert_allclose(place.corners, [[35, 10], [85, 10], [85, 60], [35, 60]], atol=1e-3)


def test_opacity_blends_the_picture_with_the_frame():
    frame = np.full((100, 200, 3), 100, np.uint8)
    area = Area(np.float32([[50, 20], [150, 20], [150, 80], [50, 80]]))
    clear = np.dstack([np.full((10, 10, 3), 200, np.uint8), np.full((10, 10), 128, np.uint8)])
    for picture, expected in ((clear[..., :3].copy(), 125), (clear, 112.5)):
        image = overlay(frame, picture, area, opacity=0.25)
        assert abs(int(image[50, 100, 0]) - expected) <= 1 and image[10, 10, 0] == 100
    np.testing.assert_array_equal(overlay(frame, clear, area, opacity=0.0), frame)
    assert np.ptp(cv2.absdiff(overlay(frame, None, area), frame)) == 0


def test_a_very_thin_picture_is_painted_and_an_unknown_fit_is_named():
    frame = np.full((100, 200, 3), 100, np.uint8)
    area = Area(np.float32([[50, 20], [150, 20], [150, 80], [50, 80]]), 5 / 3)
    for shape in ((1, 4096, 3), (4096, 1, 3), (1, 1, 3)):
        for fit in ('contain', 'cover'):
            image = overlay(frame, np.full(shape, 255, np.uint8), area, fit=fit)
            assert image[5, 5, 0] == 100 and image[50, 100, 0] > 100
    tiny = Area(np.float32([[50, 20], [53, 20], [53, 21.6], [50, 21.6]]), 1.9)
    high = np.full((4096, 1, 3), 9, np.uint8)
    np.testing.assert_array_equal(overlay(frame, high, tiny, fit='contain'), frame)
    with pytest.raises(InputError, match='"squeeze".*stretch, contain, cover'):
        overlay(frame, np.zeros((2, 2, 3), np.uint8), area, fit='squeeze')
