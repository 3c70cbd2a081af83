"""Which tags are taken for tags on a wall: none on a box in front of it, but all of a long wall."""
import numpy as np
import pytest
from aruco_ar import Lens, PoseEstimator
from aruco_ar.geometry.plane_pose import rotation_matrices
from aruco_ar.simulation.robot import Pose, wall_to_camera
from rig.accuracy.poses import PINHOLE, nees, pose_error, tag_at

pytestmark = pytest.mark.long
SIDE = 0.1  # meters, of the tags
LARGE = Lens(1920, 1080, np.array([[1200, 0, 959.5], [0, 1200, 539.5], [0, 0, 1.0]]), np.zeros(5))
BOX = 0.05  # meters
MAX_NEES = 60.0  # of the NEES: only a wrong pose with a too small covariance has more
SPACED = {1: (-0.2, 0, 0), 2: (0.2, 0, 0), 3: (0, 0.3, 0)}
FACING = np.diag([1.0, -1.0, -1.0])  # the rotation of a camera that faces the wall


def estimate(estimator, places, place, turn, number, random, lens=LARGE, bias=None):
    """Let the camera see the tags; returns the poses, the true poses and the camera's (R, t) on the wall.

    ``places``: {id: center on the wall}. ``place``: that of the camera.
    """
    rotation = rotation_matrices(np.array([[0, turn, 0]]))[0] @ FACING
    truth, tags = {}, []
    for tag_id, center in places.items():
        pose = rotation, rotation @ (np.array(center) - place)
        tag = tag_at(tag_id, pose, random, lens, SIDE)
        if bias is not None:
            tag.corners[:] += bias[tag_id]
        if (tag.corners > 2).all() and (tag.corners < [lens.width - 2, lens.height - 2]).all():
            truth[tag_id] = pose
            tags.append(tag)
    poses = estimator.update(tags, lens, number / 30)
    return poses, [truth[pose.id] for pose in poses], (rotation.T, np.array(place))


def approach(estimator, places, random, count=160):
    """Yields what ``estimate`` returns, for a drive from 4.5 m to 1.2 m."""
    for number in range(count):
        part = number / count
        place = [-0.3 + 0.5 * np.sin(4 * part), 0.05, 4.5 - 3.3 * part]
        yield estimate(estimator, places, place, 0.05 * np.sin(10 * part), number, random)


@pytest.mark.parametrize('ids', [(1, 2), (1, 2, 3)], ids=str)
@pytest.mark.parametrize('box', [1, 2])
def test_a_tag_on_a_box_is_not_on_the_wall(ids, box, random):
    places = {tag_id: np.add(SPACED[tag_id], [0, 0, BOX * (tag_id == box)]) for tag_id in ids}
    estimator, cameras, nees_values, last = PoseEstimator(SIDE), [], [], None
    for poses, truths, (rotation, place) in approach(estimator, places, random):
        nees_values += [nees(pose, truth) for pose, truth in zip(poses, truths)]
        last = estimator.camera()
        if last:
            first = min(set(ids) - {box})  # the wall has the axes of this tag
            cameras.append(nees(last, (rotation, place - places[first])))
    assert max(nees_values) < MAX_NEES
    if len(ids) == 2:
        assert not cameras  # nothing shows which of the two is on the wall
    else:
        assert len(cameras) > 80 and max(cameras) < MAX_NEES
        assert set(last.ids) == set(ids) - {box}


def test_a_tag_on_a_thin_box_is_dropped_from_the_wall_when_the_camera_comes_near(random):
    places = {**SPACED, 2: np.add(SPACED[2], [0, 0, 0.4 * BOX])}
    estimator, learned = PoseEstimator(SIDE), []
    for _, _, (rotation, place) in approach(estimator, places, random):
        camera = estimator.camera()
        if camera:
            learned.append(camera.ids)
            if place[2] < 1.65:
                assert camera.ids == (1, 3)
                assert nees(camera, (rotation, place - places[1])) < MAX_NEES
    assert (1, 2, 3) in learned and learned[-1] == (1, 3)


@pytest.mark.parametrize('meters', [1.2, 2.5])
@pytest.mark.parametrize('moves', [0, 1], ids=['standing', 'moving'])
def test_a_flat_wall_stays_learned(meters, moves, random):
    """The errors of the corners are the same in all frames."""
    ids = range(1, 13)
    places = {tag_id: (0.25 * (tag_id % 4) - 0.375, 0.25 * (tag_id // 4) - 0.375, 0) for tag_id in ids}
    for _ in range(2):
        bias = {tag_id: random.normal(0, 0.03, (4, 2)) for tag_id in ids}
        estimator, found = PoseEstimator(SIDE), []
        for number in range(45):
            place = [0.2 * moves * np.sin(number / 15), 0, meters]
            estimate(estimator, places, place, 0.1, number, random, bias=bias)
            found.append(estimator.camera())
        assert all(camera and len(camera.ids) >= 10 for camera in found[10:])


def test_the_simulated_wall_is_learned_at_once(wall, random):
    for meters in (2.0, 3.0):
        estimator = PoseEstimator(wall.tags[0].side)
        for number in range(6):
            rotation, translation = wall_to_camera(Pose(-meters, 0.1, 0.02 * number))
            estimator.update([tag_at(tag.id, (rotation, rotation @ [tag.x, tag.y, 0] + translation), random,
                                     size=tag.side) for tag in wall.tags], PINHOLE, number / 30)
        assert set(estimator.camera().ids) == {tag.id for tag in wall.tags}


def test_the_wall_does_not_drift_while_its_first_tag_is_out_of_sight(random):
    places = {1: (0, 0, 0), 2: (1.2, 0.1, 0), 3: (1.6, -0.1, 0), 4: (2.0, 0, 0)}
    estimator = PoseEstimator(SIDE)
    for number in range(400):
        ids = places if number < 60 else (2, 3, 4)
        x = 0.9 if number < 60 else 1.5 + 0.4 * np.sin((number - 60) / 40)
        place = [x, 0.1 * np.sin(number / 37), 1.5]
        _, _, truth = estimate(estimator, {tag_id: places[tag_id] for tag_id in ids}, place,
                           0.1 * np.sin(number / 25), number, random)
        if number > 60:
            assert pose_error(estimator.camera(), truth)[0] < 0.015
            assert nees(estimator.camera(), truth) < MAX_NEES


def test_a_long_wall_is_learned_while_driving_past(random):
    places = {tag_id: (0.25 * tag_id, 0, 0) for tag_id in range(20)}
    estimator = PoseEstimator(SIDE)
    for number in range(230):
        _, _, truth = estimate(estimator, places, [0.02 * number, 0, 0.6], 0.0, number, random)
        if number >= 5:
            assert nees(estimator.camera(), truth) < MAX_NEES
    assert 19 in estimator.camera().ids
