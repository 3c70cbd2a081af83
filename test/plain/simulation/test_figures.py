"""Somebody moves in front of the simulated wall."""
import numpy as np
import pytest
from aruco_ar.simulation.figures import SHIRT, SKIN
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera

FRONT = wall_to_camera(Pose(-2.25, 0.0, 0.0))


def columns_of(frame, color):
    """The columns of the pixels that have a color."""
    return np.nonzero(np.all(frame == color, axis=2))[1]


def test_a_person_walks_from_the_left_to_the_right_and_back(wall):
    renderer = WallRenderer(wall, Camera())
    places = [columns_of(renderer.render(*FRONT, visitor='person', seconds=seconds), SHIRT).mean()
              for seconds in (1.0, 2.0, 3.0, 4.0)]
    assert np.all(np.diff(places) > 50)
    back = columns_of(renderer.render(*FRONT, visitor='person', seconds=8.0), SHIRT).mean()
    assert back == pytest.approx(places[3], abs=2)


def test_a_hand_comes_in_writes_and_hides_what_is_behind_it_only(wall):
    renderer = WallRenderer(wall, Camera())
    bare, before, writing = (renderer.render(*FRONT, visitor=visitor, seconds=seconds)
                             for visitor, seconds in (('nobody', 5.0), ('hand', 0.0), ('hand', 5.0)))
    skin = columns_of(writing, SKIN)
    assert len(skin) > 2000 and len(columns_of(bare, SKIN)) == 0
    changed = np.any(writing != bare, axis=2)
    assert len(skin) < np.count_nonzero(changed) < 0.4 * changed.size
    assert np.array_equal(before[:200], bare[:200])


def test_a_visitor_is_in_front_of_the_wall_from_where_the_camera_is(wall):
    renderer = WallRenderer(wall, Camera())
    turned = wall_to_camera(Pose(-2.25, 0.0, 0.15))  # to the left, so the person is seen farther right
    here, there = (columns_of(renderer.render(*view, visitor='person', seconds=3.0), SHIRT).mean()
                   for view in (FRONT, turned))
    assert there > here + 40
    near = wall_to_camera(Pose(-0.4, 0.0, 0.0))
    assert np.array_equal(renderer.render(*near, visitor='person', seconds=3.0), renderer.render(*near))
