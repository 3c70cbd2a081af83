"""Exercise 5.2: right solutions pass, in whatever style, and each mistake is named."""
import re

import cv2
import numpy as np
import pytest
from aruco_course.judge.outline_judge import judge_tags, tag_views
from rig.learners import DICTIONARY, fault_of, find, gray, shrink


def detected(image):
    return cv2.aruco.ArucoDetector(DICTIONARY, cv2.aruco.DetectorParameters()).detectMarkers(gray(image))


def outline(image, quad, color=(0, 255, 0), width=2, kind=cv2.LINE_8):
    cv2.polylines(image, [np.round(quad).astype(np.int32)], True, color, width, kind)


def write(image, text, place, font=cv2.FONT_HERSHEY_SIMPLEX, scale=0.6, color=(0, 0, 255), width=2):
    cv2.putText(image, str(text), tuple(int(number) for number in place), font, scale, color, width)


def each(outline_it, write_it, texts=lambda ids: ids, quads=lambda quads: quads):
    """A learner who outlines each tag, then writes at each one."""
    def learner(image):
        found, ids = find(image)
        for quad in quads(found):
            outline_it(image, quad)
        for quad, text in zip(found, texts(ids)):
            write_it(image, text, quad)
        return image
    return learner


def above(image, text, quad):
    write(image, text, quad.min(axis=0) - (0, 6))


def course(image):
    height, width = image.shape[:2]
    image = cv2.resize(image, (int(width * 0.7), int(height * 0.7)))
    corners, ids, _ = detected(image)
    return cv2.aruco.drawDetectedMarkers(image.copy(), corners, ids)


def draw_detected(image, color=(0, 255, 0)):
    corners, ids, _ = detected(image)
    return cv2.aruco.drawDetectedMarkers(image, corners, ids, color)


def line_by_line(image):
    found, ids = find(image)
    for quad, tag_id in zip(found, ids):
        points = [tuple(point) for point in quad.astype(int).tolist()]
        for start, end in zip(points, points[1:] + points[:1]):
            cv2.line(image, start, end, (255, 0, 0), 1)
        cv2.circle(image, tuple(quad.mean(axis=0).astype(int).tolist()), 4, (0, 0, 255), -1)
        write(image, 'id: %d' % tag_id, quad[0] - (10, 10), cv2.FONT_HERSHEY_PLAIN, 1, (0, 0, 160), 1)
    return image


def translucent(image):
    found, ids = find(image)
    layer = cv2.fillPoly(image.copy(), list(np.int32(found)), (0, 255, 255))
    image = cv2.addWeighted(layer, 0.5, image, 0.5, 0)
    for quad, tag_id in zip(found, ids):
        write(image, tag_id, quad.mean(axis=0) - (12, -5))
    return image


def filled(image):
    found, ids = find(image)
    for quad, tag_id in zip(found, ids):
        cv2.fillPoly(image, [np.int32(quad)], (200, 0, 0))
        write(image, tag_id, quad.mean(axis=0) - (12, -5), color=(255, 255, 255))
    return image


RIGHT = {
    'drawDetectedMarkers': draw_detected,
    'the course': course,
    'drawDetectedMarkers on gray': lambda image: draw_detected(cv2.cvtColor(gray(image), cv2.COLOR_GRAY2BGR)),
    'gray in the end': lambda image: gray(draw_detected(image)),
    'shrunk in the end': lambda image: shrink(draw_detected(image)),
    'half': lambda image: draw_detected(shrink(image, 0.75, cv2.INTER_AREA)),
    'above': each(outline, above),
    'thin': each(lambda image, quad: outline(image, quad, (0, 0, 255), 1), above),
    'smooth': each(lambda image, quad: outline(image, quad, (255, 0, 0), 1, cv2.LINE_AA), above),
    'white': each(lambda image, quad: outline(image, quad, (255, 255, 255), 2), above),
    'black': each(lambda image, quad: outline(image, quad, (0, 0, 0), 1), above),
    'wide': each(lambda image, quad: outline(image, quad, (255, 0, 255), 7), above),
    'drawContours': each(lambda image, quad: cv2.drawContours(image, [np.int32(quad)], -1, (9, 200, 9), 3),
                         above),
    'line by line': line_by_line,
    'at the first corner': each(outline, lambda image, text, quad: write(image, text, quad[0])),
    'in the middle': each(outline, lambda image, text, quad: write(image, text, quad.mean(axis=0))),
    'below, large': each(outline, lambda image, text, quad: write(
        image, text, (quad[:, 0].min(), quad[:, 1].max() + 30), scale=1)),
    'with a word': each(outline, lambda image, text, quad: write(image, 'Tag ID: %d' % text, quad.min(axis=0))),
    'small, one pixel wide': each(outline, lambda image, text, quad: write(
        image, text, quad.min(axis=0), scale=0.4, width=1)),
    'in brackets': each(outline, above, lambda ids: [[number] for number in ids]),
    'script': each(outline, lambda image, text, quad: write(image, text, quad.min(axis=0),
                                                            cv2.FONT_HERSHEY_SCRIPT_COMPLEX)),
    'translucent': translucent,
    'filled': filled,
}


@pytest.mark.parametrize('learner', RIGHT)
def test_right_solutions_pass(learner):
    assert fault_of(judge_tags, RIGHT[learner], tag_views()) is None


def rejected(image):
    return cv2.aruco.drawDetectedMarkers(image, detected(image)[2])


def first_only(image):
    found, ids = find(image)
    outline(image, found[0])
    above(image, ids[0], found[0])
    return image


def after_the_loop(image):
    found, ids = find(image)
    for quad in found:
        outline(image, quad)
    above(image, ids[len(found) - 1], quad)
    return image


def found_small(image):
    found, ids = find(shrink(image))
    for quad, tag_id in zip(found, ids):
        outline(image, quad)
        above(image, tag_id, quad)
    return image


def found_large(image):
    small = shrink(image)
    for quad, tag_id in zip(*find(image)):
        outline(small, quad)
        above(small, tag_id, quad)
    return small


def other_dictionary(name):
    def learner(image):
        for quad, tag_id in zip(*find(image, cv2.aruco.getPredefinedDictionary(name))):
            outline(image, quad)
            above(image, tag_id, quad)
        return image
    return learner


def only_1_to_4(image):
    for quad, tag_id in zip(*find(image)):
        if tag_id in (1, 2, 3, 4):
            outline(image, quad)
            above(image, tag_id, quad)
    return image


def on_a_copy(image):
    draw_detected(image.copy())
    return image


def in_one_place(image):
    found, ids = find(image)
    for quad in found:
        outline(image, quad)
    write(image, ', '.join(map(str, ids)), (10, 30))
    return image


def box(image, quad):
    x, y, width, height = cv2.boundingRect(np.int32(quad))
    cv2.rectangle(image, (x, y), (x + width, y + height), (0, 255, 0), 2)


def diagonal_box(image, quad):
    (x, y), (end_x, end_y) = np.int32(quad[[0, 2]]).tolist()
    cv2.rectangle(image, (x, y), (end_x, end_y), (0, 255, 0), 2)


WRONG = {
    'nothing': (lambda image: image, 'nothing is drawn'),
    'on a copy': (on_a_copy, 'Do you return the image'),
    'on gray, the frame returned': (lambda image: (draw_detected(cv2.cvtColor(gray(image), 8)), image)[1],
                                    'nothing is drawn'),
    'rejected': (rejected, 'rejected'),
    'first only': (first_only, 'only one tag is outlined'),
    'after the loop': (after_the_loop, 'is not written'),
    'axes exchanged': (each(lambda image, quad: outline(image, quad[:, ::-1]), above), 'x and y are exchanged'),
    'found in the small one': (found_small, 'too near to the top left'),
    'found in the large one': (found_large, 'too far to the right'),
    'another dictionary': (other_dictionary(cv2.aruco.DICT_4X4_50), 'dictionary'),
    'a small dictionary': (other_dictionary(cv2.aruco.DICT_6X6_50), 'ids from 50 on'),
    'only 1 to 4': (only_1_to_4, 'an id may be any'),
    'position': (each(outline, above, lambda ids: range(len(ids))), 'position in the list'),
    'position from 1': (each(outline, above, lambda ids: range(1, 1 + len(ids))), 'position in the list'),
    'position of the sorted ids': (each(outline, above, lambda ids: np.argsort(np.argsort(ids))),
                                   'position in the list'),
    'sorted': (each(outline, above, sorted), 'is written at tag'),
    'reversed': (each(outline, above, lambda ids: ids[::-1]), 'is written at tag'),
    'the first id': (each(outline, above, lambda ids: [ids[0]] * len(ids)),
                     'is written at tag|is not written|same'),
    'a constant': (each(outline, above, lambda ids: ['id'] * len(ids)), 'the same is written for'),
    'all ids at each': (each(outline, above, lambda ids: [list(ids)] * len(ids)), 'written at'),
    'no ids': (each(outline, lambda image, text, quad: None), 'their ids are not written'),
    'no ids, drawDetectedMarkers': (lambda image: cv2.aruco.drawDetectedMarkers(
        image, [quad[None] for quad in find(image)[0]]), 'their ids are not written'),
    'no ids, translucent': (lambda image: cv2.addWeighted(cv2.fillPoly(
        image.copy(), list(np.int32(find(image)[0])), (0, 255, 255)), 0.5, image, 0.5, 0), 'the id of each'),
    'in one place': (in_one_place, 'not beside their tags'),
    'open': (each(lambda image, quad: cv2.polylines(image, [np.int32(quad)], False, (0, 255, 0), 2), above),
             'not closed'),
    'crossed': (each(lambda image, quad: outline(image, quad[[0, 1, 3, 2]]), above), 'cross themselves'),
    'one line': (lambda image: cv2.polylines(image, [np.int32(find(image)[0].reshape(-1, 2))], True, 255),
                 'one line goes through'),
    'boxes': (each(box, above), 'upright rectangles around'),
    'boxes between corners': (each(diagonal_box, above), 'upright rectangles between'),
    'points': (each(lambda image, quad: cv2.drawContours(image, np.int32(quad)[:, None], -1, 255, 4), above),
               'not outlined, though something'),
    'only ids': (each(lambda image, quad: None, above), 'not outlined, though something'),
    'on black': (lambda image: cv2.addWeighted(draw_detected(image), 1, image, -1, 0), 'black'),
    'colors exchanged': (lambda image: draw_detected(image)[:, :, ::-1], 'colors of your image are exchanged'),
    'upside down': (lambda image: draw_detected(image)[::-1], 'upside down'),
}


@pytest.mark.parametrize('mistake', WRONG)
def test_mistakes_are_named(mistake):
    learner, words = WRONG[mistake]
    said = fault_of(judge_tags, learner, tag_views())
    assert said is not None
    assert re.search(words, said), said
    assert said.startswith('Frame ')
