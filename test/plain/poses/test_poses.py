"""Poses of tags compared with the truth: accuracy, flips, covariances, and odd input."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector, InputError, Lens, PoseEstimator, Tag
from aruco_ar.geometry.plane_pose import rotation_matrices, rotation_vector
from aruco_ar.poses.belief import Belief, mixture
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from benchmark.simulated.poses import ALONE, FLIP, Others, past
from rig.accuracy.drives import LIVELY
from rig.accuracy.poses import (
    AREA,
    BENT,
    PINHOLE,
    SIDE,
    TAGS_WALL,
    camera_pose,
    drive,
    error_of,
    lens_of,
    nees,
    pose_error,
    tag_at,
    true_pose,
)


@pytest.mark.parametrize('camera', [pytest.param(Camera(), id='pinhole'),
                                    pytest.param(BENT, id='lens', marks=pytest.mark.long)])
@pytest.mark.parametrize('meters, place, turn', [(1, 0.003, 0.5), (3, 0.06, 2.0)])
@pytest.mark.parametrize('ids', [[ALONE], AREA], ids=['one tag', 'four tags'])
def test_poses_of_the_simulated_wall_are_accurate(camera, meters, place, turn, ids):
    renderer, detector = WallRenderer(TAGS_WALL, camera, noise=2.0), Detector(ids=ids)
    estimator, errors, nees_values = PoseEstimator(SIDE), [], []
    for number, view in enumerate(past(meters, 40)):
        tags = detector.detect(renderer.render(*view))
        for pose in estimator.update(tags, lens_of(camera), number / 30):
            truth = true_pose(next(tag for tag in TAGS_WALL.tags if tag.id == pose.id), *view)
            if pose.id == ALONE:
                errors.append(pose_error(pose, truth))
            nees_values.append(nees(pose, truth))
    assert len(errors) > 20
    assert np.max(errors, axis=0)[0] < place
    assert np.max(errors, axis=0)[1] < turn
    assert np.mean(nees_values) < 9


def test_ignoring_the_distortion_would_give_wrong_poses():
    view = wall_to_camera(Pose(-1.2, 0.2, 0))
    tags = Detector().detect(WallRenderer(TAGS_WALL, BENT, noise=2.0).render(*view))
    truth = {tag.id: true_pose(tag, *view) for tag in TAGS_WALL.tags}
    assert tags

    def worst(lens):
        return max(pose_error(pose, truth[pose.id])[0] for pose in PoseEstimator(SIDE).update(tags, lens, 0.0))
    assert worst(lens_of(BENT)) < 0.003
    assert worst(PINHOLE) > 0.02


@pytest.mark.long
def test_a_lone_tag_does_not_flip_unlike_with_other_solvers():
    camera = Camera()
    renderer, others, detector = WallRenderer(TAGS_WALL, camera, noise=2.0, seed=3), Others(), Detector()
    estimator, ours, theirs = PoseEstimator(SIDE), [], []
    tag = next(tag for tag in TAGS_WALL.tags if tag.id == ALONE)
    for number, view in enumerate(past(4.0, 300)):
        frame, truth = renderer.render(*view), true_pose(tag, *view)
        tags = [tag for tag in detector.detect(frame) if tag.id == ALONE]
        ours += [pose_error(pose, truth)[1] for pose in estimator.update(tags, PINHOLE, number / 30)]
        found = others.poses(frame, PINHOLE)['IPPE_SQUARE'].get(ALONE)
        if found:
            theirs.append(np.degrees(np.linalg.norm(error_of(*found, truth)[3:])))
    assert len(ours) >= 299
    assert np.sum(np.array(theirs) > FLIP) >= 5
    assert max(ours) < FLIP


def test_a_tracked_tag_does_not_flip_unlike_in_single_frames(random):
    """The corners are ten times less accurate than usual."""
    def flips(fresh):
        estimator, found = PoseEstimator(SIDE), []
        for number in range(240):
            angle = np.radians(25 + 10 * np.sin(number / 40))
            view = wall_to_camera(Pose(-3 * np.cos(angle), 0.45 + 3 * np.sin(angle), -angle))
            truth = true_pose(TAGS_WALL.tags[3], *view)
            if fresh:
                estimator.reset()
            pose, = estimator.update([tag_at(4, truth, random, noise=0.3)], PINHOLE, number / 30)
            found.append((pose_error(pose, truth)[1] > 25, pose.ambiguity, nees(pose, truth)))
        return np.array(found[30:])
    single, followed = flips(True), flips(False)
    assert single[:, 0].sum() >= 3
    assert followed[:, 0].sum() == 0


@pytest.mark.parametrize('ids', [[4], [1, 2], AREA], ids=str)
@pytest.mark.parametrize('wall', [None, TAGS_WALL], ids=['learned', 'given'])
@pytest.mark.parametrize('noise', [0.03, 0.2])
def test_covariances_match_the_errors(ids, wall, noise, random):
    nees_values, cameras = [], []
    for trial in range(3):
        for number, (poses, truths, view, camera) in enumerate(drive(
                PoseEstimator(SIDE, wall=wall), random, ids=ids, count=50, first=100 * trial, noise=noise)):
            if number >= 10:  # by then the accuracy of the corners is learned
                nees_values += [nees(pose, truth) for pose, truth in zip(poses, truths)]
                if camera and wall and noise < 0.1:  # more noise makes turns too large for a linear model
                    cameras.append(nees(camera, camera_pose(view)))
    assert 2 < np.mean(nees_values) < 9
    assert not cameras or 2 < np.mean(cameras) < 9


def test_an_ambiguous_pose_is_marked_as_such(random):
    """The tag is far away, and nearly seen straight on, so it could lean to either side."""
    truth = rotation_matrices(np.array([[np.pi + 0.25, 0, 0]]))[0], np.array([0.1, 0, 7.0])
    pose, = PoseEstimator(SIDE).update([tag_at(1, truth, random, noise=0)], PINHOLE, 0.0)
    near, = PoseEstimator(SIDE).update([tag_at(1, (truth[0], truth[1] / 7), random, noise=0)], PINHOLE, 0.0)
    assert 0.05 < pose.ambiguity <= 0.5
    assert np.degrees(np.sqrt(np.trace(pose.covariance[3:, 3:]))) > 10
    assert near.ambiguity < 1e-6
    assert np.degrees(np.sqrt(np.trace(near.covariance[3:, 3:]))) < 1


def test_each_tag_may_have_its_own_size(random):
    truth = rotation_matrices(np.array([[np.pi - 0.3, 0.2, 0]]))[0], np.array([0.1, 0, 1.5])
    tags = [tag_at(1, truth, random, size=0.1), tag_at(2, truth, random, size=0.3)]
    for pose, size in zip(PoseEstimator(0.1, sizes={2: 0.3}).update(tags, PINHOLE, 0.0), (0.1, 0.3)):
        assert pose.size == size
        assert pose_error(pose, truth)[0] < 0.005
    assert PoseEstimator(0.2).update(tags, PINHOLE, 0.0)[0].translation[2] == pytest.approx(3.0, rel=0.01)


@pytest.mark.parametrize('lens', [
    Lens(640, 480, Camera().matrix, np.array([0.1, 0.02, -0.01, 0.003]), fisheye=True),
    Lens(640, 480, Camera().matrix, np.array([0.5, -0.2, 0.001, -0.001, 0.01, 0.8, -0.1, 0.02]))],
    ids=['fisheye', 'rational'])
def test_other_lens_models_are_supported(lens, random):
    truth = rotation_matrices(np.array([[np.pi - 0.3, 0.2, 0]]))[0], np.array([0.3, -0.2, 1.5])
    pose, = PoseEstimator(SIDE).update([tag_at(1, truth, random, lens, noise=0)], lens, 0.0)
    assert pose_error(pose, truth)[0] < 0.005  # the correction of bulging edges adds an error here
    assert pose_error(pose, truth)[1] < 0.5


@pytest.mark.parametrize('corners', [
    np.zeros((4, 2)), [[10, 10], [20, 20], [30, 30], [40, 40]], [[10, 10], [60, 10], [60, 10], [10, 60]],
    [[10, 10], [np.nan, 10], [60, 60], [10, 60]], [[10, 10], [np.inf, 10], [60, 60], [10, 60]],
    [[10, 10], [10, 60], [60, 60], [60, 10]], [[10, 10], [60, 60], [60, 10], [10, 60]],
    [[1e9, 0], [2e9, 0], [2e9, 1e9], [1e9, 1e9]]], ids=str)
@pytest.mark.parametrize('lens', [PINHOLE, lens_of(BENT)], ids=['pinhole', 'lens'])
def test_impossible_tags_are_left_out(corners, lens, random):
    view = wall_to_camera(Pose(-2, 0, 0))
    good = tag_at(4, true_pose(TAGS_WALL.tags[3], *view), random, lens)
    with np.errstate(divide='raise', invalid='raise', over='raise'):
        poses = PoseEstimator(SIDE).update([Tag(1, np.float64(corners)), good], lens, 0.0)
    assert poses[-1].id == 4
    for pose in poses:
        assert all(np.isfinite(part).all() for part in (pose.rotation, pose.translation, pose.covariance))


def test_random_corners_give_valid_poses(random):
    estimator = PoseEstimator(SIDE)
    for number in range(150):
        tags = [Tag(tag_id, random.uniform(0, 640, (4, 2)) if tag_id % 2 else
                    cv2.boxPoints(((300, 200), tuple(random.uniform(1, 90, 2)), random.uniform(0, 90))))
                for tag_id in range(6)]
        for pose in estimator.update(tags, PINHOLE, number / 30):
            assert np.isfinite(pose.translation).all() and pose.translation[2] > 0
            assert np.isfinite(pose.covariance).all() and np.linalg.eigvalsh(pose.covariance).min() > 0
            assert 0 <= pose.ambiguity <= 0.5


@pytest.mark.parametrize('change', ['reset', 'time goes back'])
def test_everything_is_forgotten(change, random):
    estimator = PoseEstimator(SIDE)
    list(drive(estimator, random, count=10, first=10))
    assert estimator.camera()
    if change == 'reset':
        estimator.reset()
        assert estimator.camera() is None
    list(drive(estimator, random, count=1))
    assert estimator.camera() is None


def test_frames_with_the_same_stamp_are_accepted(random):
    estimator = PoseEstimator(SIDE)
    for number in range(10):
        view = wall_to_camera(LIVELY.at(number / 30)[0])
        tags = [tag_at(tag.id, true_pose(tag, *view), random) for tag in TAGS_WALL.tags]
        estimator.update(tags, PINHOLE, 7.0)
    assert set(estimator.camera().ids) == set(AREA)


@pytest.mark.parametrize('noise', [0, 1e-6, 0.0005, 0.05])
def test_a_tag_right_in_front_has_its_pose(noise, random):
    # OpenCV's solvePnPGeneric gives wrong poses for some of these corners.
    for number in range(1000):
        side = random.uniform(10, 90)
        corners = random.uniform(50, 500, 2) + side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        pose, = PoseEstimator(SIDE).update([Tag(1, corners + random.normal(0, noise, (4, 2)))], PINHOLE, number)
        assert pose.translation[2] == pytest.approx(SIDE * PINHOLE.matrix[0, 0] / side, rel=0.5 * noise + 1e-3)


@pytest.mark.parametrize('angle', [0.3, 3.1])
def test_a_covariance_allows_for_the_other_pose(angle):
    leap = np.float64([0.1, -0.2, 0.3, *(angle * np.float64([2, -1, 2]) / 3)])
    one = np.eye(3)[None], np.float64([[0, 0, 1]]), 0.01 * np.eye(6)[None]
    other = rotation_matrices(leap[None, 3:]), one[1] + leap[:3], 0.02 * np.eye(6)[None]
    covariance, weight = mixture(one, other, np.array([0.25]))
    assert weight == 0.25
    assert np.allclose(covariance[0], 0.0125 * np.eye(6) + 0.25 * np.outer(leap, leap))


def test_two_poses_that_cannot_be_told_apart_are_one():
    one = np.eye(3)[None], np.float64([[0, 0, 1]]), 0.01 * np.eye(6)[None]
    other = rotation_matrices(np.float64([[0.03, 0, 0]])), one[1], 0.02 * np.eye(6)[None]
    covariance, weight = mixture(one, other, np.array([0.5]))
    assert weight == 0
    assert np.array_equal(covariance, one[2])


@pytest.mark.parametrize('value', [0, 0.0009, 10.1, -1, np.nan, np.inf, 'big', None])
def test_an_impossible_tag_size_is_refused(value):
    with pytest.raises(InputError, match='size of a tag .*0.001 to 10'):
        PoseEstimator(value)
    with pytest.raises(InputError, match='size of tag 5 .*0.001 to 10'):
        PoseEstimator(sizes={5: value})


def test_rotation_vectors_survive_a_round_trip(random):
    for angles in random.normal(0, 1, (20, 3)):
        rotation = rotation_matrices(angles[None])[0]
        np.testing.assert_allclose(rotation, cv2.Rodrigues(angles)[0], atol=1e-12)
        np.testing.assert_allclose(rotation_matrices(rotation_vector(rotation)[None])[0], rotation, atol=1e-9)


def test_evidence_accumulates_over_frames_and_is_forgotten_after_a_gap():
    """Each frame slightly favors the first pose; the last one favors neither."""
    rotations = rotation_matrices(np.array([[np.pi + 0.3, 0, 0], [np.pi - 0.3, 0, 0]]))
    poses = rotations[None], np.array([[[0, 0, 3.0], [0, 0, 3.0]]]), np.eye(6)[None, None].repeat(2, 1) * 1e-4
    belief, evidence = Belief(), np.array([[0.0, 4.0]])
    first = belief.weigh(['tag'], poses, evidence, 0.0)[1]
    for number in range(1, 6):
        belief.weigh(['tag'], poses, evidence, number / 30)
    believed, later = belief.weigh(['tag'], poses, np.zeros((1, 2)), 6 / 30)
    assert believed == [0] and later < first / 10
    assert belief.weigh(['tag'], poses, np.zeros((1, 2)), 6 / 30 + 0.6)[1] == [0.5]
