"""order_coordinates compared with the course's rule, and the choice of four points among many."""
from itertools import combinations, permutations

import cv2
import numpy as np
import pytest
from aruco_ar import InputError, largest_quadrilateral, order_coordinates
from aruco_ar.geometry.ordering import is_quadrilateral
from benchmark.course import course_order
from hypothesis import given, settings
from hypothesis import strategies as st

coordinate = st.integers(-1000, 1000)
four_points = st.lists(st.tuples(coordinate, coordinate), min_size=4, max_size=4).map(np.array)


def turned_square(degrees, side=100.0):
    angle = np.radians(np.array([-135, -45, 45, 135]) + degrees)
    return side / np.sqrt(2) * np.stack([np.cos(angle), np.sin(angle)], axis=1) + 300


def sorted_rows(points):
    return sorted(map(tuple, points.tolist()))


@given(four_points)
@settings(max_examples=500, deadline=None)
def test_every_point_is_returned_exactly_once(points):
    assert sorted_rows(order_coordinates(points)) == sorted_rows(points)


@given(four_points)
@settings(max_examples=500, deadline=None)
def test_the_order_agrees_with_the_course_if_that_uses_each_point_once(points):
    order = course_order(points)
    if len(set(order)) == 4:
        assert np.array_equal(order_coordinates(points), points[order])


@given(four_points, st.permutations(range(4)))
@settings(max_examples=500, deadline=None)
def test_the_order_of_the_input_does_not_matter(points, shuffle):
    assert np.array_equal(order_coordinates(points), order_coordinates(points[shuffle]))


@pytest.mark.parametrize('degrees', range(-44, 45, 4))
def test_a_rotated_square_starts_at_its_top_left(degrees):
    square = turned_square(degrees)
    for shuffle in permutations(range(4)):
        np.testing.assert_allclose(order_coordinates(square[list(shuffle)]), square)


@pytest.mark.parametrize('degrees', [44.9, 45, 45.0001, 46, 134.9, 135])
def test_a_square_on_its_corner_remains_a_square(degrees):
    assert is_quadrilateral(order_coordinates(turned_square(degrees)))


def test_fractions_of_a_pixel_are_kept():
    points = np.float32([[0.25, 0.5], [10.75, 0.25], [10.5, 9.25], [0.5, 9.75]])
    assert order_coordinates(points[::-1]).dtype == np.float32
    np.testing.assert_array_equal(order_coordinates(points[::-1]), points)


@pytest.mark.parametrize('dtype', [np.int8, np.uint8, np.int64, np.float64])
def test_any_type_of_number_can_be_ordered(dtype):
    points = np.array([[100, 90], [10, 5], [110, 10], [5, 100]], dtype)
    ordered = order_coordinates(points)
    assert ordered.dtype == dtype
    assert ordered.tolist() == [[10, 5], [110, 10], [100, 90], [5, 100]]


@pytest.mark.parametrize('points', [[], [[1, 2]] * 3, [[1, 2, 3]] * 4,
                                    [[0, 0], [1, 0], [1, 1], [0, np.nan]]])
def test_anything_but_four_points_is_refused(points):
    with pytest.raises(InputError, match='four points'):
        order_coordinates(points)


def test_the_largest_quadrilateral_of_many_points_is_found(random):
    for _ in range(300):
        points = np.float32(random.uniform(0, 500, (random.randint(5, 10), 2)))
        hulls = [cv2.convexHull(points[list(four)]).reshape(-1, 2)
                 for four in combinations(range(len(points)), 4)]
        areas = [cv2.contourArea(hull) for hull in hulls if len(hull) == 4 and is_quadrilateral(hull)]
        found = largest_quadrilateral(points)
        assert (found is None) == (not areas)
        if areas:
            assert is_quadrilateral(found)
            assert cv2.contourArea(found) == pytest.approx(max(areas), rel=1e-4)


def test_a_quadrilateral_within_a_triangle_is_found():
    points = np.float32([(320, 40), (60, 440), (580, 440), (260, 300), (380, 300)])
    assert sorted_rows(largest_quadrilateral(points)) == sorted_rows(points[1:])


@pytest.mark.parametrize('points', [
    [], [[0, 0], [10, 0], [10, 10]],
    [[0, 0], [10, 10], [20, 20], [30, 30]],
    [[0, 0], [100, 0.5], [200, -0.5], [300, 0], [400, 0.4]],
    [[0, 0], [100, 0], [50, 90], [50, 30]],
    [[5, 5]] * 4])
def test_some_points_span_no_area(points):
    assert largest_quadrilateral(points) is None
