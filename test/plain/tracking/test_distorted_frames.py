"""The area in frames that a lens distorts."""
from dataclasses import replace

import numpy as np
import pytest
from aruco_ar import Tracker
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera, Path, Pose, wall_to_camera
from aruco_ar.walls.wall import Poster
from rig.accuracy.drives import LIVELY, WALL, drive

pytestmark = pytest.mark.long
LENSES = {'k1 = -0.3': {'distortion': [-0.3, 0.0, 0.0, 0.0, 0.0]},
          'barrel': {'distortion': [-0.3, 0.1, 0.001, 0.001, 0.0]},
          'pincushion': {'distortion': [0.2, 0.0, 0.0, 0.0, 0.0]},
          'fisheye': {'distortion': [0.05, 0.01, -0.01, 0.002], 'fisheye': True}}
FRAME = [639, 479]
# Points all over the area. In its plane, the corners are (0, 0), (1, 0), (1, 1), (0, 1).
GRID = np.stack(np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)), axis=-1).reshape(-1, 2)
# To the right, until two of the four tags are out of view, and back.
ASIDE = Path(Pose(-2.2, 0.25, -0.05), ((2, 0.3, 0.1), (1, 0.0, -0.08)))


def errors_in_view(path, count, lens, is_known=True):
    """(n,) pixels: in each frame, how far off the worst point of the area is that the frame shows."""
    camera, tracker = Camera(**lens), Tracker()
    known = camera.lens if is_known else None
    top_left, top_right, _, bottom_left = WALL.area_corners
    points = top_left + GRID[:, :1] * (top_right - top_left) + GRID[:, 1:] * (bottom_left - top_left)
    worst = []
    for frame in drive(path, count, noise=2.0, **lens):
        area = tracker.update(frame.image, frame.stamp, known)
        truth, _ = project(points, *wall_to_camera(path.at(frame.stamp)[0]), camera)
        found = transform(homography_to(area.undistorted), GRID)
        found = found if area.lens is None else area.lens.distort(found)
        in_view = ((truth > 0) & (truth < FRAME)).all(axis=1)
        worst.append(np.linalg.norm(found - truth, axis=1)[in_view].max())
    return np.array(worst)


@pytest.mark.parametrize('name', LENSES)
def test_the_whole_area_is_where_the_lens_shows_the_wall(name):
    assert errors_in_view(LIVELY, 60, LENSES[name]).max() < 0.3


def test_without_its_lens_the_middle_of_the_area_is_off_by_pixels():
    assert errors_in_view(LIVELY, 10, LENSES['barrel'], is_known=False).min() > 1


@pytest.mark.parametrize('name', LENSES)
def test_the_area_may_be_partly_out_of_view(name):
    worst = errors_in_view(ASIDE, 80, LENSES[name])
    assert np.median(worst) < 0.3 and worst.max() < 1


def test_tags_are_reported_where_the_detector_finds_them():
    lens, tracker = Camera(**LENSES['barrel']).lens, Tracker()
    plain = Tracker()  # without a lens, so its corners are as they were found
    for frame in drive(LIVELY, 5, **LENSES['barrel']):
        tracker.update(frame.image, frame.stamp, lens)
        plain.update(frame.image, frame.stamp)
        for tag, other in zip(*(sorted(each.tags, key=lambda tag: tag.id) for each in (tracker, plain))):
            np.testing.assert_allclose(tag.corners, other.corners, atol=0.05)


def test_a_lens_that_becomes_known_later_is_used_from_then_on():
    camera, tracker = Camera(**LENSES['barrel']), Tracker()
    for number, frame in enumerate(drive(LIVELY, 6, **LENSES['barrel'])):
        lens = camera.lens if number >= 3 else None
        area = tracker.update(frame.image, frame.stamp, lens)
        assert area is not None and area.lens is lens


def test_the_texture_holds_the_area_in_distorted_frames_too(package):
    painting = replace(WALL, posters=(Poster(package + '/images/earth.jpg', 0, 0.55, 1.5, 1.0),))
    lens, tracker = Camera(**LENSES['barrel']).lens, Tracker()
    for number, frame in enumerate(drive(LIVELY, 100, lambda number: WALL.area if number >= 60 else (),
                                         wall=painting, **LENSES['barrel'])):
        area = tracker.update(frame.image, frame.stamp, lens)
        assert np.abs(area.corners - frame.corners).max() < (1 if number >= 60 else 0.3)
