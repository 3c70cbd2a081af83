"""What is drawn on frames."""
import numpy as np
import pytest
from aruco_ar.geometry.lens import Lens
from aruco_ar.painting.marks import mark_poses
from aruco_ar.poses.estimator import TagPose
from aruco_ar.simulation.robot import Camera
from aruco_ar.tags.tag import Tag

RED, GREEN = (0, 0, 255), (0, 255, 0)


@pytest.mark.parametrize('top', [3, 12, 40, 414])
def test_an_id_hides_no_axis_of_its_tag_wherever_it_is_in_the_frame(top):
    lens, side, far = Lens(640, 480, Camera().matrix, np.zeros(5)), 60.0, 1.5
    center = np.array([120, top + side / 2])
    corners = center + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2
    size = side / lens.matrix[0, 0] * far
    faces_us = np.diag([1.0, -1, -1])
    pose = TagPose(7, corners, size, faces_us, np.append(lens.rays(center), 1) * far, np.eye(6), 0.0)
    seen = mark_poses(np.full((480, 640, 3), 255, np.uint8), [Tag(7, corners)], [pose], lens)
    for direction, color in (([1, 0], RED), ([0, -1], GREEN)):
        for along in (0.1, 0.2, 0.3, 0.4):
            x, y = np.round(center + np.multiply(direction, along * side)).astype(int)
            assert np.abs(seen[y, x].astype(int) - color).sum() < 60, (direction, along)
