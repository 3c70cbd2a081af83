"""The area, its mask, subtracting and painting, compared with the course's code."""
import cv2
import numpy as np
import pytest
from aruco_ar import (
    Area,
    Detector,
    Lens,
    Tag,
    area_mask,
    fill_polygon,
    find_area,
    mark_centers,
    mark_tags,
    overlay,
    subtract,
)
from aruco_ar.painting.paint import visible
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera
from benchmark.course import Course
from benchmark.simulated.painting import exact_mean, text

AREA = Area(np.float32([[150.3, 100.8], [470.6, 130.1], [450.2, 380.7], [170.9, 350.4]]))
LENS = Lens(640, 480, Camera().matrix, np.array([-0.3, 0.1, 0.001, -0.001, 0.0]))

# OpenCV interpolates the picture at 32nds of a pixel. At the strongest possible edge,
# a difference of one of them makes this many gray levels.
ROUNDING = 8


def square_tag(tag_id, x, y, side=20):
    return Tag(tag_id, np.float32([[x, y], [x + side, y], [x + side, y + side], [x, y + side]]) - side / 2)


def away_from_rim(area, shape, px):
    """(inside, outside): boolean masks of the pixels that are at least ``px`` away from the area's rim."""
    rim = np.zeros(shape[:2], np.uint8)
    cv2.polylines(rim, [np.int32(np.round(area.corners))], True, 255, 2 * px)
    inside = np.zeros(shape[:2], np.uint8)
    cv2.fillPoly(inside, [np.int32(np.round(area.corners))], 255)
    return (inside > 0) & (rim == 0), (inside == 0) & (rim == 0)


def course_overlay(frame, picture, area):
    return Course('DICT_6X6_250', picture).paint_at(frame, area.corners)


def test_the_area_is_where_the_truth_says(wall, view, frame):
    truth, _ = project(wall.area_corners, *view, Camera())
    np.testing.assert_allclose(find_area(Detector().detect(frame)).corners, truth, atol=0.5)


@pytest.mark.parametrize('tags', [
    [],
    [square_tag(1, 100, 100)],
    [square_tag(1, 100, 100), square_tag(2, 300, 100), square_tag(3, 300, 300)],
    [square_tag(1, 100, 100), square_tag(1, 300, 100), square_tag(1, 300, 300), square_tag(1, 100, 300)],
    [square_tag(1, 100, 100), square_tag(2, 300, 100), square_tag(2, 300, 300), square_tag(4, 100, 300)],
    [square_tag(i, 100 * i, 200) for i in range(1, 6)],
], ids=['none', 'one', 'three', 'one id four times', 'an id twice', 'on one line'])
def test_without_an_area_the_frame_is_unchanged(tags, frame, earth):
    area = find_area(tags)
    assert area is None
    np.testing.assert_array_equal(overlay(frame, earth, area), frame)
    mask = area_mask(frame, area)
    assert not mask.any()
    np.testing.assert_array_equal(subtract(frame, mask), frame)


def test_of_more_than_four_tags_the_largest_quadrilateral_is_used():
    corners = [(100, 100), (500, 110), (510, 400), (90, 380)]
    tags = [square_tag(9, 300, 250)] + [square_tag(i, *xy) for i, xy in enumerate(corners)] + \
        [square_tag(8, 320, 120)]
    np.testing.assert_allclose(find_area(tags).corners, corners)


def test_the_mask_is_white_in_the_area_and_black_elsewhere(frame):
    mask = area_mask(frame, AREA)
    inside, outside = away_from_rim(AREA, frame.shape, 1)
    assert np.all(mask[inside] == 255) and np.all(mask[outside] == 0)
    # The rim is exact to a fraction of a pixel.
    covered = mask[..., 0].sum() / 255
    assert covered == pytest.approx(cv2.contourArea(AREA.corners), rel=0.006)


def test_subtracting_blackens_the_area(frame):
    cut = subtract(frame, area_mask(frame, AREA))
    inside, outside = away_from_rim(AREA, frame.shape, 1)
    assert not cut[inside].any()
    np.testing.assert_array_equal(cut[outside], frame[outside])


def test_painting_equals_the_course_except_at_the_rim(frame, earth):
    whole = Area(np.round(AREA.corners))
    earth = cv2.resize(earth, (240, 160), interpolation=cv2.INTER_AREA)  # else it would be shrunk
    ours, course = overlay(frame, earth, whole), course_overlay(frame, earth, whole)
    inside, outside = away_from_rim(whole, frame.shape, 3)
    unlike = np.abs(ours[inside].astype(int) - course[inside])
    assert unlike.max() <= ROUNDING and unlike.mean() < 0.05
    np.testing.assert_array_equal(ours[outside], frame[outside])


@pytest.mark.parametrize('width, height', [(1200, 800), (1199, 803)])
def test_a_picture_larger_than_the_area_is_shrunk_without_a_shift(frame, random, width, height):
    """Fine grain becomes gray, as from a distance."""
    picture = np.full((height, width, 3), 40, np.uint8)
    picture[height // 2:, width // 2:] = 200
    grain = random.choice([-40, 40], picture.shape)
    inside, _ = away_from_rim(AREA, frame.shape, 3)
    ours, plain = (overlay(frame, image.astype(np.uint8), AREA) for image in (picture + grain, picture))
    assert ours[inside].astype(int).std() < 1.2 * plain[inside].std()
    assert np.abs(cv2.blur(ours, (9, 9)).astype(int) - cv2.blur(plain, (9, 9)))[inside].max() < 12
    course = course_overlay(frame, cv2.blur(picture, (3, 3)), AREA)
    assert abs(np.mean(plain[inside].astype(int) - course[inside])) < 0.05  # a shift by 0.1 px would be more


def test_the_picture_is_the_right_way_round(frame):
    quarters = np.zeros((200, 300, 3), np.uint8)
    colors = {(0, 0): (255, 0, 0), (0, 1): (0, 255, 0), (1, 1): (0, 0, 255), (1, 0): (255, 255, 255)}
    for (down, across), color in colors.items():
        quarters[100 * down:100 * down + 100, 150 * across:150 * across + 150] = color
    painted = overlay(frame, quarters, AREA)
    middle = AREA.corners.mean(axis=0)
    for corner, color in zip(AREA.corners, colors.values()):
        x, y = np.int32((corner * 2 + middle) / 3)
        assert tuple(painted[y, x]) == color


def test_the_frame_is_visible_through_a_transparent_picture(frame):
    glass = np.zeros((100, 100, 4), np.uint8)
    glass[:, 50:] = (0, 0, 255, 128)
    painted = overlay(frame, glass, AREA)
    np.testing.assert_array_equal(painted[240, 200], frame[240, 200])
    expected = frame[240, 420].astype(float) * 127 / 255 + np.array([0, 0, 255]) * 128 / 255
    np.testing.assert_allclose(painted[240, 420], expected, atol=2)


def test_hidden_colors_do_not_bleed_into_the_frame():
    gray = np.full((480, 640, 3), 200, np.uint8)
    disc = np.zeros((90, 90, 4), np.uint8)  # a disc of the frame's own color, surrounded by transparent black
    cv2.circle(disc, (45, 45), 30, (200, 200, 200, 255), -1)
    assert np.abs(overlay(gray, disc, AREA).astype(int) - 200).max() <= 2


def test_the_visible_part_of_an_area_is_painted(frame, earth):
    area = Area(AREA.corners + np.float32([-200, -150]))
    painted = overlay(frame, earth, area)
    full = overlay(cv2.copyMakeBorder(frame, 200, 0, 200, 0, cv2.BORDER_REPLICATE), earth,
                   Area(area.corners + 200))
    unlike = np.abs(painted.astype(int) - full[200:, 200:])
    assert unlike.max() <= ROUNDING and unlike.mean() < 0.05
    for lens in None, LENS:
        beyond = Area.from_undistorted(AREA.corners + np.float32([5000, 0]), lens=lens)
        np.testing.assert_array_equal(overlay(frame, earth, beyond), frame)


def test_no_function_changes_the_frame(frame, earth):
    before = frame.copy()
    tags = Detector().detect(frame)
    mark_tags(frame, tags)
    mark_centers(frame, [tag.center for tag in tags])
    fill_polygon(frame, AREA.corners)
    subtract(frame, area_mask(frame, AREA))
    overlay(frame, earth, AREA)
    np.testing.assert_array_equal(frame, before)


def test_painting_in_place_gives_the_same_result(frame, earth):
    painted, own = overlay(frame, earth, AREA), frame.copy()
    assert overlay(own, earth, AREA, out=own) is own
    np.testing.assert_array_equal(own, painted)
    other = np.zeros_like(frame)
    overlay(frame, earth, AREA, out=other)
    np.testing.assert_array_equal(other, painted)


@pytest.mark.parametrize('turn', np.arange(0, 360, 17))
def test_rim_pixels_are_covered_in_proportion(turn):
    """The expected share follows from each pixel's distance to each side of a rotated area."""
    angle = np.radians(turn)
    corners = np.float32([[-90, -70], [100, -50], [80, 60], [-70, 75]]) @ np.float32(
        [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) + np.float32([160.3, 140.6])
    y, x = np.mgrid[0:280, 0:320]
    cover = np.ones(x.shape)
    for start, end in zip(corners, np.roll(corners, -1, axis=0)):
        along = (end - start) / np.linalg.norm(end - start)
        cover = np.minimum(cover, along[0] * (y - start[1]) - along[1] * (x - start[0]) + 0.5)
    mask = area_mask(np.zeros((280, 320, 3), np.uint8), Area(corners))
    np.testing.assert_allclose(mask[..., 0], 255 * np.clip(cover, 0, 1), atol=1)
    white = np.full((64, 64, 3), 255, np.uint8)
    np.testing.assert_allclose(overlay(np.zeros_like(mask), white, Area(corners)), mask, atol=1)


def test_tags_are_marked_where_they_are(frame):
    tags = Detector().detect(frame)
    marked = mark_tags(frame, tags)
    for tag in tags:
        x, y = np.int32(np.round((tag.corners[1] + tag.corners[2]) / 2))
        assert marked[y, x].tolist() == [0, 255, 0]
        x, y = np.int32(np.round(tag.corners[0]))
        assert marked[y, x].tolist() == [0, 0, 255]


@pytest.mark.parametrize('count', [0, 1, 2])
def test_fewer_than_three_points_fill_nothing(frame, count):
    np.testing.assert_array_equal(fill_polygon(frame, AREA.corners[:count]), frame)


BENT_AREAS = {'in view': [[150.3, 100.8], [470.6, 130.1], [450.2, 380.7], [170.9, 350.4]],
              'partly out of view': [[-150.3, -80.8], [470.6, 130.1], [450.2, 380.7], [-170.9, 650.4]],
              'all around': [[-300, -300], [940, -300], [940, 780], [-300, 780]],
              'tiny': [[300.3, 200.8], [303.6, 201.1], [303.2, 205.7], [299.9, 204.4]]}


@pytest.mark.parametrize('name', BENT_AREAS)
def test_a_picture_is_bent_as_the_lens_bends_the_wall(earth, name):
    """The truth is painted without a lens into a larger frame. Then OpenCV distorts that frame."""
    corners, margin = np.float32(BENT_AREAS[name]), 400
    wide = np.zeros((480 + 2 * margin, 640 + 2 * margin, 3), np.uint8)
    smooth = cv2.GaussianBlur(earth, (0, 0), 8)
    truth = cv2.remap(overlay(wide, smooth, Area(corners + np.float32(margin))),
                      LENS.undistorted_pixels + np.float32(margin), None, cv2.INTER_LINEAR)
    painted = overlay(np.zeros((480, 640, 3), np.uint8), smooth, Area.from_undistorted(corners, lens=LENS))
    rim = cv2.morphologyEx(truth.max(axis=2), cv2.MORPH_GRADIENT, np.ones((5, 5))) > 60
    assert np.abs(painted.astype(int) - truth)[~rim].max() <= 2 * ROUNDING
    assert np.abs(painted.astype(int) - truth).mean() < 0.5


def test_the_rim_of_a_distorted_area_is_smooth():
    area = Area.from_undistorted(np.float32(BENT_AREAS['in view']), lens=LENS)
    mask = area_mask(np.zeros((480, 640, 3), np.uint8), area)[:, :, 0]
    fine = cv2.fillPoly(np.zeros((480 * 8, 640 * 8), np.uint8), [np.int32(area.outline() * 8 + 3.5)], 255)
    truth = cv2.resize(fine, (640, 480), interpolation=cv2.INTER_AREA)
    assert np.abs(mask.astype(int) - truth).max() < 60 and np.abs(mask.astype(int) - truth).mean() < 0.1


@pytest.mark.parametrize('fit', ['contain', 'cover'])
def test_a_picture_fits_into_a_distorted_area(earth, fit):
    area = Area.from_undistorted(np.float32(BENT_AREAS['in view']), 1.0, LENS)
    painted = overlay(np.zeros((480, 640, 3), np.uint8), np.full((200, 400, 3), 255, np.uint8), area, fit=fit)
    covered = np.count_nonzero(painted) / np.count_nonzero(area_mask(painted, area))
    assert abs(covered - (0.5 if fit == 'contain' else 1)) < 0.02


def test_the_sides_of_a_polygon_are_bent_by_the_lens():
    corners = LENS.distort(BENT_AREAS['in view'])
    image = fill_polygon(np.zeros((480, 640, 3), np.uint8), corners, (255, 255, 255), LENS)
    mask = area_mask(image, Area(np.float32(corners), lens=LENS)) > 128
    around = cv2.dilate(np.uint8(mask), np.ones((5, 5))) > cv2.erode(np.uint8(mask), np.ones((5, 5)))
    np.testing.assert_array_equal((image > 128)[~around], mask[~around])


@pytest.mark.parametrize('corners', [[[150, 100], [450, 102], [448, 325], [152, 323]],
                                     [[150, 50], [450, 180], [448, 230], [152, 400]]])
@pytest.mark.parametrize('channels', [3, 4])
def test_a_large_picture_with_fine_detail_does_not_shimmer(random, corners, channels):
    """Shimmer: how much the painted pixels change when the area moves by 0.3 px."""
    photo = cv2.resize(random.randint(0, 256, (750, 1000, 3)).astype(np.uint8), (2000, 1500))
    if channels == 4:
        photo = np.dstack([photo, np.full(photo.shape[:2], 255, np.uint8)])
    black, corners = np.zeros((480, 640, 3), np.uint8), np.float32(corners)
    inside, _ = away_from_rim(Area(corners), black.shape, 4)

    def shimmer(paint):
        return np.abs(paint(corners).astype(int) - paint(corners + np.float32(0.3)))[inside][:, :3].mean()

    def plain(corners):
        return cv2.warpPerspective(photo, Area(corners).homography(2000, 1500), (640, 480))
    ours = shimmer(lambda corners: overlay(black, photo, Area(corners)))
    assert ours < 0.35 * shimmer(plain)
    # It is not blurred more than necessary, either: a mean over each pixel's own square has as much contrast.
    large = cv2.warpPerspective(photo, Area(8 * corners + 3.5).homography(2000, 1500), (5120, 3840))
    square = cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA)
    assert overlay(black, photo, Area(corners))[inside].std() > 0.6 * square[inside][:, :3].std()


@pytest.mark.parametrize('corners, least_db', [
    ([[60, 40], [420, 40], [420, 300], [60, 300]], 31),      # head-on
    ([[200, 150], [290, 150], [290, 210], [200, 210]], 28),  # small
    ([[100, 30], [150, 110], [150, 220], [100, 320]], 28),   # slanted
    ([[180, 150], [300, 150], [440, 230], [40, 230]], 29),   # on the floor
    ([[240, 40], [380, 180], [240, 320], [100, 180]], 30)])  # on a corner
def test_fine_print_is_nearly_the_exact_mean_of_what_each_pixel_covers(corners, least_db):
    """OpenCV's warp, which takes one sample, is 12 to 16 dB worse."""
    page = text()
    area, black = Area(np.float32(corners)), np.zeros((360, 480, 3), np.uint8)
    inside, _ = away_from_rim(area, black.shape, 4)
    exact = exact_mean(page, area.homography(1200, 800), inside)
    error = ((overlay(black, page, area)[inside] - exact)**2).mean()
    assert 10 * np.log10(255**2 / error) > least_db


@pytest.mark.parametrize('channels', [3, 4])
def test_a_mixture_is_exact_to_one_level(channels):
    random = np.random.RandomState(0)
    window, mask = (random.randint(0, 256, (37, 131, 3)).astype(np.uint8) for _ in range(2))
    picture = random.randint(0, 256, (37, 131, channels)).astype(np.uint8)
    hidden, shown = visible(window, picture, mask, 0.6)
    cover = 0.6 * mask / 255 * (picture[..., 3:] / 255 if channels == 4 else 1)
    assert np.abs(hidden - window * cover).max() < 1.5
    assert np.abs(shown - picture[..., :3] * cover).max() < 1.5


def test_the_window_of_an_area_has_all_that_a_lens_bends_out_of_the_box_of_its_corners():
    corners = LENS.undistort(np.float32([[90, 60], [550, 60], [550, 420], [90, 420]]))
    area, frame = Area.from_undistorted(np.float32(corners), lens=LENS), np.zeros((480, 640, 3), np.uint8)
    window, part = area.window(frame)
    assert window.shape[0] > 380 and window.shape[1] > 470  # its sides bulge
    window[:] = area_mask(window, part)
    np.testing.assert_array_equal(frame, area_mask(frame, area))
