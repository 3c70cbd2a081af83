"""Properties of the geometry that hold for all numbers."""
import cv2
import numpy as np
from aruco_ar import Area, CameraPose, Lens, PoseEstimator, Tag, find_area, order_coordinates
from aruco_ar.geometry.homography import homography_to, transform
from aruco_ar.geometry.ordering import is_quadrilateral
from aruco_ar.geometry.plane_pose import rotation_matrices, rotation_vector
from aruco_ar.painting.fit import fit_picture
from aruco_ar.tags.tag import square
from aruco_node.messages import pose_messages
from hostile.pictures.pipeline import faults_of_paint
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from rospy import Time

UNIT = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
same_each_time = settings(max_examples=60, deadline=None, derandomize=True)


def numbers(low, high, count):
    return st.lists(st.floats(low, high), min_size=count, max_size=count).map(np.array)


@st.composite
def areas(draw, reach=150.0):
    """(4, 2): a convex quadrilateral around (160, 120), clockwise from its top left."""
    off = draw(numbers(-0.2 * reach, 0.2 * reach, 8)).reshape(4, 2)
    corners = draw(st.floats(0.3, 1)) * reach * (2 * UNIT - 1) + off
    assume(is_quadrilateral(corners))
    return corners + [160, 120]


@st.composite
def scattered_tags(draw):
    """Tags with different ids, of any size, anywhere."""
    place = st.tuples(st.integers(0, 640), st.integers(0, 480))
    centers = draw(st.lists(place, min_size=4, max_size=8, unique=True))
    return [Tag(number, np.float32(draw(st.integers(4, 60)) * (UNIT - 0.5) + center))
            for number, center in enumerate(centers)]


rotations = numbers(-1.7, 1.7, 3).map(lambda angles: rotation_matrices(angles[None])[0])
shifts = numbers(-2, 2, 3)


@given(scattered_tags(), st.randoms(use_true_random=False))
@same_each_time
def test_the_area_does_not_depend_on_the_order_of_the_tags(tags, random):
    mixed = list(tags)
    random.shuffle(mixed)
    one, other = find_area(tags), find_area(mixed)
    assert (one is None) == (other is None)
    if one is not None:
        span = [cv2.contourArea(area.corners) for area in (one, other)]
        np.testing.assert_allclose(*span, rtol=1e-5)  # if two areas are equally large, either is right
        assert is_quadrilateral(one.corners)
        np.testing.assert_array_equal(one.corners, order_coordinates(one.corners))


@given(areas(), st.integers(-200, 200), st.integers(-200, 200), st.sampled_from([0.5, 2, 4]))
@same_each_time
def test_an_area_moves_and_scales_with_its_tags(corners, right, down, scale):
    def seen(scale, shift):
        return find_area([Tag(number, np.float32(scale * (10 * UNIT - 5 + corner) + shift))
                          for number, corner in enumerate(corners)])
    before, after = seen(1, 0), seen(scale, [right, down])
    assume(before is not None and after is not None)
    np.testing.assert_allclose(after.corners, scale * before.corners + [right, down], atol=0.01)
    np.testing.assert_allclose(after.ratio, before.ratio, rtol=1e-3)


@given(areas())
@same_each_time
def test_a_homography_to_corners_maps_there_and_back(corners):
    there = homography_to(corners)
    np.testing.assert_allclose(transform(there, UNIT), corners, atol=1e-6)
    np.testing.assert_allclose(transform(np.linalg.inv(there), corners), UNIT, atol=1e-6)
    np.testing.assert_allclose(Tag(1, corners).center, transform(there, np.array([[0.5, 0.5]]))[0], atol=1e-3)


@given(numbers(-0.2, 0.2, 2), numbers(-0.002, 0.002, 2), numbers(-0.45, 0.45, 16))
@same_each_time
def test_a_pixel_of_a_ray_maps_back_to_that_ray(bend, skew, rays):
    rays = rays.reshape(-1, 2)
    for lens in (Lens(640, 480, np.diag([550.0, 540, 1]), np.append(bend, skew)),
                 Lens(640, 480, np.diag([550.0, 540, 1]), np.append(bend, skew), fisheye=True)):
        pixels = lens.project(np.column_stack([rays, np.ones(len(rays))]))
        np.testing.assert_allclose(lens.rays(pixels), rays, atol=1e-8)


@given(areas(), st.floats(0.2, 5), st.integers(1, 300), st.integers(1, 300))
@same_each_time
def test_a_fitted_picture_keeps_its_proportions(corners, ratio, width, height):
    picture, area = np.zeros((height, width, 3), np.uint8), Area(np.float32(corners), ratio)
    whole, inner = fit_picture(picture, area, 'contain')
    assert whole.tolist() == [[0, 0], [width, 0], [width, height], [0, height]]
    place = transform(np.linalg.inv(homography_to(corners)), np.float64(inner.corners))
    across, down = place[2] - place[0]
    assert place.min() > -1e-3 and place.max() < 1.001 and max(across, down) > 0.999
    np.testing.assert_allclose(across * ratio * height, down * width, rtol=0.01, atol=0.01 * height * ratio)
    part, outer = fit_picture(picture, area, 'cover')
    assert outer is area
    kept = part[2] - part[0]
    assert np.isclose(kept, (width, height)).any()  # no more is cut off than necessary
    assert np.all(kept < (width + 1e-3, height + 1e-3)) and np.isclose(kept[0], kept[1] * ratio, 1e-3)
    np.testing.assert_allclose(part.mean(axis=0), (width / 2, height / 2), atol=1e-3)


@given(areas(reach=250.0), st.integers(0, 99), st.sampled_from([1, -1]))
@same_each_time
def test_only_the_area_is_painted(corners, seed, way):
    random = np.random.RandomState(seed)
    frame = random.randint(0, 256, (240, 320, 3)).astype(np.uint8)
    area = Area(np.float32(corners[::way]), random.choice([None, 0.5, 3.0]))
    assert list(faults_of_paint(frame, area, random)) == []


@given(st.floats(0.3, 1.0), st.floats(-3, 3), st.floats(-3, 3), st.floats(-0.3, 0.3), st.floats(0.4, 2))
@same_each_time
def test_the_pose_of_a_tag_seen_without_noise_is_exact(slant, axis, roll, aside, far):
    lens = Lens(640, 480, np.array([[550.0, 0, 320], [0, 550, 240], [0, 0, 1]]), np.array([]))
    rotation = rotation_matrices(np.array([[slant * np.cos(axis), slant * np.sin(axis), 0]]))[0] @ \
        rotation_matrices(np.array([[0, 0, roll]]))[0] @ np.diag([1.0, -1, -1])
    place = np.array([aside * far, -aside * far / 2, far])
    pixels = lens.project(square([0.18])[0] @ rotation.T + place)
    pose, = PoseEstimator(0.18).update([Tag(1, pixels)], lens, 0.0)
    np.testing.assert_allclose(pose.translation, place, atol=1e-4)
    assert np.linalg.norm(rotation_vector(pose.rotation @ rotation.T)) < 1e-3


@given(numbers(-1, 1, 24), st.floats(-3, 1), st.floats(0, 4))
@same_each_time
def test_every_covariance_is_valid(deviations, size, far):
    """Tags of 1 mm to 10 m, at any distance relative to their size, with wrong corners."""
    lens, size = Lens(640, 480, np.array([[550.0, 0, 320], [0, 550, 240], [0, 0, 1]]), np.array([])), 10**size
    tags = []
    for number, (off, x) in enumerate(zip(deviations.reshape(3, 4, 2), (-1, 0, 1))):
        place = np.array([1.5 * x, 0.2, 3 + far * 10]) * size
        rotation = rotation_matrices(np.array([[np.pi - 0.4, 0.3, 0]]))[0]
        pixels = lens.project(square([size])[0] @ rotation.T + place)
        tags.append(Tag(number, pixels + 0.3 * off))
    estimator = PoseEstimator(size)
    for frame in range(5):
        poses = estimator.update(tags, lens, frame / 30)
    for pose in [*poses, *([estimator.camera()] if estimator.camera() else [])]:
        scale = np.sqrt(pose.covariance.diagonal())
        correlation = pose.covariance / np.outer(scale, scale)
        assert np.abs(correlation - correlation.T).max() < 1e-6
        assert np.linalg.eigvalsh((correlation + correlation.T) / 2).min() > -1e-9


@given(rotations, shifts, rotations, shifts, rotations, shifts, numbers(-1, 1, 36))
@same_each_time
def test_carrying_a_pose_twice_equals_once(rotation, place, turn, shift, other_turn, other_shift, root):
    root = root.reshape(6, 6)
    pose = CameraPose(rotation, place, root @ root.T, (1,))
    twice, once = pose.carry(turn, shift).carry(other_turn, other_shift), \
        pose.carry(turn @ other_turn, turn @ other_shift + shift)
    for one, other in zip((twice.rotation, twice.translation, twice.covariance),
                          (once.rotation, once.translation, once.covariance)):
        np.testing.assert_allclose(one, other, atol=1e-9)


@given(rotations, shifts, shifts, numbers(-1, 1, 36))
@same_each_time
def test_the_covariance_of_a_carried_pose_follows_from_small_moves(rotation, place, shift, root):
    """The expected covariance uses numerical derivatives by small shifts and turns of the camera."""
    def carried(change):
        pose = CameraPose(rotation_matrices(change[None, 3:])[0] @ rotation, place + change[:3], np.eye(6), ())
        return pose.carry(np.eye(3), shift).translation
    step, root = 1e-6, root.reshape(6, 6)
    slopes = np.array([carried(change) - carried(-change) for change in step * np.eye(6)]).T / (2 * step)
    spread = CameraPose(rotation, place, root @ root.T, ()).carry(np.eye(3), shift).covariance
    np.testing.assert_allclose(spread[:3, :3], slopes @ root @ root.T @ slopes.T, atol=1e-6)


@given(numbers(-1, 1, 3), st.floats(0, 3.141592), shifts)
@same_each_time
def test_a_pose_survives_a_round_trip_through_its_message(axis, angle, place):
    assume(np.linalg.norm(axis) > 0.1)
    rotation = cv2.Rodrigues(angle * axis / np.linalg.norm(axis))[0]
    message = pose_messages.transform(CameraPose(rotation, place, np.eye(6), ()), Time(1), 'camera', 'tag')
    back, shift = pose_messages.from_transform(message.transform)
    np.testing.assert_allclose(back, rotation, atol=1e-6)
    np.testing.assert_array_equal(shift, place)
