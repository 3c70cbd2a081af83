"""Poses of tags that share a wall, of the area and of the camera; and walls that change."""
from dataclasses import replace

import numpy as np
import pytest
from aruco_ar import Area, CameraPose, PoseEstimator, Tag
from aruco_ar.geometry.plane_pose import rotation_matrices
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.walls.wall import WallTag
from rig.accuracy.poses import (
    AREA,
    PINHOLE,
    SIDE,
    TAGS_WALL,
    camera_pose,
    drive,
    nees,
    on_wall,
    pose_error,
    tag_at,
    true_pose,
)


def test_several_tags_on_a_wall_improve_each_others_poses(random):
    def typical(ids):
        return np.median([pose_error(poses[0], truths[0])[1] for poses, truths, _, _ in
                          drive(PoseEstimator(SIDE), random, ids=ids, noise=0.2)][10:])
    assert typical(AREA) < 0.4 * typical([1])


def test_a_learned_wall_gives_the_same_poses_as_a_given_one(random):
    learned, given, errors = PoseEstimator(SIDE), PoseEstimator(SIDE, wall=TAGS_WALL), []
    for poses, _, view, camera in drive(learned, random):
        given.update([Tag(pose.id, pose.corners) for pose in poses], PINHOLE, 0.0)
        if camera:
            assert set(camera.ids) == set(AREA)
            first = on_wall(1)[1]  # the learned wall has the axes of this tag
            rotation, place = camera_pose(view)
            errors.append(pose_error(camera, (rotation, place - first))
                          + pose_error(given.camera(), (rotation, place)))
    assert len(errors) > 50
    assert np.max(errors[5:], axis=0)[0] < 0.01 and np.max(errors[5:], axis=0)[1] < 0.3
    assert np.max(errors[5:], axis=0)[2] < 0.005 and np.max(errors[5:], axis=0)[3] < 0.15


def test_a_given_wall_locates_the_camera_by_one_tag_in_the_first_frame(random):
    turned_tag = replace(TAGS_WALL, tags=(WallTag(7, 0.3, 0.6, 0.3, 30.0),) + TAGS_WALL.tags)
    estimator, view = PoseEstimator(wall=turned_tag), wall_to_camera(Pose(-1.5, 0.3, -0.2))
    pose, = estimator.update([tag_at(7, true_pose(turned_tag.tags[0], *view), random, size=0.3)], PINHOLE, 0.0)
    assert pose.size == 0.3
    assert estimator.camera().ids == (7,)
    assert pose_error(estimator.camera(), camera_pose(view))[0] < 0.01


@pytest.mark.parametrize('shift, turn', [
    ((0, 0, 0.05), (0, 0, 0)), ((0, 0, 0), (0, 0.3, 0)), ((0, 0, 0.2), (0.5, 0, 0))])
def test_a_tag_off_the_plane_of_the_wall_keeps_its_own_pose(shift, turn, random):
    moved = {3: on_wall(3, shift, turn)}
    estimator = PoseEstimator(SIDE)
    for poses, truths, _, _ in drive(estimator, random, lambda number: moved):
        for pose, truth in zip(poses, truths):
            assert pose_error(pose, truth)[0] < 0.01 and pose_error(pose, truth)[1] < 2
    assert set(estimator.camera().ids) == {1, 2, 4}


@pytest.mark.parametrize('moved', [1, 3])
@pytest.mark.parametrize('wall', [None, TAGS_WALL], ids=['learned', 'given'])
def test_a_moved_tag_is_dropped_from_the_wall_until_it_is_learned_again(moved, wall, random):
    estimator, at = PoseEstimator(SIDE, wall=wall), 40
    for number, (poses, truths, _, camera) in enumerate(drive(
            estimator, random, lambda number: {moved: on_wall(moved, (0.05, 0, 0))} if number >= at else {},
            count=80)):
        for pose, truth in zip(poses, truths):
            assert pose_error(pose, truth)[0] < 0.01 and pose_error(pose, truth)[1] < 2
        if at <= number < at + 15:
            assert set(camera.ids) == set(AREA) - {moved}
    assert set(camera.ids) == set(AREA)


def test_a_wall_whose_tags_are_all_rearranged_is_learned_again(random):
    def places(number):
        moved = AREA if number >= 30 else []
        return {tag_id: on_wall(tag_id, (0.05 * tag_id, -0.03 * tag_id**2, 0)) for tag_id in moved}
    cameras = []
    for poses, truths, _, camera in drive(PoseEstimator(SIDE), random, places, count=60):
        cameras.append(camera)
        assert max(pose_error(pose, truth)[0] for pose, truth in zip(poses, truths)) < 0.01
    assert not any(cameras[30:45]) and all(cameras[-10:])


def test_if_two_tags_contradict_each_other_the_one_that_moved_is_dropped(random):
    for number, (_, _, _, camera) in enumerate(drive(
            PoseEstimator(SIDE), random, lambda number: {1: on_wall(1, (0.08, 0, 0))} if number >= 30 else {},
            ids=[1, 2], count=40)):
        if number >= 30:
            assert camera.ids == (2,)


def test_more_tags_join_the_wall_and_may_come_and_go(random):
    estimator = PoseEstimator(SIDE)
    list(drive(estimator, random, ids=[1, 2], count=20))
    list(drive(estimator, random, count=20, first=20))
    for _, _, view, camera in drive(estimator, random, ids=[3, 4], count=20, first=40):
        assert set(camera.ids) == {3, 4}
        rotation, place = camera_pose(view)
        assert pose_error(camera, (rotation, place - on_wall(1)[1]))[0] < 0.02


def test_tags_with_the_same_id_are_not_used_for_the_wall(random):
    estimator = PoseEstimator(SIDE)
    for poses, truths, _, _ in drive(estimator, random, ids=[1, 2, 3, 3, 4], count=20):
        assert max(pose_error(pose, truth)[0] for pose, truth in zip(poses, truths)) < 0.01
    assert set(estimator.camera().ids) == {1, 2, 4}


@pytest.mark.parametrize('known', [None, TAGS_WALL], ids=['learned', 'given'])
def test_the_pose_of_the_area_is_accurate(known, random):
    estimator, nees_values = PoseEstimator(SIDE, wall=known), []
    corners = TAGS_WALL.area_corners
    for number, (_, _, view, _) in enumerate(drive(estimator, random, count=40)):
        pixels = project(corners, *view, Camera())[0] + random.normal(0, 0.05, (4, 2))
        pose = estimator.area(Area(np.float32(pixels)), PINHOLE)
        if number > 5:
            truth = view[0], view[0] @ corners.mean(axis=0) + view[1]
            assert pose_error(pose, truth)[0] < 0.01 and pose_error(pose, truth)[1] < 0.3
            assert pose.width == pytest.approx(0.9, abs=0.003) and pose.height == pytest.approx(0.6, abs=0.003)
            nees_values.append(nees(pose, truth))
    assert np.mean(nees_values) < 9


def test_an_area_without_a_wall_has_no_pose(random):
    estimator, area = PoseEstimator(SIDE), Area(np.float32([[100, 100], [200, 100], [200, 200], [100, 200]]))
    assert estimator.area(area, PINHOLE) is None and estimator.camera() is None
    list(drive(estimator, random, count=10))
    assert estimator.area(area, PINHOLE) is not None
    assert estimator.area(Area(np.full((4, 2), np.nan)), PINHOLE) is None
    assert estimator.update([], PINHOLE, 1.0) == []
    assert estimator.area(area, PINHOLE) is None and estimator.camera() is None


def test_a_carried_pose_has_the_right_place_and_covariance(random):
    rotation, place = rotation_matrices(np.array([[0.3, -0.8, 0.2]]))[0], np.array([0.5, 0.4, 2.0])
    spread = np.diag([1e-3, 2e-3, 1e-3, 4e-3, 2e-3, 3e-3])
    arm_turn, arm = rotation_matrices(np.array([[0.1, 1.2, -0.3]]))[0], np.array([0.2, 0.35, -1.0])
    carried = CameraPose(rotation, place, spread @ spread, (1, 2)).carry(arm_turn, arm)
    np.testing.assert_allclose(carried.rotation, rotation @ arm_turn)
    np.testing.assert_allclose(carried.translation, rotation @ arm + place)
    off = random.normal(size=(20000, 6)) @ spread
    moved = np.einsum('nij,j->ni', rotation_matrices(off[:, 3:]) @ rotation, arm) + place + off[:, :3]
    found = np.cov(np.hstack([moved, off[:, 3:]]).T)  # the camera's turn is also that of what it carries
    np.testing.assert_allclose(found, carried.covariance, atol=0.05 * carried.covariance.max())
