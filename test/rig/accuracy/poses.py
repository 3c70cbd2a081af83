"""Tags on simulated drives, with computed instead of detected corners, and how far off poses are."""
from dataclasses import replace

import numpy as np
from aruco_ar import Lens, Tag
from aruco_ar.geometry.plane_pose import rotation_matrices, rotation_vector
from aruco_ar.simulation.robot import Camera, wall_to_camera
from aruco_ar.tags.tag import square

from rig.accuracy.drives import LIVELY, WALL

SIDE = 0.2  # meters: the side of each tag
TAGS_WALL = replace(WALL, tags=tuple(replace(tag, side=SIDE) for tag in WALL.tags))
BENT = Camera(distortion=[-0.3, 0.1, 0, 0, 0])
NOISE_PX = 0.03
AREA = [1, 2, 3, 4]


def lens_of(camera):
    """The Lens of a simulated Camera."""
    return Lens(camera.width, camera.height, camera.matrix, np.float64(camera.distortion))


PINHOLE = lens_of(Camera())


def true_pose(tag, rotation, translation):
    """(R, t): the pose of a WallTag in the camera. The arguments are that of the wall."""
    top_left, top_right, _, bottom_left = tag.corners
    right, up = (top_right - top_left) / tag.side, (top_left - bottom_left) / tag.side
    axes = np.stack([right, up, np.cross(right, up)], axis=1)
    return rotation @ axes, rotation @ [tag.x, tag.y, 0] + translation


def error_of(rotation, translation, truth):
    """(6,): the error of a pose in meters and radians, in the order of its covariance."""
    return np.concatenate([translation - truth[1], rotation_vector(rotation @ truth[0].T)])


def pose_error(pose, truth):
    """(meters, degrees): how far off a pose is."""
    error = error_of(pose.rotation, pose.translation, truth)
    return np.linalg.norm(error[:3]), np.degrees(np.linalg.norm(error[3:]))


def nees(pose, truth):
    """The normalized estimation error squared: 6 on average if the pose's covariance is right."""
    error = error_of(pose.rotation, pose.translation, truth)
    return error @ np.linalg.inv(pose.covariance) @ error


def camera_pose(view):
    """(R, t): the camera's true pose in wall coordinates."""
    return view[0].T, -view[0].T @ view[1]


def tag_at(tag_id, pose, random, lens=PINHOLE, size=SIDE, noise=NOISE_PX):
    """The Tag that a lens shows of a tag at a pose (R, t) in the camera, with noise in pixels."""
    pixels = lens.project(square([size])[0] @ pose[0].T + pose[1])
    return Tag(tag_id, np.float32(pixels + random.normal(0, noise, (4, 2))))


def drive(estimator, random, places=lambda number: {}, ids=AREA, count=60, first=0, **look):
    """Yields the poses, the true poses, the view and the CameraPose for each frame of a lively drive.

    ``places``: a function of the frame's number that returns {id: (R, t)}, the wall poses of displaced tags.
    """
    for number in range(first, first + count):
        view = wall_to_camera(LIVELY.at(number / 30)[0])
        truth = {tag.id: true_pose(tag, *view) for tag in TAGS_WALL.tags}
        for tag_id, (rotation, translation) in places(number).items():
            truth[tag_id] = view[0] @ rotation, view[0] @ translation + view[1]
        tags = [tag_at(tag_id, truth[tag_id], random, **look) for tag_id in ids]
        poses = estimator.update(tags, look.get('lens', PINHOLE), number / 30)
        assert [pose.id for pose in poses] == list(ids)
        yield poses, [truth[tag_id] for tag_id in ids], view, estimator.camera()


def on_wall(tag_id, shift=(0, 0, 0), turn=(0, 0, 0)):
    """The pose on the wall of a tag that is shifted, and turned about its center."""
    tag = next(tag for tag in TAGS_WALL.tags if tag.id == tag_id)
    return rotation_matrices(np.array([turn]))[0], np.array([tag.x, tag.y, 0]) + shift
