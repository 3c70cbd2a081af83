"""Exercise 5.6: right solutions pass, in whatever style, and each mistake is named, alone and with another."""
from dataclasses import replace

import aruco_ar
import cv2
import numpy as np
import pytest
from aruco_course.check import Shown
from aruco_course.exercises.exercise5_6.check import CHECK, judge
from rig.learners import find, gray, shrink

WHITE = (255, 255, 255)
VIEWS = CHECK.views()
SOME = VIEWS[:4]  # the first is seen straight on


def ordered(image):
    """The centers, (4, 2) int32, in order."""
    points = find(image)[0].mean(axis=1)
    total, difference = points.sum(axis=1), np.diff(points, axis=1).ravel()
    order = [total.argmin(), difference.argmin(), total.argmax(), difference.argmax()]
    return points[order].astype(np.int32)


def masked(image, points):
    return cv2.fillConvexPoly(np.zeros_like(image), np.asarray(points, np.int32), WHITE)


def warp(image, picture, points, size=None, flags=cv2.INTER_LINEAR):
    """The picture, warped to these points. ``size``: what it is thought to have, (width, height)."""
    width, height = size or picture.shape[1::-1]
    homography, _ = cv2.findHomography(np.array([[0, 0], [width, 0], [width, height], [0, height]]), points)
    return cv2.warpPerspective(picture, homography, image.shape[1::-1], flags=flags)


def paint(image, picture, points=None, area=None, **options):
    """What is right; or in other points, and another area that is subtracted."""
    points = ordered(image) if points is None else points
    black = cv2.subtract(image, masked(image, points if area is None else area))
    return cv2.add(black, warp(image, picture, points, **options))


def course(image, picture):
    """As in the course: shrunk, with a circle at each center, both of its orders, and a smooth rim."""
    image = shrink(image)
    points = ordered(image)
    for x, y in points.tolist():
        cv2.circle(image, (x, y), 3, (255, 255, 0), -1)
    height, width = picture.shape[:2]
    homography, _ = cv2.findHomography(np.array([[0, 0], [width, 0], [0, height], [width, height]]),
                                       points[[0, 1, 3, 2]])
    warped = cv2.warpPerspective(picture, homography, image.shape[1::-1])
    mask = np.zeros_like(image)
    cv2.fillConvexPoly(mask, points, WHITE, cv2.LINE_AA)
    return cv2.add(warped, cv2.subtract(image, mask))


def numpy_only(image, picture):
    """The picture is put where a white picture of its size gets to."""
    points = ordered(image)
    white = warp(image, np.full_like(picture, 255), points)
    image[white > 0] = warp(image, picture, points)[white > 0]
    return image


def marked(image, picture):
    corners, ids = find(image)
    painted = paint(image, picture)
    cv2.polylines(painted, [ordered(image)], True, (0, 0, 255), 3)
    return cv2.aruco.drawDetectedMarkers(painted, list(corners[:, None].astype(np.float32)), ids)


def ours(image, picture):
    return aruco_ar.overlay(image, picture, aruco_ar.find_area(aruco_ar.Detector().detect(image)))


def said(function, views=SOME):
    """What the judge says of the learner's function: a sentence, or None."""
    fault = judge([Shown(number, view, (function(view.frame.copy(), view.picture),))
                   for number, view in enumerate(views, start=1)])
    return fault and str(fault)


RIGHT = {
    'plain': paint, 'course': course, 'NumPy only': numpy_only, 'ours': ours, 'tags and rim marked': marked,
    'gray': lambda image, picture: gray(paint(image, picture)),
    'enlarged again': lambda image, picture: cv2.resize(course(image, picture), (640, 480)),
    'nearest pixels': lambda image, picture: paint(image, picture, flags=cv2.INTER_NEAREST),
    'Lanczos': lambda image, picture: paint(image, picture, flags=cv2.INTER_LANCZOS4),
}


@pytest.mark.parametrize('name', RIGHT)
def test_right_solution_passes(name):
    assert said(RIGHT[name], VIEWS) is None


@pytest.mark.parametrize('name', RIGHT)
def test_right_solution_passes_with_the_packages_picture(name, earth):
    assert said(RIGHT[name], [replace(view, picture=earth) for view in VIEWS]) is None


def in_order(*order):
    """A learner's function that lists the centers in another order for the homography."""
    return lambda image, picture: paint(image, picture, ordered(image)[list(order)], ordered(image))


def composed(compose):
    """A learner's function that makes something else of the frame, the warped picture, and the white mask."""
    def function(image, picture):
        points = ordered(image)
        return compose(image, warp(image, picture, points), masked(image, points))
    return function


def upright(image):
    x, y, width, height = cv2.boundingRect(ordered(image))
    return np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])


def backward(image, picture):
    width, height = picture.shape[1::-1]
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    homography, _ = cv2.findHomography(ordered(image), corners)
    black = cv2.subtract(image, masked(image, ordered(image)))
    return cv2.add(black, cv2.warpPerspective(picture, homography, image.shape[1::-1]))


def of_three(image, picture):
    width, height = picture.shape[1::-1]
    points = ordered(image)
    corners = np.float32([[0, 0], [width, 0], [width, height]])
    matrix = cv2.getAffineTransform(corners, points[:3].astype(np.float32))
    return cv2.add(cv2.subtract(image, masked(image, points)),
                   cv2.warpAffine(picture, matrix, image.shape[1::-1]))


def pasted(image, picture):
    (height, width), (rows, columns) = picture.shape[:2], image.shape[:2]
    image[:height, :width] = picture[:rows, :columns]
    return image


def first_corners(image, picture):
    corners = find(image)[0][:, 0]
    total, difference = corners.sum(axis=1), np.diff(corners, axis=1).ravel()
    order = [total.argmin(), difference.argmin(), total.argmax(), difference.argmax()]
    return paint(image, picture, corners[order])


@pytest.mark.parametrize('function, says', [
    (in_order(2, 3, 0, 1), 'upside down: it is turned by 180 degrees'),
    (in_order(1, 0, 3, 2), 'mirrored: its left and its right'),
    (in_order(3, 2, 1, 0), 'upside down and mirrored'),
    (in_order(1, 2, 3, 0), 'by a quarter, clockwise'),
    (in_order(3, 0, 1, 2), 'by a quarter, counterclockwise'),
    (in_order(0, 3, 2, 1), 'its rows are columns'),
    (in_order(0, 1, 3, 2), 'twisted: its corners go to the tags 1, 2, 4, 3'),
    (lambda image, picture: paint(image, picture, area=ordered(image)[[0, 1, 3, 2]]), 'crosses itself'),
    (composed(lambda image, warped, mask: cv2.add(image, warped)), 'added to the wall'),
    (composed(lambda image, warped, mask: image + warped), "NumPy's plus"),
    (composed(lambda image, warped, mask: warped), 'only the picture is to be seen'),
    (composed(lambda image, warped, mask: cv2.subtract(image, mask)), 'the area is black'),
    (composed(lambda image, warped, mask: image), 'the frame as it came'),
    (composed(lambda image, warped, mask: cv2.addWeighted(image, 0.5, warped, 0.5, 0)), 'half transparent'),
    (composed(lambda image, warped, mask: np.where(warped > 0, warped, image)), 'where the picture is dark'),
    (composed(lambda image, warped, mask: cv2.add(cv2.add(image, mask), warped)), 'the mask was added'),
    (composed(lambda image, warped, mask: np.zeros_like(image)), 'black all over'),
    (lambda image, picture: paint(image, picture[:, :, ::-1].copy()), "picture's colors are exchanged"),
    (lambda image, picture: paint(image, picture)[:, :, ::-1], 'colors of your image are exchanged'),
    (lambda image, picture: paint(image, cv2.cvtColor(gray(picture), cv2.COLOR_GRAY2BGR)), 'no colors'),
    (lambda image, picture: paint(image, picture, size=picture.shape[:2]), 'width and height are exchanged'),
    (lambda image, picture: paint(image, picture, size=image.shape[1::-1]), 'does not fill the area'),
    (lambda image, picture: paint(image, picture, upright(image)), 'an upright rectangle around the centers'),
    (lambda image, picture: paint(image, picture, ordered(shrink(image))), '0.7 times as far'),
    (lambda image, picture: cv2.resize(picture, (640, 480)), 'covers the whole frame'),
    (backward, 'the homography goes the wrong way'), (of_three, 'parallelogram'), (pasted, 'not warped'),
    (first_corners, 'not through their centers'),
    (lambda image, picture: cv2.putText(paint(image, picture), 'ROS', (520, 40), 0, 1, WHITE, 2), 'at the top'),
])
def test_mistake_is_named(function, says):
    assert says in said(function)


def test_two_mistakes_are_named():
    sentence = said(lambda image, picture: in_order(1, 0, 3, 2)(image, picture[:, :, ::-1].copy()))
    assert 'mirrored' in sentence
    assert 'colors are exchanged' in sentence


def test_area_of_an_earlier_frame_is_named():
    first = ordered(VIEWS[0].frame)
    assert 'is still that of frame 1' in said(lambda image, picture: paint(image, picture, first))


def test_fault_comes_with_what_was_expected():
    view = VIEWS[0]
    fault = judge([Shown(1, view, (view.frame,))])
    assert fault.expected.shape == fault.shown.image.shape == fault.marked.shape + (3,)
    assert said(lambda image, picture: fault.expected, [view]) is None


@pytest.mark.parametrize('challenge', CHECK.challenges, ids=lambda challenge: challenge.name)
def test_challenge_fails_the_course_but_can_be_met(challenge):
    def judged(function):
        return challenge.judge([Shown(number, view, (function(*view.arguments),))
                                for number, view in enumerate(challenge.views(), start=1)])
    assert judged(ours) is None
    if challenge.name != 'one id twice':  # the course takes any four
        try:
            assert judged(paint) is not None
        except (ValueError, cv2.error):
            pass  # without tags, there is nothing to put in order
