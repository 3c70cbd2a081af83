"""The tags vanish from what is painted."""
import os
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import Area, Tag
from aruco_ar.looks.hidden_tags import HiddenTags
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Pose, wall_to_camera
from rig import PACKAGE
from test_looks import BENT, FRAMES_PER_S, STRAIGHT, Drive, core, is_kept, painted, stage, with_sheet

pytestmark = pytest.mark.long
CLEAR = 0, 0, 0, 0  # a picture that cannot be seen, and so hides no part of the tags
ON_SHEET_PX = (175, 175), (625, 175), (625, 475), (175, 475)  # where tags are on a sheet
BOARD = os.path.join(PACKAGE, '..', 'shared', 'videos', 'board.mp4')


def tags_in(image):
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    ids = cv2.aruco.ArucoDetector(dictionary).detectMarkers(image)[1]
    return [] if ids is None else ids.ravel().tolist()


def without_tags(wall):
    """The same wall, whose tags are too small to be seen."""
    return replace(wall, tags=tuple(replace(tag, side=1e-4) for tag in wall.tags))


class Surroundings:
    """Where tags and their paper are."""

    def __init__(self, wall, camera=STRAIGHT):
        self._renderers = [WallRenderer(each, camera) for each in (without_tags(wall), wall)]

    def at(self, number):
        """(h, w) bool, in the frame of that number of a Drive."""
        view = wall_to_camera(Pose(-1.9, 0.1 + 0.004 * number, -0.05 - 0.001 * number))
        bare, with_tags = (renderer.render(*view) for renderer in self._renderers)
        return np.any(bare != with_tags, axis=2)


def decibels(image, truth, where):
    return 10 * np.log10(255**2 / np.mean((image[where].astype(float) - truth[where])**2))


@pytest.mark.parametrize('camera', [STRAIGHT, BENT])
@pytest.mark.parametrize('noise', [0.0, 3.0])
def test_where_the_tags_were_is_the_wall_as_it_would_be_without_them(wall, noise, camera):
    drive, hides = Drive(wall, camera, noise), stage(CLEAR, tags='hide')
    bare = Drive(without_tags(wall), camera, 0.0)
    lens = camera.lens if camera.lens.bends else None
    around = Surroundings(wall, camera)
    for number in range(20):
        frame, _ = drive.frame(number)
        truth, _ = bare.frame(number)
        image = painted(hides, frame, number, lens)
        assert len(tags_in(frame)) == 4 and tags_in(image) == []
        # The wall's plaster is random. Noise of 3 alone, which the truth has not, makes 38.6 dB.
        assert decibels(image, truth, around.at(number)) > (33.5 if noise else 35)


def test_without_the_setting_the_tags_stay(wall):
    frame, _ = Drive(wall).frame(0)
    assert len(tags_in(painted(stage(CLEAR), frame, 0))) == 4


def test_what_covers_a_tag_stays_in_front_and_hides_nothing_else(wall):
    drive, hides = Drive(wall), stage(CLEAR, tags='hide', foreground='keep')
    around = Surroundings(wall)
    for number in range(30):
        frame, _ = drive.frame(number)
        where = around.at(number)
        things = np.zeros(frame.shape[:2], bool)
        if number > FRAMES_PER_S:
            x, y = np.argwhere(where).min(axis=0)[::-1]
            cv2.circle(frame, (int(x) + 20 + number, int(y) - 20), 60, (40, 50, 160), -1)
            things = np.all(frame == (40, 50, 160), axis=2)
        image = painted(hides, frame, number)
        assert tags_in(image) == []
    assert things.any() and is_kept(image, frame, core(things)) > 0.97


def test_the_cover_takes_the_light_of_the_wall(wall):
    drive, bare, hides = Drive(wall), Drive(without_tags(wall)), stage(CLEAR, tags='hide')
    around = Surroundings(wall)
    for number in range(30):
        (frame, _), (truth, _) = drive.frame(number), bare.frame(number)
        factor = np.ones(frame.shape) if number < 10 else \
            np.linspace(1, 0.4, 640)[:, None] * (0.8, 0.9, 1.0) + np.zeros(frame.shape)
        frame, truth = (np.uint8(np.round(image * factor)) for image in (frame, truth))
        image = painted(hides, frame, number)
        assert decibels(image, truth, around.at(number)) > 33


def test_the_edge_of_a_shadow_goes_on_where_a_tag_was(wall):
    drive, bare, hides = Drive(wall), Drive(without_tags(wall)), stage(CLEAR, tags='hide')
    around = Surroundings(wall)
    for number in range(24):
        (frame, _), (truth, _) = drive.frame(number), bare.frame(number)
        shade = np.zeros(frame.shape[:2], np.float32)
        cv2.fillPoly(shade, [np.int32([[0, 0], [40 + 20 * number, 0], [20 * number, 480], [0, 480]])], 1)
        light = 1 - 0.45 * cv2.GaussianBlur(shade, (0, 0), 4)[..., None]
        frame, truth = (np.uint8(np.round(image * light)) for image in (frame, truth))
        assert decibels(painted(hides, frame, number), truth, around.at(number)) > 29


@pytest.fixture
def sheets(wall, tmp_path):
    """The wall with a white sheet, dark fields near its tags, and the same without the tags."""
    sheet = np.full((600, 800, 3), 244, np.uint8)  # as white as the paper of the tags
    for x, y in ON_SHEET_PX:
        cv2.rectangle(sheet, (x + 60, y - 70), (x + 130, y + 70), (40, 40, 40), -1)   # right beside the margin
        cv2.rectangle(sheet, (x - 130, y + 60), (x - 60, y + 130), (40, 40, 40), -1)  # at its corner
    cv2.imwrite(str(tmp_path / 'sheet.png'), sheet)
    printed = with_sheet(wall, tmp_path / 'sheet.png')
    return printed, without_tags(printed)


def test_under_a_tag_on_a_sheet_is_blank_paper_and_the_rest_stays_as_it_is(sheets):
    drive, bare, hides = Drive(sheets[0]), Drive(sheets[1]), stage(CLEAR, tags='hide')
    around = Surroundings(sheets[0])
    for number in range(12):
        (frame, _), (truth, _) = drive.frame(number), bare.frame(number)
        image, where = painted(hides, frame, number), around.at(number)
        assert decibels(image, truth, where) > 35
        farther = cv2.dilate(where.astype(np.uint8), np.ones((9, 9))) == 0
        assert np.array_equal(image[farther], frame[farther])


@pytest.mark.skipif(not os.path.isfile(BOARD), reason='the file board.mp4 is missing')
def test_on_a_real_board_blank_fields_are_where_the_tags_were():
    hides = stage(CLEAR, tags='hide', dictionary='DICT_5X5_100', ids=(6, 5, 47, 42))
    video = cv2.VideoCapture(BOARD)
    for number in range(10):
        frame = video.read()[1]
        sight, (image,) = hides.run(frame, number / FRAMES_PER_S, keeps_frame=True)
        for tag in sight.areas[0].tags:
            field = np.zeros(frame.shape[:2], np.uint8)
            cv2.fillConvexPoly(field, np.int32(np.round(tag.corners)), 1)
            rim = cv2.dilate(field, np.ones((15, 15))) - cv2.dilate(field, np.ones((11, 11)))
            paper = np.median(frame[rim > 0], axis=0)
            assert np.abs(image[field > 0] - paper).max() < 30  # the frame's black is darker by 130


def test_all_of_a_board_with_many_tags_vanish():
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    frame, tags = np.full((720, 960, 3), 210, np.uint8), []
    for tag_id, (y, x) in enumerate(np.argwhere(np.ones((8, 11))) * 80 + 40):
        frame[y:y + 48, x:x + 48] = cv2.aruco.generateImageMarker(dictionary, tag_id, 48)[..., None] * 0.8 + 6
        tags.append(Tag(tag_id, np.float32([[0, 0], [48, 0], [48, 48], [0, 48]]) + (x - 0.5, y - 0.5)))
    image = frame.copy()
    area = Area(np.float32([[60, 60], [900, 60], [900, 640], [60, 640]]))
    HiddenTags().hide(frame, image, area, tags, is_located=True, keep=True)
    assert len(tags_in(frame)) == len(tags) and np.all(image == 210)


def test_a_tag_that_is_out_of_sight_stays_hidden(wall):
    drive, hides = Drive(wall), stage(CLEAR, tags='hide')
    around = Surroundings(wall)
    for number in range(25):
        frame, _ = drive.frame(number)
        if number >= 15:  # a scratch over one tag, so that it is not found
            x, y = np.argwhere(around.at(number)).min(axis=0)[::-1]
            cv2.line(frame, (x, y), (x + 60, y + 60), (255, 255, 255), 12)
            assert len(tags_in(frame)) == 3
        image = painted(hides, frame, number)
    assert image[y:y + 60, x:x + 60].std(axis=(0, 1)).max() < 6


def test_a_tag_that_moves_by_itself_is_hidden_where_it_is(wall):
    drive, hides = Drive(wall), stage(CLEAR, tags='hide')
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    card = cv2.copyMakeBorder(cv2.aruco.generateImageMarker(dictionary, 40, 48), 8, 8, 8, 8,
                              cv2.BORDER_CONSTANT, value=255)
    for number in range(10):
        frame, _ = drive.frame(number)
        frame[180:244, 260 + 5 * number:324 + 5 * number] = card[..., None]
        image = painted(hides, frame, number)
        assert 40 in tags_in(frame) and tags_in(image) == []


def test_a_tag_on_colored_stripes_is_covered_with_their_colors():
    """No color of the ring is a usual one."""
    frame = np.empty((240, 320, 3), np.uint8)
    corners = np.float32([[135, 95], [185, 95], [185, 145], [135, 145]])
    for column in range(320):
        frame[:, column] = np.roll((200, 0, 0), column // 8 % 3)
    frame[95:145, 135:185] = 0
    image = frame.copy()
    area = Area(np.float32([[20, 20], [300, 20], [300, 220], [20, 220]]))
    HiddenTags().hide(frame, image, area, [Tag(1, corners)], True, False)
    assert image[100:140, 140:180].max(axis=2).mean() > 60
