"""The detector's searches: what each finds, what none mistakes for a tag, and the detector's limits."""
import os
from dataclasses import replace

import cv2
import numpy as np
import pytest
from aruco_ar import Detector, InputError, Tracker, draw_tag
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Path, Pose, wall_to_camera
from aruco_ar.tags.detector import SEARCHES
from aruco_ar.walls.wall import Poster
from benchmark.simulated.search import (
    CROWDS,
    CROWDS_DICTIONARY,
    FRAMES,
    PHOTOS,
    SAME_CORNER_PX,
    TAGS,
    apart,
    crowd,
    views,
)
from rig.accuracy.drives import WALL, drive


@pytest.mark.parametrize('name, least', list(zip(CROWDS, (12, 24))))
def test_the_thorough_search_finds_a_crowd(name, least):
    """It finds all corners of nearly all tags, though perhaps in another order than AprilTag.

    The truth lists the corners of each tag from where AprilTag's search for
    edges began. So the first is not the tag's own top left, and the corners are
    compared in the order that fits best.
    """
    if not os.path.isdir(PHOTOS):
        pytest.skip('the folder %s with photos is missing' % os.path.normpath(PHOTOS))
    photo, truth = crowd(name)
    tags = Detector(CROWDS_DICTIONARY, search='thorough').detect(photo)
    assert {tag.id for tag in tags} == {0}
    off = np.array([[apart(tag.corners, quad) for quad in truth] for tag in tags])
    assert np.sum(off.min(axis=0) < SAME_CORNER_PX) >= least
    # No tag is found twice. Some that AprilTag does not list are found.
    centers = np.array([tag.center for tag in tags])
    between = np.linalg.norm(centers[:, None] - centers, axis=2)[~np.eye(len(tags), dtype=bool)]
    assert between.min() > 5 and len(tags) <= len(truth) + 6


@pytest.mark.parametrize('width, slant', [(8, 0), (13, 60)])
def test_the_thorough_search_finds_far_and_slanted_tags_that_the_normal_one_misses(width, slant):
    found = dict.fromkeys(SEARCHES, 0)
    for frame, ids in views(width, slant):
        for search in SEARCHES:
            seen = {tag.id for tag in Detector(search=search).detect(frame)}
            assert seen <= set(ids)
            found[search] += len(seen)
    assert found['thorough'] >= 0.75 * FRAMES * TAGS
    assert found['thorough'] > found['normal'] + 3


@pytest.mark.parametrize('width, slant', [(9, 0), (15, 60)])
def test_both_searches_find_tags_that_are_a_little_nearer(width, slant):
    for search in ('normal', 'thorough'):
        seen = [({tag.id for tag in Detector(search=search).detect(frame)}, set(ids))
                for frame, ids in views(width, slant)]
        assert all(found <= ids for found, ids in seen)
        assert sum(len(found) for found, _ in seen) >= 0.85 * FRAMES * TAGS


@pytest.mark.parametrize('search', SEARCHES)
def test_near_tags_are_found_to_a_fraction_of_a_pixel(wall, search):
    for pose in Pose(-2.2, 0, 0), Pose(-1.9, 0.6, -0.3):
        view = wall_to_camera(pose)
        tags = Detector(search=search).detect(WallRenderer(wall, Camera(), noise=2.0).render(*view))
        truth = {tag.id: project(tag.corners, *view, Camera())[0] for tag in wall.tags}
        assert sorted(tag.id for tag in tags) == sorted(truth)
        for tag in tags:
            np.testing.assert_allclose(tag.corners, truth[tag.id], atol=0.5)


@pytest.mark.parametrize('search', SEARCHES)
def test_all_tags_with_one_id_are_found_once(search):
    frame = np.full((300, 560), 220, np.uint8)
    for place in range(4):
        frame[40:100, 40 + 130 * place:100 + 130 * place] = draw_tag('DICT_6X6_250', 5, 60)
    frame[150:270, 200:320] = draw_tag('DICT_6X6_250', 5, 120)
    tags = Detector(search=search).detect(frame)
    assert [tag.id for tag in tags] == [5] * 5
    centers = sorted(tuple(np.round(tag.center).astype(int)) for tag in tags)
    np.testing.assert_allclose(centers, [(70, 70), (200, 70), (260, 210), (330, 70), (460, 70)], atol=1)


@pytest.mark.parametrize('search', SEARCHES)
@pytest.mark.parametrize('size', [(1, 1), (1, 40), (3, 2), (61, 47)])
def test_a_frame_of_any_size_can_be_searched(search, size):
    assert Detector(search=search).detect(np.zeros(size + (3,), np.uint8)) == []
    assert Detector(search=search).detect(np.full(size, 255, np.uint8)) == []


def random_text(random):
    """A frame full of text, some of it on bars."""
    frame = np.full((480, 640), 220, np.uint8)
    for _ in range(60):
        x, y = (int(place) for place in random.randint((-20, 10), (600, 480)))
        if random.rand() < 0.3:
            cv2.rectangle(frame, (x, y + 5), (x + 60, y - 20), int(random.randint(256)), -1)
        cv2.putText(frame, ''.join(map(chr, random.randint(33, 127, 8))), (x, y), int(random.randint(5)),
                    random.uniform(0.3, 1.5), int(random.randint(256)), int(random.randint(1, 4)))
    return frame


def random_noise(random):
    """A frame of noise whose grains are a few pixels wide."""
    grain = random.randint(1, 7)
    noise = np.uint8(random.randint(0, 256, (480 // grain, 640 // grain)))
    how = random.choice([cv2.INTER_NEAREST, cv2.INTER_LINEAR])
    return cv2.resize(noise, (640, 480), interpolation=int(how))


def random_checkerboard(random):
    """A frame with a rotated checkerboard."""
    turn, side = random.uniform(-0.5, 0.5), random.uniform(4, 40)
    y, x = np.indices((480, 640))
    across, down = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    return cv2.GaussianBlur(np.uint8((across // side + down // side) % 2 * 200 + 30), (0, 0), 0.7)


def other_tags(random):
    """A frame with tags of other dictionaries."""
    frame = np.full((480, 640), 220, np.uint8)
    for y in range(10, 430, 60):
        for x in range(10, 590, 60):
            side, name = random.randint(16, 45), random.choice(['DICT_5X5_100', 'DICT_7X7_100'])
            frame[y:y + side, x:x + side] = draw_tag(name, random.randint(100), side)
    return cv2.GaussianBlur(frame, (0, 0), 0.6)


@pytest.mark.long
@pytest.mark.parametrize('paint', [random_text, random_noise, random_checkerboard, other_tags])
@pytest.mark.parametrize('dictionary', ['DICT_6X6_250', 'DICT_APRILTAG_36h11'])
def test_no_search_mistakes_anything_else_for_a_tag(random, paint, dictionary):
    for _ in range(4):
        frame = paint(random)
        for search in SEARCHES:
            assert Detector(dictionary, search=search).detect(frame) == []
        assert Detector(dictionary).search(frame, 12) == []


@pytest.mark.parametrize('search', SEARCHES)
def test_tags_below_the_smallest_side_are_ignored(search):
    frame = np.full((200, 400), 220, np.uint8)
    frame[60:120, 40:100] = draw_tag('DICT_6X6_250', 1, 60)
    frame[50:140, 200:290] = draw_tag('DICT_6X6_250', 2, 90)
    for least, ids in (0, [1, 2]), (58, [1, 2]), (62, [2]), (92, []):
        tags = Detector(search=search, min_side=least).detect(frame)
        assert sorted(tag.id for tag in tags) == ids


def damaged_tag(count):
    """A frame with tag 7, in which this many cells are wrong."""
    tag = draw_tag('DICT_6X6_250', 7, 120)
    for place in range(count):
        row, column = 15 * (2 + place % 4), 15 * (2 + place // 4)
        tag[row:row + 15, column:column + 15] ^= 255
    return cv2.copyMakeBorder(tag, 60, 60, 60, 60, cv2.BORDER_CONSTANT, value=255)


def test_the_thorough_search_finds_what_the_normal_one_finds(monkeypatch):
    """This does not depend on its own, finer reading."""
    tag = draw_tag('DICT_6X6_250', 7, 75, quiet=1)
    frame = cv2.GaussianBlur(cv2.copyMakeBorder(tag, 60, 60, 60, 60, cv2.BORDER_REPLICATE), (0, 0), 1)
    whole, = Detector(search='thorough').detect(frame)
    monkeypatch.setattr(Detector, '_reread', lambda *given: ([], np.empty((0, 4, 2), np.float32)))
    for search in 'normal', 'thorough':
        found, = Detector(search=search).detect(frame)
        np.testing.assert_allclose(found.corners, whole.corners, atol=0.1)


def test_small_tags_are_found_on_a_painting(package):
    """Tags of 16 px with margins of 0.4 cells. Blur joins them to the painting; sharpening separates them."""
    painting = Poster(package + '/images/earth.jpg', 0, 0.55, 1.5, 1.0)
    frames = list(drive(Path(Pose(-6.5, 0.1, -0.01), ((3, 0.1, 0.01),)), 6, noise=2.0, blur=0.7,
                        wall=replace(WALL, quiet=0.4, posters=(painting,))))
    def found_by(find):
        return sum(len({tag.id for tag in find(frame.image)} & set(WALL.area)) for frame in frames)
    assert found_by(Detector().detect) < found_by(lambda frame: Detector().search(frame, 12)) - 4
    assert found_by(Detector(search='thorough').detect) >= 4 * len(frames) - 1


@pytest.mark.parametrize('search', SEARCHES)
def test_wrong_cells_are_corrected_as_far_as_requested(search):
    """In this dictionary, up to five cells can be corrected."""
    for correction, corrected in (0, 0), (0.4, 2), (1, 5):
        detector = Detector(search=search, correction=correction, confidence=0)
        assert [tag.id for tag in detector.detect(damaged_tag(corrected))] == [7]
        assert detector.detect(damaged_tag(corrected + 1)) == []


@pytest.mark.parametrize('search', SEARCHES)
def test_a_tag_with_less_than_the_requested_confidence_is_ignored(search):
    whole, = Detector(search=search).detect(damaged_tag(0))
    damaged, = Detector(search=search).detect(damaged_tag(1))
    assert 0.2 < damaged.confidence < whole.confidence < 1
    between = (damaged.confidence + whole.confidence) / 2
    assert Detector(search=search, confidence=between).detect(damaged_tag(1)) == []
    assert len(Detector(search=search, confidence=between).detect(damaged_tag(0))) == 1


@pytest.mark.parametrize('wrong, sentence', [
    ({'search': 'slow'}, '^There is no search "slow"; choose one of fast, normal, thorough.$'),
    ({'search': None}, 'no search "None"'),
    ({'correction': 1.5}, '^The correction cannot be 1.5; give a number from 0 to 1.$'),
    ({'confidence': 'much'}, 'confidence cannot be much; give a number from 0 to 1'),
    ({'confidence': float('nan')}, 'confidence cannot be nan'),
    ({'min_side': -1}, '^The shortest side of tags cannot be -1; give pixels, 0 or more.$'),
])
def test_wrong_arguments_are_explained(wrong, sentence):
    for kind in Detector, Tracker:
        with pytest.raises(InputError, match=sentence):
            kind(**wrong)


def test_a_tracker_uses_the_requested_search(frame):
    assert {tag.id for tag in Detector().detect(frame)} == {1, 2, 3, 4}
    for search in SEARCHES:
        assert Tracker(search=search).update(frame, 0.0) is not None
    assert Tracker(min_side=500).update(frame, 0.0) is None
