"""The lens: from rays to pixels and back, compared with OpenCV's projection."""
import cv2
import numpy as np
import pytest
from aruco_ar import Lens
from aruco_ar.simulation.render import WallRenderer, project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.tags.corner_rays import corner_rays
from aruco_ar.tags.edges import fit_tags
from aruco_ar.tags.tag import tag_cells

MATRIX = np.array([[554.0, 0, 319.5], [0, 560, 240.5], [0, 0, 1]])
LENSES = {
    'none': Lens(640, 480, MATRIX, np.array([])),
    'plumb_bob': Lens(640, 480, MATRIX, np.array([-0.3, 0.1, 0.001, -0.002, 0.01])),
    'four numbers': Lens(640, 480, MATRIX, np.array([-0.3, 0.1, 0.001, -0.002])),
    'rational': Lens(640, 480, MATRIX, np.array([0.5, -0.2, 0.001, -0.001, 0.01, 0.8, -0.1, 0.02])),
    'thin prism': Lens(640, 480, MATRIX, np.array([-0.2, 0.1, 0, 0, 0, 0, 0, 0, 0.01, 0.002, -0.01, 0.001])),
    'fisheye': Lens(640, 480, MATRIX, np.array([0.1, 0.02, -0.01, 0.003]), fisheye=True),
}


def opencv_pixels(lens, points):
    function = cv2.fisheye.projectPoints if lens.fisheye else cv2.projectPoints
    return function(points[:, None], np.zeros(3), np.zeros(3), lens.matrix, lens.distortion)[0][:, 0]


@pytest.mark.parametrize('lens', LENSES.values(), ids=LENSES)
def test_rays_are_the_inverse_of_opencvs_projection(lens, random):
    pixels = random.uniform((0, 0), (639, 479), (200, 2))
    rays = lens.rays(pixels)
    points = np.column_stack([rays, np.ones(200)]) * random.uniform(0.5, 5, (200, 1))
    np.testing.assert_allclose(opencv_pixels(lens, points), pixels, atol=1e-6)
    np.testing.assert_allclose(lens.project(points), pixels, atol=1e-6)


@pytest.mark.parametrize('lens', LENSES.values(), ids=LENSES)
def test_the_derivatives_of_the_projection_are_right(lens, random):
    rays, step = random.uniform(-0.4, 0.4, (20, 2)), 1e-6
    pixels, slopes = lens.project_rays(rays)
    for axis in (0, 1):
        moved, _ = lens.project_rays(rays + step * np.eye(2)[axis])
        np.testing.assert_allclose((moved - pixels) / step, slopes[:, :, axis], rtol=1e-3, atol=0.01)


def test_rays_have_the_shape_of_the_pixels():
    lens = LENSES['plumb_bob']
    assert lens.rays(np.zeros((3, 4, 2), np.float32)).shape == (3, 4, 2)
    assert lens.rays([320, 240]).dtype == np.float64
    assert lens.rays(np.zeros((0, 2))).shape == (0, 2)


@pytest.mark.parametrize('lens', LENSES.values(), ids=LENSES)
def test_points_that_the_lens_does_not_show_are_nan(lens):
    assert np.isnan(lens.project([[0, 0, -1.0], [0, 0, 0], [np.nan, 0, 1]])).all()
    rays = lens.rays([[np.nan, 1], [np.inf, 1], [320, 240]])
    assert np.isnan(rays[0]).all() and not np.isfinite(rays[1]).all() and np.isfinite(rays[2]).all()


def test_pixels_beyond_the_fold_of_a_lens_have_no_ray():
    folding = Lens(640, 480, MATRIX, np.array([-0.8, 0, 0, 0, 0]))
    assert np.isnan(folding.rays([639, 479])).all()
    assert np.isfinite(folding.rays([340, 250])).all()


def test_the_bulge_of_edges_in_a_lens_with_distortion_is_corrected(wall):
    """The fitted corners of near tags are wrong, but their rays are not."""
    camera, view = Camera(distortion=[-0.3, 0.1, 0, 0, 0]), wall_to_camera(Pose(-1.5, 0.2, 0))
    lens = Lens(640, 480, camera.matrix, np.float64(camera.distortion))
    truth = np.array([project(tag.corners, *view, camera)[0] for tag in wall.tags])
    inside = ((truth > 5) & (truth < [634, 474])).all(axis=(1, 2))
    tags = [tag for tag, fits in zip(wall.tags, inside) if fits]
    cells = np.array([tag_cells(wall.dictionary, tag.id) for tag in tags])
    quads, found, _ = fit_tags(WallRenderer(wall, camera).render(*view), truth[inside], cells)
    assert len(tags) > 1 and found.all()
    plain, corrected = (np.sqrt(np.mean((rays - lens.rays(truth[inside]))**2)) * MATRIX[0, 0]
                        for rays in (lens.rays(quads), corner_rays(lens, quads)))
    assert corrected < 0.05 < 2 * corrected < plain
