"""Exercises 5.3 and 5.4: right solutions pass, in whatever style, and each mistake is named."""
import re

import cv2
import numpy as np
import pytest
from aruco_course.judge.polygon_judge import judge_centers, judge_order
from aruco_course.judge.views import area_views
from rig.learners import fault_of, find, gray, shrink

PURPLE = (255, 0, 150)
SOME = [area_views()[index] for index in (1, 3, 6, 7)]  # these are enough for what is wrong in each frame


def four(image):
    """The centers as found."""
    return find(image)[0].mean(axis=1)


def ordered(points):
    total, difference = points.sum(axis=1), np.diff(points, axis=1).ravel()
    return points[[total.argmin(), difference.argmin(), total.argmax(), difference.argmax()]]


def crossing_of_diagonals(quads):
    centers = []
    for a, b, c, d in quads.astype(float):
        first, second = np.cross([*a, 1], [*c, 1]), np.cross([*b, 1], [*d, 1])
        x, y, w = np.cross(first, second)
        centers.append((x / w, y / w))
    return np.array(centers)


def fill(image, points, color=PURPLE):
    cv2.drawContours(image, [points.astype(np.int32)], -1, color, -1)
    return image


def lines(image, points, width=2, color=(0, 0, 255), kind=cv2.LINE_8):
    cv2.polylines(image, [np.round(points).astype(np.int32)], True, color, width, kind)
    return image


def course(image, sort=True, also_unsorted=True):
    """As in the course's text."""
    h, w = image.shape[:2]
    image = cv2.resize(image, (int(w * 0.7), int(h * 0.7)))
    quads, _ = find(image)
    params = []
    for c in quads:
        cv2.circle(image, (int(c[:, 0].mean()), int(c[:, 1].mean())), 3, (255, 255, 6), -1)
        params.append((int(c[:, 0].mean()), int(c[:, 1].mean())))
    params = np.array(params)
    if also_unsorted:
        cv2.drawContours(image, [params], -1, (255, 0, 150), -1)
    if sort and len(params) >= 4:
        s, diff = params.sum(axis=1), np.diff(params, axis=1)
        params = np.array([params[np.argmin(s)], params[np.argmin(diff)], params[np.argmax(s)],
                           params[np.argmax(diff)]])
        cv2.drawContours(image, [params], -1, (255, 0, 150), -1)
    return image


def translucent(image, points):
    return cv2.addWeighted(fill(image.copy(), points), 0.4, image, 0.6, 0)


def with_words(image, points):
    lines(fill(image, points), points, 3, (0, 255, 255))
    for number, (x, y) in enumerate(points.astype(int)):
        cv2.circle(image, (int(x), int(y)), 8, (0, 0, 255), -1)
        cv2.putText(image, 'corner %d (%d, %d)' % (number, x, y), (int(x) - 40, int(y) - 12),
                    cv2.FONT_HERSHEY_DUPLEX, 0.7, (255, 255, 255), 2, cv2.LINE_AA)
    cv2.putText(image, 'exercise', (20, 40), cv2.FONT_HERSHEY_COMPLEX, 1.5, (0, 0, 0), 3)
    return image


def with_detected_markers(image, points):
    gray_image = gray(image)
    corners, ids, _ = cv2.aruco.ArucoDetector(
        cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)).detectMarkers(gray_image)
    return lines(cv2.aruco.drawDetectedMarkers(image, corners, ids), points)


def subpixel(image, points):
    cv2.polylines(image, [np.round(points * 16).astype(np.int32)], True, (0, 255, 0), 1, cv2.LINE_AA, 4)
    return image


def around_the_middle(points):
    arms = points - points.mean(axis=0)
    return points[np.argsort(np.arctan2(arms[:, 1], arms[:, 0]))]


# Ways to draw a polygon that is given.
DRAWN = {
    'filled': fill,
    'filled with green': lambda image, points: fill(image, points, (0, 255, 0)),
    'filled with black': lambda image, points: fill(image, points, (0, 0, 0)),
    'filled with white': lambda image, points: fill(image, points, (255, 255, 255)),
    'fillPoly': lambda image, points: cv2.fillPoly(image, [np.int32(points)], PURPLE, cv2.LINE_AA),
    'fillConvexPoly': lambda image, points: cv2.fillConvexPoly(image, np.int32(points), PURPLE, cv2.LINE_AA),
    'thin lines': lambda image, points: lines(image, points, 1),
    'thin smooth lines': lambda image, points: lines(image, points, 1, kind=cv2.LINE_AA),
    'white lines': lambda image, points: lines(image, points, 2, (255, 255, 255)),
    'black lines': lambda image, points: lines(image, points, 1, (0, 0, 0)),
    'wide lines': lambda image, points: lines(image, points, 15),
    'very wide lines': lambda image, points: lines(image, points, 30),
    'filled, with wide lines': lambda image, points: lines(fill(image, points), points, 9),
    'drawContours with lines': lambda image, points: cv2.drawContours(image, [np.int32(points)], 0, (9, 9, 9),
                                                                      3),
    'subpixel': subpixel,
    'translucent': translucent,
    'words and circles': with_words,
    'drawDetectedMarkers': with_detected_markers,
    'gray': lambda image, points: fill(gray(image), points, 120),
    'gray lines': lambda image, points: lines(gray(image), points, 2, 255),
    'gray in the end': lambda image, points: gray(fill(image, points)),
    'color on gray': lambda image, points: lines(cv2.cvtColor(gray(image), cv2.COLOR_GRAY2BGR), points),
    'shrunk in the end': lambda image, points: shrink(fill(image, points)),
    'shrunk in the end, lines': lambda image, points: shrink(lines(image, points, 1)),
}


@pytest.mark.parametrize('way', DRAWN)
@pytest.mark.parametrize('share', [1, 0.7])
def test_right_order_passes(way, share):
    def learner(image):
        image = image if share == 1 else shrink(image, share)
        return DRAWN[way](image, ordered(four(image)))
    assert fault_of(judge_order, learner, SOME) is None
    assert fault_of(judge_centers, learner, SOME) is None


@pytest.mark.parametrize('way', DRAWN)
@pytest.mark.parametrize('share', [1, 0.7])
def test_as_found_passes_5_3_but_not_5_4(way, share):
    def learner(image):
        image = image if share == 1 else shrink(image, share)
        return DRAWN[way](image, four(image))
    assert fault_of(judge_centers, learner, SOME) is None
    said = fault_of(judge_order, learner, SOME)
    assert 'crosses itself' in said or way == 'fillConvexPoly'


def resized(draw, image, *how):
    small = shrink(image, *how)
    return draw(small, ordered(four(small)))


def bounds(image):
    left, top, width, height = cv2.boundingRect(four(image).astype(np.float32))
    right, foot = left + width, top + height
    return np.array([[left, top], [right, top], [right, foot], [left, foot]])


RIGHT = {
    'the course': course,
    'around the middle': lambda image: fill(image, around_the_middle(four(image))),
    'hull': lambda image: fill(image, cv2.convexHull(four(image).astype(np.float32))[:, 0]),
    'the other way around': lambda image: lines(image, ordered(four(image))[::-1]),
    'crossing of the diagonals': lambda image: lines(image, ordered(crossing_of_diagonals(find(image)[0])), 1),
    'opposite corners': lambda image: fill(image, ordered(find(image)[0][:, [0, 2]].mean(axis=1))),
    'truncated': lambda image: lines(image, ordered(four(image).astype(int)), 1),
    'argmin and argmax exchanged': lambda image: fill(image, -ordered(-four(image))),
    'INTER_AREA': lambda image: resized(fill, image, 0.7, cv2.INTER_AREA),
    'found in the whole frame, drawn scaled': lambda image: lines(shrink(image), ordered(four(image) * 0.7), 1),
    'a channel more': lambda image: cv2.cvtColor(fill(image, ordered(four(image))), cv2.COLOR_BGR2BGRA),
    'enlarged': lambda image: resized(lines, image, 1.5),
}


@pytest.mark.parametrize('learner', RIGHT)
def test_right_order_passes_in_other_ways(learner):
    assert fault_of(judge_order, RIGHT[learner], area_views()) is None
    assert fault_of(judge_centers, RIGHT[learner], area_views()) is None


def test_the_courses_5_3_passes():
    assert fault_of(judge_centers, lambda image: course(image, sort=False), area_views()) is None


def by(key):
    return lambda image: four(image)[np.argsort(key(four(image)), kind='stable')]


def by_id(image):
    quads, ids = find(image)
    return quads[np.argsort(ids)].mean(axis=1)


def unset(image):
    """The course's rule with an index that is used twice, so that one place stays (0, 0)."""
    points, result = four(image), np.zeros((4, 2))
    total, difference = points.sum(axis=1), np.diff(points, axis=1)
    result[0], result[2] = points[total.argmin()], points[total.argmax()]
    result[1] = points[difference.argmin()]
    result[1] = points[difference.argmax()]
    return result


WRONG_ORDERS = {
    'as found': (four, 'the order in which they were found'),
    'by id': (by_id, 'sorted by id'),
    'by x': (by(lambda points: points[:, 0]), 'column by column'),
    'by y': (by(lambda points: points[:, 1]), 'row by row'),
    'by the sum': (by(lambda points: points.sum(axis=1)), r'sorted by x or by x \+ y alone'),
    'by the difference': (by(lambda points: points[:, 1] - points[:, 0]), 'column by column'),
    'last two exchanged': (lambda image: ordered(four(image))[[0, 1, 3, 2]], 'row by row'),
    'second and third exchanged': (lambda image: ordered(four(image))[[0, 2, 1, 3]], 'crosses itself'),
    'one is unset': (unset, r'\(0, 0\)'),
    'argmin twice': (lambda image: ordered(four(image))[[0, 1, 2, 2]], 'only three corners'),
    'axes apart': (lambda image: np.sort(four(image), axis=0), 'sorted each by itself'),
    'rectangle': (lambda image: cv2.boxPoints(cv2.minAreaRect(four(image).astype(np.float32))), 'a rectangle'),
    'bounds': (bounds, 'upright rectangle'),
}


@pytest.mark.parametrize('way, share', [('filled', 0.7), ('thin lines', 1), ('wide lines', 0.7)])
@pytest.mark.parametrize('mistake', WRONG_ORDERS)
def test_wrong_orders_are_named(mistake, way, share):
    points, words = WRONG_ORDERS[mistake]

    def learner(image):
        image = image if share == 1 else shrink(image, share)
        return DRAWN[way](image, points(image))
    said = fault_of(judge_order, learner, area_views())
    assert said is not None
    assert re.search(words, said), said


def only_these_ids(image):
    quads, ids = find(image)
    by_tag = dict(zip(ids.tolist(), quads.mean(axis=1)))
    if not {1, 2, 3, 4} <= set(by_tag):
        return image
    return fill(image, around_the_middle(np.array([by_tag[i] for i in (1, 2, 3, 4)])))


def first_corners(image):
    return around_the_middle(find(image)[0][:, 0])


def shrunk_back(image):
    points = four(shrink(image))
    return fill(image, points)


def dots(image):
    points = four(image).astype(np.int32)
    cv2.drawContours(image, points[:, None], -1, (255, 0, 150), 3)
    return image


def open_lines(image):
    cv2.polylines(image, [np.int32(four(image))], False, (0, 255, 0), 2)
    return image


def outlines_only(image):
    for quad in find(image)[0]:
        cv2.polylines(image, [np.int32(quad)], True, (0, 255, 0), 2)
    return image


WRONG = {
    'nothing': (lambda image: image, 'nothing is drawn'),
    'nothing, on gray': (gray, 'nothing is drawn'),
    'only the ids 1 to 4': (only_these_ids, 'an id may be any, not only 1 to 4'),
    'first corners': (lambda image: fill(image, first_corners(image)), 'first corners, not through'),
    'first corners, as lines': (lambda image: lines(image, first_corners(image), 1),
                                'first corners, not through'),
    'third corners': (lambda image: fill(image, around_the_middle(find(image)[0][:, 2])), 'third corners, not'),
    'middles of sides': (lambda image: fill(image, around_the_middle(find(image)[0][:, :2].mean(axis=1))),
                         'middles of the tags'),
    'three centers': (lambda image: fill(image, four(image)[:3]), 'three corners'),
    'three centers, as lines': (lambda image: lines(image, four(image)[1:]), 'three corners'),
    'two centers': (lambda image: lines(image, four(image)[:2]), 'no line goes from the center of tag'),
    'axes exchanged': (lambda image: fill(image, four(image)[:, ::-1]), 'x and y are exchanged'),
    'axes exchanged, as lines': (lambda image: lines(image, four(image)[:, ::-1]), 'x and y are exchanged'),
    'too small': (shrunk_back, 'too near to the top left'),
    'too large': (lambda image: lines(shrink(image), four(image)), 'too far to the right'),
    'all corners': (lambda image: fill(image, find(image)[0].reshape(-1, 2)), 'all corners of all tags'),
    'all corners, as lines': (lambda image: lines(image, find(image)[0].reshape(-1, 2), 1),
                              'all corners of all'),
    'around all': (lambda image: fill(image, cv2.convexHull(find(image)[0].reshape(-1, 2))[:, 0]),
                   'around all tags'),
    'dots': (dots, 'only points at the centers'),
    'open': (open_lines, 'is open'),
    'tags only': (outlines_only, 'no polygon'),
    'tags filled': (lambda image: cv2.fillPoly(image, list(np.int32(find(image)[0])), PURPLE), 'no polygon'),
    'on black': (lambda image: fill(np.zeros_like(image), four(image)), 'on a black image'),
    'colors exchanged': (lambda image: fill(image, four(image))[:, :, ::-1],
                         'colors of your image are exchanged'),
    'size exchanged': (lambda image: fill(cv2.resize(image, (336, 448)), four(image)), 'pixels wide and'),
    'upside down': (lambda image: fill(image, ordered(four(image)))[::-1], 'upside down'),
    'everything': (lambda image: cv2.rectangle(image, (0, 0), (640, 480), PURPLE, -1), 'one color only'),
    'around the middle of the frame': (lambda image: fill(image, np.array([[160, 120], [480, 120], [480, 360],
                                                                            [160, 360]])), 'polygon'),
}


@pytest.mark.parametrize('judge', [judge_centers, judge_order])
@pytest.mark.parametrize('mistake', WRONG)
def test_mistakes_are_named(mistake, judge):
    learner, words = WRONG[mistake]
    said = fault_of(judge, learner, SOME)
    assert said is not None
    assert re.search(words, said), said
    assert said.startswith('Frame ')
