"""Hostile pictures: some of each kind, and those that once gave wrong results."""
import pickle

import cv2
import numpy as np
import pytest
from aruco_ar import Detector, Lens, PoseEstimator, Tag, Tracker, draw_tag
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.geometry.plane_pose import rotation_matrices
from aruco_ar.tags import detector
from aruco_ar.tags.tag import square
from hostile.pictures.pipeline import Pipeline, watch
from hostile.pictures.scenes import NAMES, canvas_of, put, turned_square
from hostile.pictures.sequences import Picture
from rig.accuracy.poses import PINHOLE, pose_error

FACING = np.diag([1.0, -1, -1])


@pytest.mark.parametrize('kind', NAMES)
def test_a_hostile_picture_gives_no_wrong_results(kind):
    random = np.random.RandomState([3, NAMES.index(kind)])
    for _ in range(3):
        pipeline = Pipeline(random)
        canvas = canvas_of(kind, random, pipeline.dictionary, (200, 150))
        for stamp in range(3):
            assert pipeline.faults(Picture(kind, cv2.cvtColor(canvas, cv2.COLOR_GRAY2BGR), stamp / 30)) == []


def test_sequences_of_hostile_pictures_give_no_wrong_results():
    found = np.zeros(4, int)
    for number in range(12):
        for step, (kind, counts, _, faults) in enumerate(watch(1, number)):
            assert faults == [], 'picture %d (%s) of sequence %d' % (step, kind, number)
            found += counts
    assert found.min() > 0  # tags, areas, poses, poses of the camera


def test_a_sequence_that_once_gave_an_invalid_covariance():
    assert [sentence for *_, faults in watch(1, 4897) for sentence in faults] == []


def grid_of_tags(count, first=0, side=0.05):
    """Tags in rows on a wall that is seen at a slant."""
    rotation, rows = rotation_matrices(np.array([[np.pi - 0.3, 0.2, 0]]))[0], int(np.ceil(count**0.5))
    places = [np.array([(n % rows - rows / 2) * 0.1, (n // rows - rows / 2) * 0.08, 0]) for n in range(count)]
    return [Tag(first + number, np.float32(PINHOLE.project((square([side])[0] + place) @ rotation.T
                                                           + [0, 0, 0.3 + 0.12 * rows])))
            for number, place in enumerate(places)]


def test_ever_new_ids_do_not_fill_the_memory():
    """There are other tags every two seconds."""
    estimator, sizes = PoseEstimator(0.05), []
    for number in range(160):
        estimator.update(grid_of_tags(12, 12 * number), PINHOLE, 2.0 * number)
        sizes.append(len(pickle.dumps(estimator)))
    assert max(sizes) < 1.02 * max(sizes[:90])  # at most 1024 ids are remembered


def test_an_endless_wall_does_not_fill_the_memory():
    """The camera moves past a row of tags, and sees ten at a time. It forgets those passed long ago."""
    estimator, sizes = PoseEstimator(0.05), []
    rotation = rotation_matrices(np.array([[np.pi - 0.3, 0.2, 0]]))[0]
    for first in range(0, 160, 4):
        for number in range(4):
            tags = [Tag(tag_id, np.float32(PINHOLE.project(
                (square([0.05])[0] + [0.07 * (tag_id - first - 4.5), 0.04 * (tag_id % 2), 0]) @ rotation.T
                + [0, 0, 0.7]))) for tag_id in range(first, first + 10)]
            poses = estimator.update(tags, PINHOLE, (first + number) / 30)
        sizes.append(len(pickle.dumps(estimator)))
        assert len(poses) == 10 and len(estimator.camera().ids) >= 4
    assert max(sizes) < 1.1 * max(sizes[:28])  # the size with 100 tags


def test_among_very_many_tags_the_nearest_ones_locate_the_wall():
    estimator, crowd = PoseEstimator(0.05), grid_of_tags(100)
    for number in range(4):
        poses = estimator.update(crowd, PINHOLE, number / 30)
    assert [pose.id for pose in poses] == list(range(100))
    assert 4 <= len(estimator.camera().ids) <= 24


def test_if_there_are_too_many_candidates_the_largest_tags_are_read(monkeypatch):
    monkeypatch.setattr(detector, 'MAX_READ', 12)  # each tag has some, since it is found by several windows
    frame = np.full((120, 560), 220, np.uint8)
    for number, side in enumerate((30, 60, 40, 80, 50)):
        frame[20:20 + side, 20 + 110 * number:20 + 110 * number + side] = draw_tag('DICT_6X6_250', number, side)
    found = {tag.id for tag in Detector().detect(frame)}
    assert 1 < len(found) < 5 and found == set([3, 1, 4, 2, 0][:len(found)])


def test_the_area_survives_a_jerk_in_which_most_other_tags_move():
    random, canvas = np.random.RandomState(1), np.full((300, 400), 220, np.uint8)
    corners = [(40, 40), (360, 40), (360, 260), (40, 260)]
    for number, place in enumerate(corners):
        put(canvas, 'DICT_4X4_50', number, turned_square(random, place, 36, 0.0))
    inner = [(x, y) for y in (110, 150, 190) for x in range(90, 330, 38)]

    def seen(shift, places):
        image = canvas.copy()
        for number, place in enumerate(places):
            put(image, 'DICT_4X4_50', 10 + number, turned_square(random, place, 24, 0.0))
        return cv2.warpAffine(image, np.float32([[1, 0, shift], [0, 1, 0]]), (400, 300), borderValue=220)
    tracker = Tracker('DICT_4X4_50')
    for number in range(4):
        before = tracker.update(seen(0, inner), number / 30)
    after = tracker.update(seen(12, [(x + 5, y + 3) for x, y in inner[::-1]]), 4 / 30)
    np.testing.assert_allclose(after.corners, before.corners + [12, 0], atol=1.0)


def test_every_tag_found_in_noise_is_a_quadrilateral():
    for seed in range(12):
        noise = np.random.RandomState(seed).randint(0, 256, (40, 53)).astype(np.uint8)
        frame = cv2.resize(noise, (160, 120), interpolation=cv2.INTER_LINEAR)
        for tag in Detector('DICT_4X4_50', confidence=0).detect(frame):
            assert is_quadrilateral(tag.corners)


@pytest.mark.parametrize('seed', range(8))
def test_an_impossible_lens_raises_no_error(seed):
    distortion = np.random.RandomState(seed).normal(0, 1, 14) * 10**seed
    with np.errstate(divide='raise', invalid='raise', over='raise'):
        rays = Lens(320, 240, np.diag([288.0, 288, 1]), distortion).rays([[0, 0], [160, 120], [310, 0]])
    assert rays.shape == (3, 2)


def test_a_covariance_of_very_small_and_large_numbers_is_valid():
    """The tags are a few millimeters apart, and seen through a telescope."""
    matrix = np.array([[14000.0, 0, 160], [0, 14000, 120], [0, 0, 1]])
    random, lens = np.random.RandomState(3), Lens(320, 240, matrix, np.zeros(0))
    places = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.0015
    for _ in range(25):
        rotation = rotation_matrices(random.normal(0, 0.4, (1, 3)) + [np.pi, 0, 0])[0]
        estimator = PoseEstimator(0.001)
        far = 0.36 * random.uniform(0.5, 2)
        for number in range(4):
            tags = [Tag(tag_id, lens.project((square([0.001])[0] + place) @ rotation.T + [0, 0, far])
                        + random.normal(0, 0.05, (4, 2))) for tag_id, place in enumerate(places)]
            estimator.update(tags, lens, number / 30)
        if estimator.camera():
            spread = estimator.camera().covariance
            np.testing.assert_allclose(spread, spread.T, rtol=0, atol=1e-9 * np.abs(spread).max())


@pytest.mark.parametrize('slant', [0.2, 0.375, 0.5, 0.8])
def test_a_tag_that_leans_exactly_about_its_own_edge_has_a_pose(slant):
    for turn in np.arange(0, 6.28, 0.25):
        lean = rotation_matrices(np.array([[slant * np.cos(turn), slant * np.sin(turn), 0]]))[0]
        truth = lean @ rotation_matrices(np.array([[0, 0, turn]]))[0] @ FACING, np.array([0, 0, 0.5])
        tag = Tag(1, PINHOLE.project(square([0.18])[0] @ truth[0].T + truth[1]))
        pose, = PoseEstimator(0.18).update([tag], PINHOLE, 0.0)
        assert pose_error(pose, truth)[0] < 1e-4 and pose_error(pose, truth)[1] < 0.01
